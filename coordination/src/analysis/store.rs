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
    state.iter().fold(0x243F_6A88_85A3_08D3, |hash, &word| {
        let product = u128::from(hash ^ word) * 0x9E37_79B9_7F4A_7C15;
        (product >> 64) as u64 ^ product as u64
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
