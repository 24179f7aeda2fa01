//! Checks a model and puts numbers in the place of names.

use std::collections::{HashMap, HashSet};

use super::error::ModelError;
use super::lists::{Lists, NumberedArc};
use super::model::{Binding, ModelData, NetModel, PlaceKind, SetData};
use super::net::PlaceId;
use super::structure::Structure;
use super::symbols::{Element, NameId};

/// The structure of a sound model, or everything that is wrong with it.
pub(super) fn resolve(data: &ModelData) -> Result<Structure, Vec<ModelError>> {
    let mut check = Check {
        data,
        errors: Vec::new(),
    };
    check.sizes();
    check.names();
    if !check.errors.is_empty() {
        // Numbers may be ambiguous or not fit; what follows relies on them.
        return Err(check.errors);
    }
    let marked = check.marks();
    let ending = check.sets();
    check.bindings();
    let structure = check.arcs(marked, &ending);
    if check.errors.is_empty() {
        Ok(structure)
    } else {
        Err(check.errors)
    }
}

struct Check<'a> {
    data: &'a ModelData,
    errors: Vec<ModelError>,
}

impl Check<'_> {
    fn net(&self) -> String {
        self.data.name.clone()
    }

    fn owned(&self, name: NameId) -> String {
        self.data.name_of(name).to_owned()
    }

    fn sizes(&mut self) {
        if self.data.transitions.is_empty() {
            self.errors
                .push(ModelError::NoTransitions { net: self.net() });
        }
        for (what, found, limit) in [
            ("places", self.data.places.len(), NetModel::MAX_PLACES),
            (
                "transitions",
                self.data.transitions.len(),
                NetModel::MAX_TRANSITIONS,
            ),
            ("arcs", self.data.arcs.len(), NetModel::MAX_ARCS),
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

    fn names(&mut self) {
        let data = self.data;
        match data.symbols.nameless() {
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
            let mut known = HashSet::new();
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

    /// The number of the place `name`, or an error and nothing.
    fn place(&mut self, name: NameId, user: impl FnOnce() -> String) -> Option<usize> {
        match self.data.symbols.element(name) {
            Element::Place(number) => return Some(number as usize),
            Element::Transition(_) => self.errors.push(ModelError::NotAPlace {
                net: self.net(),
                user: user(),
                name: self.owned(name),
            }),
            Element::Unknown => self.errors.push(ModelError::UnknownName {
                net: self.net(),
                user: user(),
                name: self.owned(name),
            }),
        }
        None
    }

    fn marks(&mut self) -> Box<[bool]> {
        let data = self.data;
        let user = || "the initial marking".to_owned();
        let mut marked = vec![false; data.places.len()].into_boxed_slice();
        for &name in &data.marks {
            let Some(place) = self.place(name, user) else {
                continue;
            };
            if std::mem::replace(&mut marked[place], true) {
                self.named_twice(name, user());
            }
        }
        marked
    }

    fn named_twice(&mut self, place: NameId, user: String) {
        self.errors.push(ModelError::PlaceNamedTwice {
            net: self.net(),
            user,
            place: self.owned(place),
        });
    }

    /// Checks exclusions and ends; which places are marked at an end, none if there is no end.
    fn sets(&mut self) -> Vec<bool> {
        let data = self.data;
        if data.exclusions.is_empty() && data.ends.is_empty() {
            return Vec::new();
        }
        // By name: the last set that has it, counted from one.
        let mut last_set = vec![0; data.symbols.len()];
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

    fn set(
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
            if std::mem::replace(&mut last_set[name.index()], number) == number {
                self.named_twice(name, user());
            }
        }
        places
    }

    fn bindings(&mut self) {
        let data = self.data;
        // Events are known by their names alone, so no flag may share one.
        let mut events: HashMap<String, (&Binding, NameId)> = HashMap::new();
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

    fn arcs(&mut self, marked: Box<[bool]>, ending: &[bool]) -> Structure {
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
        let symbols = &self.data.symbols;
        match (symbols.element(from), symbols.element(to)) {
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
            if self.data.symbols.element(name) == Element::Unknown {
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
                what: match self.data.symbols.element(from) {
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
                if std::mem::replace(&mut last_list[place.index()], list) == list {
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
