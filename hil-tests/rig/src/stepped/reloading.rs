//! An operator who changes a robot's file while it drives, has it read again, and later puts back what was there.

use onboard::cli::Files;
use onboard::composition::plan::Plan;
use onboard::process::ctl::Request;

use super::asking::Asking;
use super::robot::SteppedRobot;

/// Asked again after this time, where it did not come to a stand.
const AGAIN_NS: u64 = 10_000_000_000;
/// The key that is changed,
const KEY: &str = "drive.max_speed_m_s";
/// and never to less than this.
const SLOWEST_M_S: f64 = 0.05;

/// Reloads one robot.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reloading(Asking);

impl Reloading {
    /// The file was changed.
    pub(super) fn want(&mut self) {
        self.0.want();
    }

    /// Looks after a robot whose file says a top speed that is lower by this share than its own. Nothing is to be done while somebody has
    /// it in hands, or has paused it: it is `held`.
    pub(super) fn look(
        &mut self,
        robot: &mut SteppedRobot,
        (files, plan): (&Files, &Plan),
        (share, held): (f64, bool),
        now_ns: u64,
    ) {
        let due = self.0.is_due(robot, &Request::Reload, AGAIN_NS, now_ns);
        // Nobody asks twice before there is an answer.
        if due && !held && !robot.owes_an_answer() {
            let mut files = files.clone();
            files.set.retain(|own| !own.starts_with(KEY));
            let top_m_s = plan.robot.drive.limits.max_speed_m_s * (1.0 - share);
            files
                .set
                .push(format!("{KEY}={:?}", top_m_s.max(SLOWEST_M_S)));
            robot.reload_from(files);
            self.0.ask(robot, Request::Reload, now_ns);
        }
    }
}
