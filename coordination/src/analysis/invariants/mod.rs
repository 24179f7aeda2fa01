//! Place invariants (P-semiflows): weighted sums of tokens that no firing changes.
//!
//! What follows from the arcs alone holds in every state, however many there are, and whatever the other
//! parties of protocols do: if `free + inside = 1` is an invariant, both places are safe and never marked
//! together. So an invariant proves without a look at any state; but not all that is true of a net follows
//! from invariants. [`check`](super::check()) uses them first, and looks at states for the rest: deadlocks,
//! ends, flags.
//!
//! Invariants are those of internal places. Sources and sinks are filled and emptied from outside.
//! The method is Farkas' as Martínez and Silva use it (1982; Colom and Silva 1991): all semiflows of minimal
//! support, of which there may be exponentially many. Where combining a transition's places would cost too
//! much, those that it touches are left out; and after [`Limits::looks`] numbers it ends. What is found is right
//! in any case.
//!
//! ```
//! use coordination::analysis::place_invariants;
//! use coordination::petri::{Binding, NetModel};
//!
//! let mut gate = NetModel::new("gate");
//! gate.place("free").mark("free").place("inside");
//! gate.source("asked", Binding::event("ask")).source("left", Binding::event("leave"));
//! gate.transition("enter", &["asked", "free"], &["inside"]);
//! gate.transition("leave", &["left", "inside"], &["free"]);
//!
//! let invariants = place_invariants(&gate);
//! assert_eq!(invariants.found[0].to_string(), "free + inside = 1");
//! assert!(invariants.is_safe("inside"));
//! assert!(invariants.excludes(&["free", "inside"]));
//! ```

mod numbered;
mod semiflows;
mod work;

use std::collections::HashSet;
use std::fmt;

use super::closed::Closed;
use super::report::ByInvariants;
use super::usage::Limits;
use crate::petri::NetModel;
use numbered::Numbered;
use work::Work;

/// A weighted sum of tokens that no firing changes.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PlaceInvariant {
    /// The places with their weights, in the model's order; all weights are positive.
    pub places: Vec<(String, u32)>,
    /// The sum in the initial marking, and so in each.
    pub tokens: u64,
}

impl PlaceInvariant {
    /// The weight of a place; 0 if it is not in the sum.
    #[must_use]
    pub fn weight(&self, place: &str) -> u32 {
        let mut places = self.places.iter();
        places
            .find_map(|(name, weight)| (name == place).then_some(*weight))
            .unwrap_or(0)
    }
}

impl fmt::Display for PlaceInvariant {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, (place, weight)) in self.places.iter().enumerate() {
            let plus = if index == 0 { "" } else { " + " };
            match weight {
                1 => write!(formatter, "{plus}{place}")?,
                weight => write!(formatter, "{plus}{weight} {place}")?,
            }
        }
        write!(formatter, " = {}", self.tokens)
    }
}

/// The place invariants of a net.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PlaceInvariants {
    /// Those of minimal support that were found.
    pub found: Vec<PlaceInvariant>,
    /// Whether these are all.
    pub is_complete: bool,
}

impl PlaceInvariants {
    /// The most tokens that a place can hold; none if no invariant tells.
    #[must_use]
    pub fn bound(&self, place: &str) -> Option<u64> {
        let bounds = { self.found.iter() }
            .map(|invariant| (invariant.tokens, u64::from(invariant.weight(place))))
            .filter(|&(_, weight)| weight > 0);
        bounds.map(|(tokens, weight)| tokens / weight).min()
    }

    /// Whether a place surely never holds a second token.
    #[must_use]
    pub fn is_safe(&self, place: &str) -> bool {
        self.bound(place).is_some_and(|most| most <= 1)
    }

    /// Whether surely never two of these places are marked.
    #[must_use]
    pub fn excludes(&self, places: &[&str]) -> bool {
        let both = |one: &str, other: &str| {
            let mut all = self.found.iter();
            let sum = |i: &PlaceInvariant| u64::from(i.weight(one)) + u64::from(i.weight(other));
            all.any(|invariant| sum(invariant) > invariant.tokens)
        };
        let pairs = places.iter().enumerate();
        { pairs }.all(|(index, one)| places[..index].iter().all(|other| both(one, other)))
    }
}

/// The place invariants of a net. Takes what is declared as it stands; arcs from and to places that are not
/// declared do not count. Looks at no more numbers than the default of [`Limits::looks`]; what was found until
/// then is right, but not complete. Not for real-time threads.
#[must_use]
pub fn place_invariants(model: &NetModel) -> PlaceInvariants {
    let mut work = Work::new(Limits::default().looks);
    let Numbered {
        names,
        found,
        is_complete,
        ..
    } = Numbered::of(model, &mut work);
    let found = found.into_iter().map(|(weights, tokens)| PlaceInvariant {
        places: { weights.iter() }
            .map(|&(place, weight)| (names[place as usize].to_owned(), weight))
            .collect(),
        tokens,
    });
    PlaceInvariants {
        found: found.collect(),
        is_complete,
    }
}

/// What invariants prove of a net, which its exploration need not look at any more.
pub(super) fn prove(model: &NetModel, closed: &mut Closed<'_>, limits: &Limits) -> ByInvariants {
    let mut work = Work::new(limits.looks);
    let invariants = Numbered::of(model, &mut work);
    let bounds = invariants.bounds();
    let exclusions = model.exclusions().map(|set| (set.name, set.places));
    let exclusions = invariants.excluded(exclusions, &bounds, &mut work);
    let held: HashSet<&str> = exclusions.iter().map(String::as_str).collect();
    let bound = |place: &str| invariants.numbers.get(place).map(|&n| bounds[n as usize]);
    closed.know(
        |place| bound(place).is_some_and(|most| most <= 1),
        |exclusion| held.contains(exclusion),
    );
    ByInvariants {
        is_safe: bounds.iter().all(|&most| most <= 1),
        exclusions,
    }
}
