//! All states found so far, each once, side by side in one array.

const EMPTY: u32 = u32::MAX;

/// States of equal width, numbered in the order in which they were found.
#[derive(Debug)]
pub(super) struct Store {
    words: usize,
    states: Vec<u64>,
    /// Numbers of states, by hash and linear probing; never more than half full.
    table: Vec<u32>,
}

impl Store {
    /// A store for states of `words` words, at least one.
    pub(super) fn new(words: usize) -> Self {
        Self {
            words,
            states: Vec::new(),
            table: vec![EMPTY; 64],
        }
    }

    pub(super) fn len(&self) -> usize {
        self.states.len() / self.words
    }

    pub(super) fn get(&self, number: u32) -> &[u64] {
        let at = number as usize * self.words;
        &self.states[at..at + self.words]
    }

    /// The number of `state`, if it is known.
    pub(super) fn find(&self, state: &[u64]) -> Option<u32> {
        let number = self.table[self.slot(state)];
        (number != EMPTY).then_some(number)
    }

    /// Adds a state that [`find`](Self::find) does not know.
    pub(super) fn add(&mut self, state: &[u64]) -> u32 {
        if (self.len() + 1) * 2 > self.table.len() {
            self.table = vec![EMPTY; self.table.len() * 2];
            for number in 0..self.len() as u32 {
                let slot = self.slot(self.get(number));
                self.table[slot] = number;
            }
        }
        let (slot, number) = (self.slot(state), self.len() as u32);
        self.table[slot] = number;
        self.states.extend_from_slice(state);
        number
    }

    /// Where `state` stands in the table, or where it would.
    fn slot(&self, state: &[u64]) -> usize {
        let mask = self.table.len() - 1;
        let mut slot = hash(state) as usize & mask;
        while self.table[slot] != EMPTY && self.get(self.table[slot]) != state {
            slot = (slot + 1) & mask;
        }
        slot
    }
}

/// Multiplies and folds, so that every bit of the state reaches the low bits.
fn hash(state: &[u64]) -> u64 {
    let mut hash = 0x243F_6A88_85A3_08D3_u64;
    for word in state {
        hash = folded(hash ^ word, 0x9E37_79B9_7F4A_7C15);
    }
    hash
}

/// The two halves of a product of 128 bits, folded into one. The upper half is put together from products of 32 bits by 32. No sum of these
/// overflows: (2³² - 1)² + 2³² - 1 is less than 2⁶⁴, and the last sum is the upper half itself.
fn folded(one: u64, other: u64) -> u64 {
    let halves = |number: u64| (number >> 32, number & 0xFFFF_FFFF);
    let ((high, low), (other_high, other_low)) = (halves(one), halves(other));
    let (carried, middle) = halves(high * other_low + ((low * other_low) >> 32));
    let upper = high * other_high + carried + ((low * other_high + middle) >> 32);
    upper ^ one.wrapping_mul(other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folded_product_is_that_of_128_bits() {
        let half = 1_u64 << 32;
        let numbers = [0, 1, 7, half - 1, half, half + 1, 1 << 63, u64::MAX];
        for one in numbers {
            for other in numbers.into_iter().chain([0x9E37_79B9_7F4A_7C15]) {
                let product = u128::from(one) * u128::from(other);
                let both = (product >> 64) as u64 ^ product as u64;
                assert_eq!(folded(one, other), both, "{one} times {other}");
            }
        }
    }

    #[test]
    fn every_state_is_kept_once_and_found_again() {
        let mut store = Store::new(2);
        let state = |number: u64| [number % 7, number * 0x1_0000];
        for number in 0..10_000 {
            assert_eq!(store.find(&state(number)), None);
            assert_eq!(store.add(&state(number)), number as u32);
        }
        for number in 0..10_000 {
            assert_eq!(store.find(&state(number)), Some(number as u32));
            assert_eq!(store.get(number as u32), state(number));
        }
        assert_eq!(store.len(), 10_000);
    }
}
