//! Which arrays a message need not mention: those that rest, once the other side has heard how they rest.
//!
//! Levels are repeated, so messages would grow with every area that a robot has ever used. An array that rests is repeated
//! until the other side has acknowledged a message with it. Whoever hears a level that is older than its own says its own
//! again: then the other side has forgotten.

/// Since which message the present level of an array was mentioned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mention {
    since: Option<u64>,
}

impl Mention {
    /// The level has changed, or the other side has forgotten it.
    pub fn renew(&mut self) {
        self.since = None;
    }

    /// A message of this number mentions it.
    pub fn note(&mut self, number: u64) {
        self.since.get_or_insert(number);
    }

    /// The other side has heard a message of this number, and so the level.
    #[must_use]
    pub fn is_known(&self, heard: u64) -> bool {
        self.since.is_some_and(|since| since <= heard)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_is_known_once_a_message_with_it_was_heard() {
        let mut mention = Mention::default();
        assert!(!mention.is_known(u64::MAX), "it was in none");
        mention.note(7);
        mention.note(8);
        assert!(!mention.is_known(6) && mention.is_known(7) && mention.is_known(9));
        mention.renew();
        assert!(!mention.is_known(9));
        mention.note(10);
        assert!(!mention.is_known(9) && mention.is_known(10));
    }
}
