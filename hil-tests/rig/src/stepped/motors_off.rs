//! Who must wait for an operator by truth: a robot whose motors were off for so long that its process has seen it, whatever becomes of that
//! process.

use onboard::symbols::faults::Fault;

/// So many exchanges with a drive whose motors are off: more than a process needs to see it, to write it down, or to be found to hang.
const SEEN_EXCHANGES: u64 = 1500;

/// What is owed to one robot's operator.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MotorsOff {
    /// How often this process had exchanged data with the drive when the motors went off, if they are.
    from: Option<u64>,
    /// How often this process was asked for a reset.
    resets: usize,
    owes: bool,
}

impl MotorsOff {
    /// Takes in a step of a process: while the motors are off, how often it has exchanged data with the drive so far, and how often it was
    /// asked for a reset.
    pub(super) fn look(&mut self, off_at: Option<u64>, resets: usize) {
        if std::mem::replace(&mut self.resets, resets) != resets {
            self.owes = false;
        }
        let Some(exchanges) = off_at else {
            self.from = None;
            return;
        };
        let from = *self.from.get_or_insert(exchanges);
        self.owes |= exchanges - from >= SEEN_EXCHANGES;
    }

    /// The process is gone.
    pub(super) fn forget_process(&mut self) {
        (self.from, self.resets) = (None, 0);
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
        own.look(None, 0);
        own.look(Some(5000), 0);
        own.look(Some(5000 + SEEN_EXCHANGES - 1), 0);
        own.look(None, 0);
        own.look(Some(6500), 0);
        assert_eq!(own.fault(), None, "for too short a time, twice");
        own.look(Some(9000), 0);
        own.forget_process();
        own.look(None, 0);
        assert_eq!(own.fault(), Some("motors-off"), "in the next process too");
        own.look(None, 1);
        assert_eq!(own.fault(), None);
        own.look(Some(9300), 1);
        own.forget_process();
        own.look(Some(9300 + SEEN_EXCHANGES - 1), 0);
        assert_eq!(own.fault(), None, "each process sees for itself");
    }
}
