//! The box that the mediator's messages wait in.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use crate::activities::news::News;

/// Messages that may wait. Each carries the whole state, so a full box drops the oldest.
const WAITING: usize = 16;

/// Messages of the mediator on their way from the network's threads to ours.
#[derive(Clone, Debug, Default)]
pub(super) struct Mailbox(Arc<Mutex<Letters>>);

#[derive(Debug, Default)]
struct Letters {
    waiting: VecDeque<Vec<u8>>,
    dropped: u64,
}

impl Mailbox {
    pub(super) fn put(&self, letter: Vec<u8>) {
        let mut letters = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if letters.waiting.len() == WAITING {
            letters.waiting.pop_front();
            letters.dropped += 1;
        }
        letters.waiting.push_back(letter);
    }

    pub(super) fn take(&self) -> Option<Vec<u8>> {
        let mut letters = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        letters.waiting.pop_front()
    }

    /// Messages dropped so far.
    pub(super) fn dropped(&self) -> u64 {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .dropped
    }
}

/// Where a session on the network puts the mediator's messages.
#[derive(Clone, Debug)]
pub struct Inbox {
    pub(super) mailbox: Mailbox,
    pub(super) news: News,
}

impl Inbox {
    /// Puts a message in, and wakes the activity. From any thread that may take a lock.
    pub fn put(&self, message: Vec<u8>) {
        self.mailbox.put(message);
        self.news.tell();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_mailbox_lets_the_oldest_go_and_counts_it() {
        let mailbox = Mailbox::default();
        for number in 0..=WAITING {
            mailbox.put(vec![u8::try_from(number).expect("small")]);
        }
        assert_eq!(mailbox.dropped(), 1);
        assert_eq!(mailbox.take(), Some(vec![1]));
        assert_eq!(std::iter::from_fn(|| mailbox.take()).count(), WAITING - 1);
    }
}
