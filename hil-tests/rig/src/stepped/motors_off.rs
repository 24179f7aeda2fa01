//! Who must wait for an operator by truth: a robot whose motors were off for so long that its process has seen it, whatever becomes of that
//! process.

use onboard::symbols::faults::Fault;

/// So many exchanges with a drive whose motors are off: more than a process needs to see it, to write it down, or to be found to hang.
const SEEN_EXCHANGES: u64 = 1500;

/// What is owed to one robot's operator.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MotorsOff {
    /// Exchanges of this process with the drive at the last step.
    before: u64,
    /// So many while the motors were off.
    seen: u64,
    /// How often this process was asked for a reset.
    resets: usize,
    owes: bool,
}

impl MotorsOff {
    /// Takes in a step of a process: how often it has exchanged data with the drive and was asked for a reset so far, and whether the motors
    /// are off.
    pub(super) fn look(&mut self, exchanges: u64, resets: usize, off: bool) {
        let fresh = exchanges - std::mem::replace(&mut self.before, exchanges);
        self.seen = if off { self.seen + fresh } else { 0 };
        if std::mem::replace(&mut self.resets, resets) != resets {
            self.owes = false;
        }
        self.owes |= self.seen >= SEEN_EXCHANGES;
    }

    /// The process is gone.
    pub(super) fn forget_process(&mut self) {
        (self.seen, self.resets) = (0, 0);
    }

    /// For what the robot must wait, if it must.
    pub(super) fn fault(self) -> Option<&'static str> {
        self.owes.then(|| Fault::MotorsOff.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_reset_ends_what_a_process_has_seen_for_long_enough() {
        let mut own = MotorsOff::default();
        own.look(5000, 0, false);
        own.look(5000 + SEEN_EXCHANGES - 1, 0, true);
        own.look(6499, 0, false);
        own.look(6500, 0, true);
        assert_eq!(own.fault(), None, "for too short a time, twice");
        own.look(9000, 0, true);
        own.forget_process();
        own.look(9100, 0, false);
        assert_eq!(own.fault(), Some("motors-off"), "in the next process too");
        own.look(9200, 1, false);
        assert_eq!(own.fault(), None);
        own.look(9300, 1, true);
        own.forget_process();
        own.look(9300 + SEEN_EXCHANGES - 1, 0, true);
        assert_eq!(own.fault(), None, "each process sees for itself");
    }
}
