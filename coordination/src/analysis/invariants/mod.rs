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
//! much, those that it touches are left out; what is found is right in any case.
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

mod semiflows;

use std::collections::{HashMap, HashSet};
use std::fmt;

use super::closed::Closed;
use super::report::ByInvariants;
use crate::petri::{NetModel, PlaceKind};

/// Nets of more places are looked at state by state at once: to find their invariants can take as long.
const MOST_PLACES: usize = 4_096;

/// A weighted sum of tokens that no firing changes.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
/// declared do not count. Not for real-time threads.
#[must_use]
pub fn place_invariants(model: &NetModel) -> PlaceInvariants {
    let (mut names, mut marked) = (Vec::new(), Vec::new());
    for place in model
        .places()
        .filter(|place| place.kind == PlaceKind::Internal)
    {
        names.push(place.name);
        marked.push(place.marked);
    }
    let numbers: HashMap<&str, u32> = names.iter().copied().zip(0..).collect();
    let changes = model.transitions().map(|transition| {
        let mut changes: HashMap<u32, i64> = HashMap::new();
        let number = |place: &&str| numbers.get(place).copied();
        for place in transition.inputs.iter().filter_map(number) {
            *changes.entry(place).or_default() -= 1;
        }
        for place in transition.outputs.iter().filter_map(number) {
            *changes.entry(place).or_default() += 1;
        }
        changes.into_iter().collect()
    });
    let (semiflows, is_complete) = semiflows::semiflows(names.len(), changes.collect());
    let found = semiflows.into_iter().map(|weights| PlaceInvariant {
        tokens: { weights.iter() }
            .filter(|&&(place, _)| marked[place as usize])
            .map(|&(_, weight)| u64::from(weight))
            .sum(),
        places: { weights.iter() }
            .map(|&(place, weight)| (names[place as usize].to_owned(), weight))
            .collect(),
    });
    PlaceInvariants {
        found: found.collect(),
        is_complete,
    }
}

/// What invariants prove of a net, which its exploration need not look at any more.
pub(super) fn prove(model: &NetModel, closed: &mut Closed<'_>) -> ByInvariants {
    let internal = || {
        model
            .places()
            .filter(|place| place.kind == PlaceKind::Internal)
    };
    if internal().count() > MOST_PLACES {
        return ByInvariants::default();
    }
    let invariants = place_invariants(model);
    let safe: HashSet<&str> = { internal() }
        .map(|place| place.name)
        .filter(|place| invariants.is_safe(place))
        .collect();
    let exclusions: Vec<String> = { model.exclusions() }
        .filter(|exclusion| invariants.excludes(&exclusion.places))
        .map(|exclusion| exclusion.name.to_owned())
        .collect();
    closed.know(
        |place| safe.contains(place),
        |exclusion| exclusions.iter().any(|proved| proved == exclusion),
    );
    ByInvariants {
        is_safe: internal().all(|place| safe.contains(place.name)),
        exclusions,
    }
}
