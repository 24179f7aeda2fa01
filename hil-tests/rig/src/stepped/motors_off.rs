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
    /// Takes in a step of a process: while the motors are off, how often it has exchanged data with the drive so far, how often it was
    /// asked for a reset, and whether it `has_yet_to_answer` one: that may still find the motors on.
    pub(super) fn look(
        &mut self,
        off_at: Option<u64>,
        resets: usize,
        has_yet_to_answer: impl Fn() -> bool,
    ) {
        if std::mem::replace(&mut self.resets, resets) != resets {
            self.owes = false;
        }
        let Some(exchanges) = off_at else {
            let are_back = self.from.take().is_some();
            self.owes &= !(are_back && has_yet_to_answer());
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
        let answered = || false;
        let mut own = MotorsOff::default();
        own.look(None, 0, answered);
        own.look(Some(5000), 0, answered);
        own.look(Some(5000 + SEEN_EXCHANGES - 1), 0, answered);
        own.look(None, 0, answered);
        own.look(Some(6500), 0, answered);
        assert_eq!(own.fault(), None, "for too short a time, twice");
        own.look(Some(9000), 0, answered);
        own.forget_process();
        own.look(None, 0, answered);
        assert_eq!(own.fault(), Some("motors-off"), "in the next process too");
        own.look(None, 1, answered);
        assert_eq!(own.fault(), None);
        own.look(Some(9300), 1, answered);
        own.forget_process();
        own.look(Some(9300 + SEEN_EXCHANGES - 1), 0, answered);
        assert_eq!(own.fault(), None, "each process sees for itself");
    }
    #[test]
    fn a_reset_that_is_served_when_they_are_on_again_counts_and_one_before_does_not() {
        for (has_yet_to_answer, expected) in [(true, None), (false, Some("motors-off"))] {
            let mut own = MotorsOff::default();
            own.look(Some(5000), 0, || false);
            own.look(Some(5000 + SEEN_EXCHANGES), 1, || true);
            own.look(None, 1, || has_yet_to_answer);
            assert_eq!(own.fault(), expected);
        }
    }
}
