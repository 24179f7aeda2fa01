//! Exchanges a part of a running activity for one that was made on another thread.
//!
//! The activity swaps the parts and hands the old one back, so that no real-time thread allocates or releases anything.

use rtrb::{Consumer, Producer, RingBuffer};

/// An activity's end: takes a new part and gives the old one back.
pub struct Exchange<T> {
    new: Consumer<Box<T>>,
    old: Producer<Box<T>>,
}

impl<T> Exchange<T> {
    /// The new part, if there is one.
    pub fn take(&mut self) -> Option<Box<T>> {
        self.new.pop().ok()
    }

    /// Gives the old part back. There is room: parts are handed out one at a time.
    pub fn give_back(&mut self, old: Box<T>) {
        if let Err(rtrb::PushError::Full(old)) = self.old.push(old) {
            // Never released on this thread.
            std::mem::forget(old);
        }
    }
}

/// The supervisor's end.
pub struct Hand<T> {
    new: Producer<Box<T>>,
    old: Consumer<Box<T>>,
}

impl<T> Hand<T> {
    /// Both ends.
    #[must_use]
    pub fn pair() -> (Self, Exchange<T>) {
        let (new, new_end) = RingBuffer::new(1);
        let (old_end, old) = RingBuffer::new(2);
        (
            Self { new, old },
            Exchange {
                new: new_end,
                old: old_end,
            },
        )
    }

    /// Hands a new part over.
    pub fn hand_over(&mut self, part: Box<T>) {
        // Empty: one reload at a time, and each waits until its part was taken.
        let _ = self.new.push(part);
    }

    /// Whether the part was taken: the old one is back.
    #[must_use]
    pub fn taken(&self) -> bool {
        !self.old.is_empty()
    }

    /// Releases the part that came back.
    pub fn release_old(&mut self) {
        while self.old.pop().is_ok() {}
    }
}
