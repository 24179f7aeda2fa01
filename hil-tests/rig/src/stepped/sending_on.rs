//! An operator sends on a robot that was paused, or driven by hand: when nobody holds it any more and no fault does, and again
//! where one came in between.

use onboard::process::ctl::Request;
use onboard::symbols::faults::{FaultTable, Resumes};

use super::robot::SteppedRobot;

/// Asked again after this time.
const AGAIN_NS: u64 = 1_000_000_000;

/// Sends one robot on.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SendingOn {
    wanted: bool,
    /// When it was asked, and how many replies there were before.
    asked: Option<(u64, usize)>,
}

impl SendingOn {
    /// Somebody wants the robot to go on.
    pub(super) fn want(&mut self) {
        *self = Self {
            wanted: true,
            asked: None,
        };
    }

    /// Looks after a robot with these faults. Nothing is to be done while it is `held` by whoever paused it or drives it.
    pub(super) fn look(
        &mut self,
        robot: &mut SteppedRobot,
        faults: &FaultTable,
        held: bool,
        now_ns: u64,
    ) {
        if let Some((at_ns, replies)) = self.asked {
            let done = { robot.replies().into_iter().skip(replies) }
                .any(|(name, reply)| name == Request::Resume.name() && reply.is_ok());
            self.wanted &= !done;
            if now_ns < at_ns + AGAIN_NS {
                return;
            }
        }
        let latched = faults
            .active()
            .any(|fault| fault.resumes() == Resumes::Operator);
        if self.wanted && !held && !latched {
            self.asked = Some((now_ns, robot.replies().len()));
            robot.ask(Request::Resume);
        }
    }
}
