//! What the management activity does again and again, without thread, queues and clock: on its thread, and on a simulated clock.

use super::input::Input;
use super::management::Management;
use crate::journal::StoreError;
use contract::wire::MediatorReport;

/// What became of a message that was to leave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sent {
    /// It leaves.
    Taken,
    /// It found a full queue: it is counted, and its levels are in the next one.
    Full,
    /// Nobody takes messages any more.
    Closed,
}

/// The management activity: first [`take_in`](Self::take_in), then, when that is written, [`release`](Self::release).
pub struct Turn {
    management: Management,
    dropped: u64,
}

impl Turn {
    /// Nothing has been done yet.
    #[must_use]
    pub fn new(management: Management) -> Self {
        Self {
            management,
            dropped: 0,
        }
    }

    /// The disk does not take the journal: what waits goes on waiting, where the newest report of each robot counts.
    #[must_use]
    pub fn is_blocked(&self) -> bool {
        self.management.is_blocked()
    }

    /// Takes in all `inputs`, lets time pass and writes the journal; while it [`is_blocked`](Self::is_blocked), only tries to
    /// write, and leaves the inputs where they are.
    ///
    /// # Errors
    /// [`StoreError`] when the journal cannot be used any more.
    pub fn take_in(
        &mut self,
        inputs: impl Iterator<Item = Input>,
        now_ns: u64,
    ) -> Result<(), StoreError> {
        if self.is_blocked() {
            self.management.retry(now_ns)
        } else {
            self.management.turn(inputs, now_ns)
        }
    }

    /// What is written down leaves: messages, then answers to operators. Returns whether anybody still takes messages.
    pub fn release(&mut self, now_ns: u64, mut send: impl FnMut(MediatorReport) -> Sent) -> bool {
        while let Some(message) = self.management.next_message(now_ns) {
            match send(message) {
                Sent::Taken => {}
                Sent::Full => self.dropped += 1,
                Sent::Closed => return false,
            }
        }
        self.management.answer();
        true
    }

    /// Messages that have found a full queue.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }
}
