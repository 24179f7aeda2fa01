//! The arcs of a model, and how its places are used.

use alloc::boxed::Box;
use alloc::format;
use alloc::vec;
use alloc::vec::Vec;

use super::super::binding::PlaceKind;
use super::super::error::ModelError;
use super::super::lists::{Lists, NumberedArc};
use super::super::names::{Element, NameId};
use super::super::structure::Structure;
use super::errors::Check;
use crate::petri::id::PlaceId;

impl Check<'_> {
    pub(super) fn arcs(&mut self, marked: Box<[bool]>, ending: &[bool]) -> Structure {
        let data = self.data;
        let (places, transitions) = (data.places.len(), data.transitions.len());
        let arcs = data.arcs.iter().map(|&(from, to)| self.number(from, to));
        let lists = Lists::of_ordered(arcs, places, transitions);
        let lists = lists.or_else(|| {
            let arcs = self.ordered_arcs().into_iter().map(Some);
            Lists::of_ordered(arcs, places, transitions)
        });
        let lists = lists.expect("sorted arcs are in order");
        let structure = Structure {
            kinds: data.kinds.clone().into(),
            marked,
            starts: lists.starts,
            places: lists.places,
            self_loops: lists.self_loops,
            uses: lists.uses,
        };
        self.transitions(&structure, lists.has_duplicates);
        self.uses(&structure, ending);
        structure
    }

    #[inline]
    fn number(&self, from: NameId, to: NameId) -> Option<NumberedArc> {
        let names = &self.data.names;
        match (names.element(from), names.element(to)) {
            (Element::Place(place), Element::Transition(transition)) => Some(NumberedArc {
                list: 2 * transition,
                place,
            }),
            (Element::Transition(transition), Element::Place(place)) => Some(NumberedArc {
                list: 2 * transition + 1,
                place,
            }),
            _ => None,
        }
    }

    /// All arcs between a place and a transition, and errors for the others.
    fn ordered_arcs(&mut self) -> Vec<NumberedArc> {
        let data = self.data;
        let mut arcs = Vec::with_capacity(data.arcs.len());
        for &(from, to) in &data.arcs {
            match self.number(from, to) {
                Some(arc) => arcs.push(arc),
                None => self.bad_arc(from, to),
            }
        }
        arcs.sort_by_key(|arc| arc.list);
        arcs
    }

    fn bad_arc(&mut self, from: NameId, to: NameId) {
        let user = format!(
            "the arc from `{}` to `{}`",
            self.data.name_of(from),
            self.data.name_of(to)
        );
        let mut known = true;
        for name in [from, to] {
            if self.data.names.element(name) == Element::Unknown {
                known = false;
                self.errors.push(ModelError::UnknownName {
                    net: self.net(),
                    user: user.clone(),
                    name: self.owned(name),
                });
            }
        }
        if known {
            self.errors.push(ModelError::ArcBetweenEquals {
                net: self.net(),
                from: self.owned(from),
                to: self.owned(to),
                what: match self.data.names.element(from) {
                    Element::Transition(_) => "transitions",
                    _ => "places",
                },
            });
        }
    }

    /// Each transition has an input, and no arc twice.
    fn transitions(&mut self, structure: &Structure, has_duplicates: bool) {
        for (transition, ends) in structure.starts.windows(3).step_by(2).enumerate() {
            if ends[0] == ends[1] {
                self.errors.push(ModelError::TransitionWithoutInput {
                    net: self.net(),
                    transition: self.owned(self.data.transitions[transition]),
                });
            }
        }
        if has_duplicates {
            // By place: the last list that has it.
            let mut last_list = vec![usize::MAX; structure.place_count()];
            self.for_arcs(structure, |check, list, place| {
                if core::mem::replace(&mut last_list[place.index()], list) == list {
                    check.duplicate_arc(list / 2, place, list % 2 == 1);
                }
            });
        }
    }

    fn for_arcs(&mut self, structure: &Structure, mut each: impl FnMut(&mut Self, usize, PlaceId)) {
        for (list, ends) in structure.starts.windows(2).enumerate() {
            for &place in &structure.places[ends[0] as usize..ends[1] as usize] {
                each(self, list, place);
            }
        }
    }

    fn duplicate_arc(&mut self, transition: usize, place: PlaceId, is_output: bool) {
        let transition = self.owned(self.data.transitions[transition]);
        let place = self.owned(self.data.places[place.index()]);
        let (from, to) = if is_output {
            (transition, place)
        } else {
            (place, transition)
        };
        let net = self.net();
        self.errors.push(ModelError::DuplicateArc { net, from, to });
    }

    fn wrong_arc(&mut self, transition: usize, place: PlaceId, is_output: bool) {
        let net = self.net();
        let transition = self.owned(self.data.transitions[transition]);
        let place = self.owned(self.data.places[place.index()]);
        self.errors.push(if is_output {
            ModelError::ArcIntoSource {
                net,
                place,
                transition,
            }
        } else {
            ModelError::ArcOutOfSink {
                net,
                place,
                transition,
            }
        });
    }

    /// Every place is connected, something marks it, something empties it, and nothing does that
    /// may not.
    fn uses(&mut self, structure: &Structure, ending: &[bool]) {
        let mut has_wrong_arcs = false;
        for (index, user) in structure.uses.iter().enumerate() {
            let (leaves, enters) = (user.arcs > user.into, user.into > 0);
            let kind = structure.kinds[index];
            let internal = kind == PlaceKind::Internal;
            if leaves && enters && internal {
                continue;
            }
            has_wrong_arcs |= kind == PlaceKind::Source && enters;
            has_wrong_arcs |= kind == PlaceKind::Sink && leaves;
            let net = || self.net();
            let place = || self.owned(self.data.places[index]);
            if !leaves && !enters {
                let (net, place) = (net(), place());
                self.errors.push(ModelError::IsolatedPlace { net, place });
            } else if internal && !enters && !structure.marked[index] {
                let (net, place) = (net(), place());
                self.errors.push(ModelError::UnboundSource { net, place });
            } else if internal && !leaves && !ending.get(index).is_some_and(|&ends| ends) {
                let (net, place) = (net(), place());
                self.errors.push(ModelError::UnboundSink { net, place });
            }
        }
        if has_wrong_arcs {
            self.for_arcs(structure, |check, list, place| {
                let is_output = list % 2 == 1;
                let wrong = if is_output {
                    PlaceKind::Source
                } else {
                    PlaceKind::Sink
                };
                if structure.kind(place) == wrong {
                    check.wrong_arc(list / 2, place, is_output);
                }
            });
        }
    }
}
