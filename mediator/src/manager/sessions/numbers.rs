//! Whether a process can have reached the number of its report.
//!
//! One lie up to half of all numbers counts, and the robot goes on from there. A mediator that is started then, or takes over, knows
//! nothing of that: to it the robot's first number is beyond what a process reaches.

use contract::client::{LAST_NUMBER, is_reached_from};
use contract::wire::RobotReport;

/// A process of which nothing has counted yet has a number up to this one, if it has said no smaller one: the quarter above half
/// is for robots that go on from a lie, the last one for lies about them.
pub(super) const MOST_AT_FIRST: u64 = LAST_NUMBER / 4 * 3;

/// Whether to believe the number of a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Belief {
    Yes,
    /// Perhaps the process says a smaller one yet: this one is somebody else's then.
    NotYet,
    No,
}

/// A process that has reported under a number beyond half of all, and none below it since.
#[derive(Clone, Copy, Debug)]
struct Beyond {
    boot_epoch: u64,
    since_ns: u64,
}

/// The numbers of a robot's reports.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Numbers(Option<Beyond>);

impl Numbers {
    /// Whether a process, of which this `newest` report has counted (0: none), can have sent so many by now. What says so otherwise is
    /// of somebody who speaks in its name. One of which nothing has counted yet is believed a larger number when it has said none
    /// smaller for `patience_ns`: could the robot not go on from there, it would be heard no more.
    pub(super) fn judge(
        &mut self,
        newest: u64,
        report: &RobotReport,
        now_ns: u64,
        patience_ns: u64,
    ) -> Belief {
        let (boot_epoch, sequence) = (report.boot_epoch, report.sequence);
        if is_reached_from(newest, sequence) {
            self.0.take_if(|own| own.boot_epoch == boot_epoch);
            return Belief::Yes;
        }
        if newest > 0 || sequence > MOST_AT_FIRST {
            return Belief::No;
        }
        let known = self.0.filter(|own| own.boot_epoch == boot_epoch);
        let own = known.unwrap_or(Beyond {
            boot_epoch,
            since_ns: now_ns,
        });
        self.0 = Some(own);
        if now_ns > own.since_ns.saturating_add(patience_ns) {
            Belief::Yes
        } else {
            Belief::NotYet
        }
    }
}
