//! An operator restarts the program of a robot that the mediator refuses, once the clone that it was taken for is gone: to the
//! mediator the next process is another one (`contract/PROTOCOL.md`).

use onboard::symbols::faults::{Fault, FaultTable};

/// An operator comes when a robot was refused for this long with nobody of its name beside it, and not sooner again.
const AFTER_NS: u64 = 10_000_000_000;

/// Restarts one robot.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Restarting {
    /// Refused since then.
    since_ns: Option<u64>,
    /// How often it was restarted.
    pub(super) times: u32,
}

impl Restarting {
    /// Looks after a robot with these faults. `clone`: whether one of it is there; none: there was
    /// none. Returns whether it is to be restarted.
    pub(super) fn look(&mut self, faults: &FaultTable, clone: Option<bool>, now_ns: u64) -> bool {
        let is_refused = faults.state(Fault::MediatorRefused).active != 0;
        if !is_refused || clone != Some(false) {
            self.since_ns = None;
            return false;
        }
        let since_ns = *self.since_ns.get_or_insert(now_ns);
        let due = now_ns >= since_ns + AFTER_NS;
        if due {
            self.since_ns = None;
            self.times += 1;
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND_NS: u64 = 1_000_000_000;

    #[test]
    fn who_is_refused_is_restarted_once_its_clone_is_gone_and_not_sooner_again() {
        let mut faults = FaultTable::default();
        faults.raise(Fault::MediatorRefused, 0);
        let mut restarting = Restarting::default();
        let mut look = |clone, at_s| restarting.look(&faults, clone, at_s * SECOND_NS);
        assert!(!look(Some(true), 20), "it is there");
        assert!(!look(Some(false), 21) && !look(Some(false), 30));
        assert!(look(Some(false), 31));
        assert!(!look(Some(false), 32) && !look(Some(false), 41));
        assert!(look(Some(false), 42));
        assert_eq!(restarting.times, 2);
    }

    #[test]
    fn whom_nobody_was_taken_for_has_to_say_itself_why_it_is_refused() {
        let mut faults = FaultTable::default();
        faults.raise(Fault::MediatorRefused, 0);
        let mut restarting = Restarting::default();
        assert!(
            !restarting.look(&faults, None, 0) && !restarting.look(&faults, None, 100 * SECOND_NS)
        );
        faults.clear(Fault::MediatorRefused);
        let clone = Some(false);
        assert!(
            !restarting.look(&faults, clone, 0)
                && !restarting.look(&faults, clone, 100 * SECOND_NS)
        );
    }
}
