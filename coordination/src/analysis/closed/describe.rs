//! A closed net in names.

use super::super::flags::Outside;
use super::super::refusal::{Reason, Step};
use super::super::usage::Use;
use super::net::{Closed, Move};
use crate::protocol::{FlagId, Position};

impl Closed<'_> {
    /// The names of all marked places.
    pub(in crate::analysis) fn marked(&self, state: &[u64]) -> Vec<String> {
        self.names_of(self.layout.marking(state).iter().copied())
    }

    /// That nothing can happen in a state.
    pub(in crate::analysis) fn deadlock(&self, state: &[u64]) -> Reason {
        Reason::Deadlock {
            marked: self.marked(state),
            missed: self.missed(state),
        }
    }

    /// That a transition would put a second token into a place.
    pub(in crate::analysis) fn second_token(&self, transition: u32, place: u32) -> Reason {
        Reason::Unsafe {
            transition: self.transition_name(transition as usize).to_owned(),
            place: self.places[place as usize].clone(),
        }
    }

    /// That an event comes while `waiting` of its kind wait for a source already.
    pub(in crate::analysis) fn overflow(&self, source: u32, waiting: u8) -> Reason {
        Reason::Overflow {
            place: self.places[source as usize].clone(),
            event: self.event_names[source as usize].clone(),
            waiting,
        }
    }

    /// What each protocol in the middle of a run waits for.
    pub(in crate::analysis) fn missed(&self, state: &[u64]) -> Vec<String> {
        (0..self.uses.len())
            .filter(|&number| !self.is_between_runs(state, number))
            .map(|number| self.missing(state, number))
            .collect()
    }

    /// What a protocol waits for.
    pub(in crate::analysis) fn missing(&self, state: &[u64], number: usize) -> String {
        let used = &self.uses[number];
        let next = next_flags(used, self.position(state, number));
        format!("protocol `{}` waits for {next}", used.name)
    }

    /// What a transition lacks to fire: empty inputs and full outputs, or how many of them.
    pub(in crate::analysis) fn lacking(
        &self,
        state: &[u64],
        transition: usize,
    ) -> impl Iterator<Item = &str> {
        let arcs = &self.transitions[transition].1;
        let marked = move |&place: &u32| self.layout.is_marked(state, place);
        let inputs = arcs
            .inputs
            .iter()
            .copied()
            .filter(move |place| !marked(place));
        let full = arcs.sinks.iter().copied().filter(marked);
        inputs
            .chain(full)
            .map(|place| self.places[place as usize].as_str())
    }

    /// The sinks that a transition marks.
    pub(in crate::analysis) fn sinks_of(&self, transition: usize) -> impl Iterator<Item = &str> {
        let sinks = self.transitions[transition].1.sinks.iter();
        sinks.map(|&sink| self.places[sink as usize].as_str())
    }

    /// The protocol and the name of a flag, if no source is bound to it.
    pub(in crate::analysis) fn unread(&self, number: u16, flag: FlagId) -> Option<(&str, &str)> {
        let number = usize::from(number);
        let name = self.uses[number].protocol.flag_name(flag);
        let is_read = !self.bound[number].sources[flag.index()].is_empty();
        (!is_read).then_some((self.uses[number].name.as_str(), name))
    }

    /// A step in names.
    pub(in crate::analysis) fn name(&self, step: Move) -> Step {
        match step {
            Move::Fire(transition) => Step::Fires {
                transition: self.transition_name(transition as usize).to_owned(),
            },
            Move::Set(number, flag) => {
                let used = &self.uses[usize::from(number)];
                Step::Sets {
                    party: used.other_party_name().to_owned(),
                    protocol: used.name.clone(),
                    flag: used.protocol.flag_name(flag).to_owned(),
                }
            }
            Move::Abort(number) => {
                let used = &self.uses[usize::from(number)];
                Step::Aborts {
                    party: used.other_party_name().to_owned(),
                    protocol: used.name.clone(),
                }
            }
            Move::Empty(sink) => match self.outside[sink as usize] {
                Outside::Flag(number, flag) => {
                    let used = &self.uses[usize::from(number)];
                    Step::Raises {
                        party: used.net_party_name().to_owned(),
                        protocol: used.name.clone(),
                        flag: used.protocol.flag_name(flag).to_owned(),
                    }
                }
                _ => Step::Sends {
                    event: self.event_names[sink as usize].clone(),
                },
            },
            Move::Fill(source) => Step::Arrives {
                event: self.event_names[source as usize].clone(),
            },
        }
    }

    pub(super) fn names_of(&self, words: impl Iterator<Item = u64>) -> Vec<String> {
        let mut names = Vec::new();
        for (word, mut bits) in words.enumerate() {
            while bits != 0 {
                names.push(self.places[word * 64 + bits.trailing_zeros() as usize].clone());
                bits &= bits - 1;
            }
        }
        names
    }
}

/// "`request` of `robot`", or several with "or".
pub(super) fn next_flags(used: &Use, at: Position) -> String {
    let flags: Vec<String> = used
        .protocol
        .next(at)
        .map(|(flag, _)| format!("`{}`", used.protocol.flag_name(flag)))
        .collect();
    let turn = used.protocol.turn(at).unwrap_or(used.net_party);
    format!(
        "{} of `{}`",
        flags.join(" or "),
        used.protocol.party_name(turn)
    )
}
