//! Checks a model and puts numbers in the place of names.

use std::collections::HashMap;

use super::error::ModelError;
use super::model::{Binding, ModelData, NetModel, PlaceKind, SetData};
use super::net::{PlaceId, TransitionId};
use super::symbols::{Element, NameId};

/// A checked model in numbers: what every form of execution or analysis begins with. Places and
/// transitions count in the order of declaration.
#[derive(Clone, Debug)]
pub struct Structure {
    kinds: Box<[PlaceKind]>,
    marked: Box<[bool]>,
    inputs: Lists,
    outputs: Lists,
    /// By transition: some place is input and output.
    self_loops: Box<[bool]>,
}

/// One list of places per transition.
#[derive(Clone, Debug)]
struct Lists {
    starts: Box<[u32]>,
    places: Box<[PlaceId]>,
}

impl Lists {
    fn of(&self, transition: TransitionId) -> &[PlaceId] {
        let from = self.starts[transition.index()] as usize;
        let to = self.starts[transition.index() + 1] as usize;
        &self.places[from..to]
    }
}

impl Structure {
    /// How many places there are.
    pub fn place_count(&self) -> usize {
        self.kinds.len()
    }

    /// How many transitions there are.
    pub fn transition_count(&self) -> usize {
        self.inputs.starts.len() - 1
    }

    /// How many arcs there are.
    pub fn arc_count(&self) -> usize {
        self.inputs.places.len() + self.outputs.places.len()
    }

    /// All transitions.
    pub fn transitions(&self) -> impl ExactSizeIterator<Item = TransitionId> + Clone + use<> {
        (0..self.transition_count()).map(TransitionId::from_index)
    }

    /// All places.
    pub fn places(&self) -> impl ExactSizeIterator<Item = PlaceId> + Clone + use<> {
        (0..self.place_count()).map(PlaceId::from_index)
    }

    /// The input places of a transition, in the order of declaration.
    pub fn inputs(&self, transition: TransitionId) -> &[PlaceId] {
        self.inputs.of(transition)
    }

    /// The output places of a transition, in the order of declaration.
    pub fn outputs(&self, transition: TransitionId) -> &[PlaceId] {
        self.outputs.of(transition)
    }

    /// Whether some place is input and output of a transition.
    pub fn has_self_loop(&self, transition: TransitionId) -> bool {
        self.self_loops[transition.index()]
    }

    /// Who marks and empties a place.
    pub fn kind(&self, place: PlaceId) -> PlaceKind {
        self.kinds[place.index()]
    }

    /// Whether a place is marked initially.
    pub fn marked(&self, place: PlaceId) -> bool {
        self.marked[place.index()]
    }
}

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

    /// Checks exclusions and ends; the numbers of the places that are marked at an end.
    fn sets(&mut self) -> Vec<usize> {
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
        let mut ending = Vec::new();
        for set in &data.ends {
            for place in self.set("end", set) {
                ending.push(place);
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
        let mut flags: HashMap<String, (&Binding, NameId)> = HashMap::new();
        for place in &data.places {
            let Some(binding) = &place.binding else {
                continue;
            };
            let empty = match binding {
                Binding::Event(name) => name.is_empty().then_some("an event"),
                Binding::Flag { protocol, flag } => {
                    let event = binding.event_name();
                    let (first, name) =
                        *flags.entry(event.clone()).or_insert((binding, place.name));
                    if first != binding {
                        self.errors.push(ModelError::AmbiguousFlag {
                            net: self.net(),
                            first: self.owned(name),
                            second: self.owned(place.name),
                            event,
                        });
                    }
                    (protocol.is_empty().then_some("a protocol"))
                        .or(flag.is_empty().then_some("a flag"))
                }
            };
            if let Some(what) = empty {
                self.errors.push(ModelError::EmptyName {
                    net: self.net(),
                    what,
                });
            }
        }
    }

    fn arcs(&mut self, marked: Box<[bool]>, ending: &[usize]) -> Structure {
        let data = self.data;
        let transitions = data.transitions.len();
        let mut input_starts = vec![0_u32; transitions + 1];
        let mut output_starts = vec![0_u32; transitions + 1];
        // In numbers: place, transition, whether it leads into the transition.
        let mut arcs = Vec::with_capacity(data.arcs.len());
        for &(from, to) in &data.arcs {
            match (data.symbols.element(from), data.symbols.element(to)) {
                (Element::Place(place), Element::Transition(transition)) => {
                    input_starts[transition as usize + 1] += 1;
                    arcs.push((place, transition, true));
                }
                (Element::Transition(transition), Element::Place(place)) => {
                    output_starts[transition as usize + 1] += 1;
                    arcs.push((place, transition, false));
                }
                (from_is, to_is) => self.bad_arc((from, from_is), (to, to_is)),
            }
        }
        accumulate(&mut input_starts);
        accumulate(&mut output_starts);
        let mut inputs = vec![PlaceId(0); input_starts[transitions] as usize];
        let mut outputs = vec![PlaceId(0); output_starts[transitions] as usize];
        // Where the next arc of each transition goes.
        let mut next_input = input_starts.clone();
        let mut next_output = output_starts.clone();
        // Per place: whether an arc leaves it, and whether one enters it.
        let mut degrees = vec![(false, false); data.places.len()];
        for (place, transition, into) in arcs {
            let (list, next, degree) = if into {
                let degree = &mut degrees[place as usize].0;
                (&mut inputs, &mut next_input, degree)
            } else {
                let degree = &mut degrees[place as usize].1;
                (&mut outputs, &mut next_output, degree)
            };
            let next = &mut next[transition as usize];
            list[*next as usize] = PlaceId(place as u16);
            *next += 1;
            *degree = true;
        }
        let mut structure = Structure {
            kinds: data.places.iter().map(|place| place.kind).collect(),
            marked,
            inputs: Lists {
                starts: input_starts.into(),
                places: inputs.into(),
            },
            outputs: Lists {
                starts: output_starts.into(),
                places: outputs.into(),
            },
            self_loops: Box::default(),
        };
        structure.self_loops = self.transitions(&structure);
        self.degrees(&structure, &degrees, ending);
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
        let data = self.data;
        const NEVER: u32 = u32::MAX;
        let mut self_loops = vec![false; data.transitions.len()].into_boxed_slice();
        let mut last_input = vec![NEVER; structure.place_count()];
        let mut last_output = vec![NEVER; structure.place_count()];
        for transition in structure.transitions() {
            let number = transition.index() as u32;
            let transition_name = data.transitions[transition.index()];
            if structure.inputs(transition).is_empty() {
                self.errors.push(ModelError::TransitionWithoutInput {
                    net: self.net(),
                    transition: self.owned(transition_name),
                });
            }
            for &place in structure.inputs(transition) {
                let place_name = data.places[place.index()].name;
                if std::mem::replace(&mut last_input[place.index()], number) == number {
                    self.errors.push(ModelError::DuplicateArc {
                        net: self.net(),
                        from: self.owned(place_name),
                        to: self.owned(transition_name),
                    });
                }
                if structure.kind(place) == PlaceKind::Sink {
                    self.errors.push(ModelError::ArcOutOfSink {
                        net: self.net(),
                        place: self.owned(place_name),
                        transition: self.owned(transition_name),
                    });
                }
            }
            for &place in structure.outputs(transition) {
                let place_name = data.places[place.index()].name;
                if last_input[place.index()] == number {
                    self_loops[transition.index()] = true;
                }
                if std::mem::replace(&mut last_output[place.index()], number) == number {
                    self.errors.push(ModelError::DuplicateArc {
                        net: self.net(),
                        from: self.owned(transition_name),
                        to: self.owned(place_name),
                    });
                }
                if structure.kind(place) == PlaceKind::Source {
                    self.errors.push(ModelError::ArcIntoSource {
                        net: self.net(),
                        place: self.owned(place_name),
                        transition: self.owned(transition_name),
                    });
                }
            }
        }
        self_loops
    }

    /// Every place is connected, and something marks and something empties it.
    fn degrees(&mut self, structure: &Structure, degrees: &[(bool, bool)], ending: &[usize]) {
        for (index, &(leaves, enters)) in degrees.iter().enumerate() {
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
            } else if internal && !leaves && !ending.contains(&index) {
                self.errors.push(ModelError::UnboundSink { net, place });
            }
        }
    }
}

/// Turns counts, each behind its index, into starts.
fn accumulate(starts: &mut [u32]) {
    let mut sum = 0;
    for start in starts {
        sum += *start;
        *start = sum;
    }
}
