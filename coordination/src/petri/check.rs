//! Checks a model and puts numbers in the place of names.

use std::collections::HashMap;

use super::error::ModelError;
use super::model::{Binding, ModelData, NetModel, PlaceKind, SetData};
use super::net::PlaceId;
use super::structure::{Degrees, Structure};
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
        match data.symbols.find("") {
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
            for (index, set) in sets.iter().enumerate() {
                if set.name.is_empty() {
                    self.errors.push(ModelError::EmptyName {
                        net: self.net(),
                        what,
                    });
                } else if sets[..index].iter().any(|other| other.name == set.name) {
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

    /// Checks exclusions and ends; which places are marked at an end.
    fn sets(&mut self) -> Vec<bool> {
        let data = self.data;
        for set in &data.exclusions {
            self.set("exclusion", set);
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
            for place in self.set("end", set) {
                ending[place] = true;
                let found = &data.places[place];
                if found.kind != PlaceKind::Internal {
                    self.errors.push(ModelError::EndNotInternal {
                        net: self.net(),
                        end: set.name.clone(),
                        place: self.owned(found.name),
                    });
                }
            }
        }
        ending
    }

    fn set(&mut self, what: &str, set: &SetData) -> Vec<usize> {
        let user = || format!("{what} `{}`", set.name);
        let mut places = Vec::with_capacity(set.places.len());
        for (index, &name) in set.places.iter().enumerate() {
            if let Some(place) = self.place(name, user) {
                places.push(place);
            }
            if set.places[..index].contains(&name) {
                self.named_twice(name, user());
            }
        }
        places
    }

    fn bindings(&mut self) {
        let data = self.data;
        // Events are known by their names alone, so no flag may share one.
        let mut events: HashMap<String, (&Binding, NameId)> = HashMap::new();
        for place in &data.places {
            let Some(binding) = &place.binding else {
                continue;
            };
            let event = binding.event_name();
            let (first, name) = *events.entry(event.clone()).or_insert((binding, place.name));
            if first != binding {
                self.errors.push(ModelError::AmbiguousFlag {
                    net: self.net(),
                    first: self.owned(name),
                    second: self.owned(place.name),
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
        let lists = 2 * data.transitions.len();
        let mut starts = vec![0_u32; lists + 1];
        let mut degrees = vec![Degrees::default(); data.places.len()];
        // In numbers: list and place.
        let mut arcs = Vec::with_capacity(data.arcs.len());
        for &(from, to) in &data.arcs {
            let arc = match (data.symbols.element(from), data.symbols.element(to)) {
                (Element::Place(place), Element::Transition(transition)) => {
                    degrees[place as usize].out += 1;
                    (2 * transition, place)
                }
                (Element::Transition(transition), Element::Place(place)) => {
                    degrees[place as usize].into += 1;
                    (2 * transition + 1, place)
                }
                (from_is, to_is) => {
                    self.bad_arc((from, from_is), (to, to_is));
                    continue;
                }
            };
            starts[arc.0 as usize + 1] += 1;
            arcs.push(arc);
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        // Where the next place of each list goes.
        let mut next = starts.clone();
        let mut places = vec![PlaceId(0); arcs.len()];
        for (list, place) in arcs {
            let next = &mut next[list as usize];
            places[*next as usize] = PlaceId(place as u16);
            *next += 1;
        }
        let mut structure = Structure {
            kinds: data.places.iter().map(|place| place.kind).collect(),
            marked,
            starts: starts.into(),
            places: places.into(),
            self_loops: vec![false; data.transitions.len()].into(),
            degrees: degrees.into(),
        };
        structure.self_loops = self.transitions(&structure);
        self.degrees(&structure, ending);
        structure
    }

    fn bad_arc(&mut self, from: (NameId, Element), to: (NameId, Element)) {
        let user = format!(
            "the arc from `{}` to `{}`",
            self.data.name_of(from.0),
            self.data.name_of(to.0)
        );
        let mut known = true;
        for (name, element) in [from, to] {
            if element == Element::Unknown {
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
                from: self.owned(from.0),
                to: self.owned(to.0),
                what: match from.1 {
                    Element::Transition(_) => "transitions",
                    _ => "places",
                },
            });
        }
    }

    /// Arcs of each transition: none twice, none into a source or out of a sink, at least one in.
    /// Returns which have self-loops.
    fn transitions(&mut self, structure: &Structure) -> Box<[bool]> {
        let mut self_loops = vec![false; structure.transition_count()].into_boxed_slice();
        // By place: the last list that has it.
        let mut last_list = vec![usize::MAX; structure.place_count()];
        let ends = structure.starts.windows(2).enumerate();
        for (list, ends) in ends {
            let (transition, is_output) = (list / 2, list % 2 == 1);
            let places = &structure.places[ends[0] as usize..ends[1] as usize];
            if places.is_empty() && !is_output {
                self.errors.push(ModelError::TransitionWithoutInput {
                    net: self.net(),
                    transition: self.owned(self.data.transitions[transition]),
                });
            }
            let wrong = if is_output {
                PlaceKind::Source
            } else {
                PlaceKind::Sink
            };
            for &place in places {
                let last = std::mem::replace(&mut last_list[place.index()], list);
                if last == list {
                    self.duplicate_arc(transition, place, is_output);
                }
                self_loops[transition] |= is_output && last == list - 1;
                if structure.kind(place) == wrong {
                    self.wrong_arc(transition, place, is_output);
                }
            }
        }
        self_loops
    }

    fn duplicate_arc(&mut self, transition: usize, place: PlaceId, is_output: bool) {
        let transition = self.owned(self.data.transitions[transition]);
        let place = self.owned(self.data.places[place.index()].name);
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
        let place = self.owned(self.data.places[place.index()].name);
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

    /// Every place is connected, and something marks and something empties it.
    fn degrees(&mut self, structure: &Structure, ending: &[bool]) {
        for (index, degrees) in structure.degrees.iter().enumerate() {
            let (leaves, enters) = (degrees.out > 0, degrees.into > 0);
            if leaves && enters {
                continue;
            }
            let net = self.net();
            let place = self.owned(self.data.places[index].name);
            let internal = structure.kinds[index] == PlaceKind::Internal;
            if !leaves && !enters {
                self.errors.push(ModelError::IsolatedPlace { net, place });
            } else if internal && !enters && !structure.marked[index] {
                self.errors.push(ModelError::UnboundSource { net, place });
            } else if internal && !leaves && !ending[index] {
                self.errors.push(ModelError::UnboundSink { net, place });
            }
        }
    }
}
