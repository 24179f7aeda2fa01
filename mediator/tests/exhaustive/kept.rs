//! A party with the key of its state, so that only what a step has touched is copied and looked at; and what a party has come to before is
//! not worked out again, since it meets the same in many states of the others.

use std::any::{Any, TypeId};
use std::cell::RefCell;
use std::collections::HashMap;
use std::collections::hash_map::DefaultHasher;
use std::fmt::{Debug, Write};
use std::hash::{Hash, Hasher};
use std::sync::{Arc, LazyLock, Mutex};

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

/// So many ways are remembered, in parts of which each has a lock.
const PARTS: usize = 64;
const WAYS_OF_A_PART: usize = 4096;

/// Where a party has come from a state, by the keys of that and of what happened to it, and what came of it.
type Ways = HashMap<(u64, u64), Box<dyn Any + Send + Sync>>;

static WAYS: LazyLock<Vec<Mutex<Ways>>> =
    LazyLock::new(|| (0..PARTS).map(|_| Mutex::new(Ways::new())).collect());

impl<T: Clone + Debug + Send + Sync + 'static> Kept<T> {
    /// As [`change`](Self::change), where `what` happens says all of what `act` does: what it came to before, it comes to again.
    pub fn change_by<R: Clone + Send + Sync + 'static>(
        &mut self,
        what: impl Hash,
        act: impl FnOnce(&mut T) -> R,
    ) -> R {
        let mut hasher = DefaultHasher::new();
        (TypeId::of::<(T, R)>(), what).hash(&mut hasher);
        let way = (self.key(), hasher.finish());
        let part = &WAYS[(way.0 ^ way.1) as usize % PARTS];
        if let Some(known) = part.lock().expect("no panic").get(&way) {
            let (after, result): &(Self, R) = known.downcast_ref().expect("its type is in the key");
            *self = after.clone();
            return result.clone();
        }
        let result = self.change(act);
        let mut ways = part.lock().expect("no panic");
        if ways.len() >= WAYS_OF_A_PART {
            ways.clear();
        }
        ways.insert(way, Box::new((self.clone(), result.clone())));
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
