//! A party with the key of its state, so that only what a step has touched is copied and looked at.

use std::cell::RefCell;
use std::collections::hash_map::DefaultHasher;
use std::fmt::{Debug, Write};
use std::hash::Hasher;
use std::sync::Arc;

/// Shared by all states in which the party is as it is here.
#[derive(Clone)]
pub struct Kept<T>(Arc<(T, u64)>);

impl<T: Clone + Debug> Kept<T> {
    pub fn new(value: T) -> Self {
        let key = key_of(&value);
        Self(Arc::new((value, key)))
    }

    pub fn get(&self) -> &T {
        &self.0.0
    }

    /// Two states with the same key have the same party.
    pub fn key(&self) -> u64 {
        self.0.1
    }

    pub fn change<R>(&mut self, act: impl FnOnce(&mut T) -> R) -> R {
        let mut value = self.get().clone();
        let result = act(&mut value);
        *self = Self::new(value);
        result
    }
}

/// Of all that `Debug` prints: a field that the product gets tomorrow belongs to the state without a change here. Counts for
/// people decide nothing.
fn key_of(value: &impl Debug) -> u64 {
    thread_local! {
        static TEXT: RefCell<String> = const { RefCell::new(String::new()) };
    }
    TEXT.with_borrow_mut(|text| {
        text.clear();
        write!(text, "{value:?}").expect("a string takes everything");
        let counters = text.find("Counters {").unwrap_or(text.len());
        let (before, counted) = text.split_at(counters);
        let after = counted.split_once('}').map_or("", |(_, after)| after);
        let mut hasher = DefaultHasher::new();
        hasher.write(before.as_bytes());
        hasher.write(after.as_bytes());
        hasher.finish()
    })
}
