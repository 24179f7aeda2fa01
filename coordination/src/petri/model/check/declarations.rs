//! Names, marks, exclusions, ends and bindings of a model.

use alloc::borrow::ToOwned;
use alloc::boxed::Box;
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;

use super::super::binding::{Binding, PlaceKind};
use super::super::data::SetData;
use super::super::error::ModelError;
use super::super::names::{Element, NameId};
use super::errors::Check;

/// The most places that a net has.
pub(in crate::petri) const MAX_PLACES: usize = 1 << 16;
/// The most transitions that a net has.
pub(in crate::petri) const MAX_TRANSITIONS: usize = 1 << 16;
/// The most arcs that a net has.
pub(in crate::petri) const MAX_ARCS: usize = 1 << 22;

impl Check<'_> {
    pub(super) fn sizes(&mut self) {
        if self.data.transitions.is_empty() {
            self.errors
                .push(ModelError::NoTransitions { net: self.net() });
        }
        for (what, found, limit) in [
            ("places", self.data.places.len(), MAX_PLACES),
            ("transitions", self.data.transitions.len(), MAX_TRANSITIONS),
            ("arcs", self.data.arcs.len(), MAX_ARCS),
        ] {
            if found > limit {
                self.errors.push(ModelError::TooLarge {
                    net: self.net(),
                    what,
                    found,
                    limit,
                });
            }
        }
    }

    pub(super) fn names(&mut self) {
        let data = self.data;
        match data.names.nameless() {
            Element::Unknown => {}
            element => self.errors.push(ModelError::EmptyName {
                net: self.net(),
                what: element.kind(),
            }),
        }
        for duplicate in &data.duplicates {
            self.errors.push(ModelError::DuplicateName {
                net: self.net(),
                name: self.owned(duplicate.name),
                first: duplicate.first.kind(),
                second: duplicate.second.kind(),
            });
        }
        for (what, sets) in [("an exclusion", &data.exclusions), ("an end", &data.ends)] {
            let mut known = BTreeSet::new();
            for set in sets {
                if set.name.is_empty() {
                    self.errors.push(ModelError::EmptyName {
                        net: self.net(),
                        what,
                    });
                } else if !known.insert(&set.name) {
                    self.errors.push(ModelError::DuplicateName {
                        net: self.net(),
                        name: set.name.clone(),
                        first: what,
                        second: what,
                    });
                }
            }
        }
    }

    pub(super) fn marks(&mut self) -> Box<[bool]> {
        let data = self.data;
        let user = || "the initial marking".to_owned();
        let mut marked = vec![false; data.places.len()].into_boxed_slice();
        for &name in &data.marks {
            let Some(place) = self.place(name, user) else {
                continue;
            };
            if core::mem::replace(&mut marked[place], true) {
                self.named_twice(name, user());
            }
        }
        marked
    }

    /// Checks exclusions and ends; which places are marked at an end, none if there is no end.
    pub(super) fn sets(&mut self) -> Vec<bool> {
        let data = self.data;
        if data.exclusions.is_empty() && data.ends.is_empty() {
            return Vec::new();
        }
        // By name: the last set that has it, counted from one.
        let mut last_set = vec![0; data.names.len()];
        let mut number = 0;
        for set in &data.exclusions {
            number += 1;
            self.set("exclusion", set, number, &mut last_set);
            if set.places.len() < 2 {
                self.errors.push(ModelError::ExclusionTooSmall {
                    net: self.net(),
                    exclusion: set.name.clone(),
                    found: set.places.len(),
                });
            }
        }
        let mut ending = vec![false; data.places.len()];
        for set in &data.ends {
            number += 1;
            for place in self.set("end", set, number, &mut last_set) {
                ending[place] = true;
                if data.kinds[place] != PlaceKind::Internal {
                    self.errors.push(ModelError::EndNotInternal {
                        net: self.net(),
                        end: set.name.clone(),
                        place: self.owned(data.places[place]),
                    });
                }
            }
        }
        ending
    }

    pub(super) fn set(
        &mut self,
        what: &str,
        set: &SetData,
        number: usize,
        last_set: &mut [usize],
    ) -> Vec<usize> {
        let user = || format!("{what} `{}`", set.name);
        let mut places = Vec::with_capacity(set.places.len());
        for &name in &set.places {
            places.extend(self.place(name, user));
            if core::mem::replace(&mut last_set[name.index()], number) == number {
                self.named_twice(name, user());
            }
        }
        places
    }

    pub(super) fn bindings(&mut self) {
        let data = self.data;
        // Events are known by their names alone, so no flag may share one.
        let mut events: BTreeMap<String, (&Binding, NameId)> = BTreeMap::new();
        for (place, binding) in &data.bindings {
            let place = data.places[*place as usize];
            let event = binding.event_name();
            let (first, name) = *events.entry(event.clone()).or_insert((binding, place));
            if first != binding {
                self.errors.push(ModelError::AmbiguousFlag {
                    net: self.net(),
                    first: self.owned(name),
                    second: self.owned(place),
                    event,
                });
            }
            let empty = match binding {
                Binding::Event(name) => name.is_empty().then_some("an event"),
                Binding::Flag { protocol, flag } => (protocol.is_empty().then_some("a protocol"))
                    .or(flag.is_empty().then_some("a flag")),
            };
            if let Some(what) = empty {
                self.errors.push(ModelError::EmptyName {
                    net: self.net(),
                    what,
                });
            }
        }
    }
}
