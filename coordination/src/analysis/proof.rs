//! The result of an analysis, which a binding needs to run the net.

use std::sync::Arc;

use super::report::Report;
use super::state::Layout;
use super::states::States;
use super::usage::Use;
use crate::petri::{NetModel, PlaceId};
use crate::protocol::Position;

/// That a net may run: with these protocols, from its initial marking, between two runs of each
/// protocol. It remembers every state that the analysis looked at, so that a net which is resumed is
/// shown to stand where the proof reaches. A [`NetBinding`](crate::binding::NetBinding) is made with a
/// proof, and refuses one of another net or another state.
///
/// Memory: a word of 64 bits per 64 places, per four protocols and per eight sources of flags, for
/// each state; [`Limits::states`](super::Limits::states) bounds their number. If there were more, twelve
/// bytes for each node of their decision diagram; [`Limits::nodes`](super::Limits::nodes) bounds them. A
/// clone shares it.
#[derive(Clone, Debug)]
pub struct Proof {
    proved: Arc<Proved>,
}

#[derive(Debug)]
struct Proved {
    model: NetModel,
    uses: Vec<Use>,
    report: Report,
    layout: Layout,
    /// By place, for sources of flags: the number of the counter of waiting events.
    counters: Vec<Option<usize>>,
    states: States,
}

impl Proof {
    /// `counters` has an entry per place of `model`, and `states` are laid out as `layout` says.
    pub(super) fn new(
        model: NetModel,
        uses: Vec<Use>,
        report: Report,
        (layout, counters): (Layout, Vec<Option<usize>>),
        states: States,
    ) -> Self {
        Self {
            proved: Arc::new(Proved {
                model,
                uses,
                report,
                layout,
                counters,
                states,
            }),
        }
    }

    /// The net that was analysed, with the marking that it starts with.
    #[must_use]
    pub fn model(&self) -> &NetModel {
        &self.proved.model
    }

    /// The protocols that the net takes part in.
    #[must_use]
    pub fn uses(&self) -> &[Use] {
        &self.proved.uses
    }

    /// What the analysis looked at, and its warnings.
    #[must_use]
    pub fn report(&self) -> &Report {
        &self.proved.report
    }

    /// Whether the analysis looked at this state: the marked places, the events that wait for each
    /// source of a flag, and up to where the net has read or set each protocol, in the order of
    /// [`uses`](Self::uses). A waiting event whose source is empty counts as if it stood in the source,
    /// and a complete run as the beginning of the next. One look into a hash table, or one for each place
    /// and position into a decision diagram; allocates.
    #[must_use]
    pub fn reaches(
        &self,
        is_marked: impl Fn(PlaceId) -> bool,
        waiting: impl Fn(PlaceId) -> u32,
        positions: &[Position],
    ) -> bool {
        let Proved {
            uses,
            layout,
            counters,
            states,
            ..
        } = &*self.proved;
        if positions.len() != uses.len() {
            return false;
        }
        let mut state = vec![0; layout.words];
        for (place, &counter) in (0..).zip(counters) {
            let id = PlaceId(place as u16);
            let mut marked = is_marked(id);
            if let Some(counter) = counter {
                let mut waits = waiting(id);
                if !marked && waits > 0 {
                    (marked, waits) = (true, waits - 1);
                }
                let Ok(waits) = u8::try_from(waits) else {
                    return false;
                };
                layout.set_waiting(&mut state, counter, waits);
            }
            if marked {
                layout.mark(&mut state, place);
            }
        }
        for (number, (used, &at)) in uses.iter().zip(positions).enumerate() {
            layout.set_position(&mut state, number, used.after(at));
        }
        states.contains(&state)
    }
}
