//! The operator of real programs: what is done about a robot that has latched, a fault that only an operator ends.

use onboard::symbols::faults::{Fault, FaultTable, Resumes};

/// A stall of the machine this long before a latch, or shorter, counts as its cause.
const BLAMED_NS: u64 = 2_000_000_000;
/// A latch is judged after this time: by then the watch has noted the stall that it came with.
const JUDGED_AFTER_NS: u64 = 100_000_000;
/// A robot that latched because of a stall is reset after this time, and not sooner again.
const RESET_AFTER_NS: u64 = 3_000_000_000;
/// A robot whose pose is uncertain may see walls again; after this time it is stranded.
const UNCERTAIN_NS: u64 = 30_000_000_000;

/// What to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Care {
    /// Nothing, yet.
    None,
    /// Reset the robot.
    Reset,
    /// End the run: this fault is the robot's own.
    GiveUp(Fault),
}

/// Looks after one robot.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Caretaker {
    reset_ns: u64,
    /// How often it was reset.
    pub(super) resets: u32,
}

impl Caretaker {
    /// What to do now about what the robot says of its faults; `stalled` tells whether the machine did between two times.
    pub(super) fn look(
        &mut self,
        faults: &FaultTable,
        now_ns: u64,
        stalled: impl Fn(u64, u64) -> bool,
    ) -> Care {
        let latched = { faults.active() }
            // Who stopped it on purpose is there, and goes on with it.
            .filter(|fault| fault.resumes() == Resumes::Operator && *fault != Fault::OperatorStop)
            .map(|fault| (fault, faults.state(fault).since_ns));
        let mut care = Care::None;
        for (fault, since_ns) in latched {
            let since = now_ns.saturating_sub(since_ns);
            if since < JUDGED_AFTER_NS {
                continue;
            }
            if stalled(since_ns.saturating_sub(BLAMED_NS), since_ns) {
                if since > RESET_AFTER_NS && now_ns > self.reset_ns + RESET_AFTER_NS {
                    care = Care::Reset;
                }
            } else if fault != Fault::PoseUncertain || since > UNCERTAIN_NS {
                return Care::GiveUp(fault);
            }
        }
        if care == Care::Reset {
            self.reset_ns = now_ns;
            self.resets += 1;
        }
        care
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND_NS: u64 = 1_000_000_000;

    fn latched(fault: Fault) -> FaultTable {
        let mut faults = FaultTable::default();
        faults.raise(fault, 10 * SECOND_NS);
        faults
    }

    #[test]
    fn a_latch_after_a_stall_is_reset_and_counted() {
        let faults = latched(Fault::Overruns);
        let mut caretaker = Caretaker::default();
        let stall_ns = 9 * SECOND_NS;
        let mut look = |at_ns| {
            let stalled = |from_ns, to_ns| (from_ns..=to_ns).contains(&stall_ns);
            (caretaker.look(&faults, at_ns, stalled), caretaker.resets)
        };
        assert_eq!(look(10 * SECOND_NS), (Care::None, 0));
        assert_eq!(look(12 * SECOND_NS), (Care::None, 0), "as a person does");
        assert_eq!(look(14 * SECOND_NS), (Care::Reset, 1));
        assert_eq!(look(15 * SECOND_NS), (Care::None, 1), "it takes a while");
        assert_eq!(look(18 * SECOND_NS), (Care::Reset, 2));
        let gone = caretaker.look(&FaultTable::default(), 30 * SECOND_NS, |_, _| true);
        assert_eq!((gone, caretaker.resets), (Care::None, 2));
    }

    #[test]
    fn any_other_latch_ends_the_run_at_once() {
        let look = |fault, at_s: f64| {
            let at_ns = (at_s * 1e9) as u64;
            // A stall long before it does not count.
            let stalled = |from_ns, _| from_ns <= 7 * SECOND_NS;
            Caretaker::default().look(&latched(fault), at_ns, stalled)
        };
        assert_eq!(look(Fault::Overruns, 10.05), Care::None);
        assert_eq!(look(Fault::Overruns, 10.2), Care::GiveUp(Fault::Overruns));
        assert_eq!(look(Fault::MotorsOff, 10.2), Care::GiveUp(Fault::MotorsOff));
        assert_eq!(look(Fault::OperatorStop, 100.0), Care::None);
        assert_eq!(look(Fault::BusLost, 100.0), Care::None, "ends by itself");
        let uncertain = Fault::PoseUncertain;
        assert_eq!(look(uncertain, 20.0), Care::None, "it may end by itself");
        assert_eq!(look(uncertain, 41.0), Care::GiveUp(uncertain));
    }

    #[test]
    fn what_is_the_robots_own_counts_more_than_a_stall() {
        let mut faults = latched(Fault::Overruns);
        faults.raise(Fault::DriveFault, 20 * SECOND_NS);
        let stalled = |_, to_ns| to_ns < 15 * SECOND_NS;
        let care = Caretaker::default().look(&faults, 21 * SECOND_NS, stalled);
        assert_eq!(care, Care::GiveUp(Fault::DriveFault));
    }
}
