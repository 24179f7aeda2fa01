//! Numbers that nobody else has.

use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher, Hasher};

/// A number that is drawn at random, never 0.
#[must_use]
pub fn draw() -> u64 {
    // Hashers are seeded at random, differently in every process and each time.
    RandomState::new().build_hasher().finish() | 1
}

#[cfg(test)]
mod tests {
    #[test]
    fn no_two_are_alike() {
        assert_ne!(super::draw(), super::draw());
    }
}
