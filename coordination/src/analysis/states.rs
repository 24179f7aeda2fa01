//! The states that a proof reaches, each of them or as one set.

#[cfg(feature = "symbolic")]
use super::closed::rule::Meaning;
#[cfg(feature = "symbolic")]
use super::kept::Kept;
#[cfg(feature = "symbolic")]
use super::state::Layout;
use super::store::Store;

/// All states that an analysis looked at.
#[derive(Debug)]
pub(super) enum States {
    Each(Store),
    /// As a diagram, with what its variables mean.
    #[cfg(feature = "symbolic")]
    Together(Layout, Kept, Vec<Meaning>),
}

impl States {
    pub(super) fn contains(&self, state: &[u64]) -> bool {
        match self {
            Self::Each(store) => store.find(state).is_some(),
            #[cfg(feature = "symbolic")]
            &Self::Together(layout, ref kept, ref meanings) => {
                // What waits beyond the variables is nowhere in the diagram.
                let holds = { meanings.iter().zip(0..) }
                    .filter(|(meaning, _)| meaning.is_true(layout, state))
                    .map(|(_, variable)| variable);
                kept.contains(holds) && layout.waits_at_most(state, most_waiting(meanings))
            }
        }
    }
}

/// How many events may wait for a source.
#[cfg(feature = "symbolic")]
fn most_waiting(meanings: &[Meaning]) -> u8 {
    let counts = meanings.iter().map(|meaning| match meaning {
        Meaning::Waiting(_, count) => *count,
        _ => 0,
    });
    counts.max().unwrap_or(0)
}
