//! An operator who asks a robot for something again and again, until it is done.

use onboard::process::ctl::Request;

use super::robot::SteppedRobot;

/// Asks one robot.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Asking {
    wanted: bool,
    /// When it was asked, and how many replies there were before.
    asked: Option<(u64, usize)>,
}

impl Asking {
    /// From now on somebody wants it.
    pub(super) fn want(&mut self) {
        *self = Self {
            wanted: true,
            asked: None,
        };
    }

    /// Whether it is still wanted, and was not asked for within the last `again_ns`.
    pub(super) fn is_due(
        &mut self,
        robot: &SteppedRobot,
        request: &Request,
        again_ns: u64,
        now_ns: u64,
    ) -> bool {
        if let Some((at_ns, replies)) = self.asked {
            let done = { robot.replies().into_iter().skip(replies) }
                .any(|(name, reply)| name == request.name() && reply.is_ok());
            self.wanted &= !done;
            if now_ns < at_ns + again_ns {
                return false;
            }
        }
        self.wanted
    }

    /// Asks for it.
    pub(super) fn ask(&mut self, robot: &mut SteppedRobot, request: Request, now_ns: u64) {
        self.asked = Some((now_ns, robot.replies().len()));
        robot.ask(request);
    }
}
