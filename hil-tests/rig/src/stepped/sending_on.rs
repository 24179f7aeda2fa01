//! An operator sends on a robot that was paused, or driven by hand: when nobody holds it any more and no fault does, and again
//! where one came in between.

use onboard::process::ctl::Request;
use onboard::symbols::faults::{FaultTable, Resumes};

use super::asking::Asking;
use super::robot::SteppedRobot;

/// Asked again after this time.
const AGAIN_NS: u64 = 1_000_000_000;

/// Sends one robot on.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SendingOn(Asking);

impl SendingOn {
    /// Somebody wants the robot to go on.
    pub(super) fn want(&mut self) {
        self.0.want();
    }

    /// Looks after a robot with these faults. Nothing is to be done while it is `held` by whoever paused it or drives it.
    pub(super) fn look(
        &mut self,
        robot: &mut SteppedRobot,
        faults: &FaultTable,
        held: bool,
        now_ns: u64,
    ) {
        let due = self.0.is_due(robot, &Request::Resume, AGAIN_NS, now_ns);
        let latched = faults
            .active()
            .any(|fault| fault.resumes() == Resumes::Operator);
        if due && !held && !latched {
            self.0.ask(robot, Request::Resume, now_ns);
        }
    }
}
