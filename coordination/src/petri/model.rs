//! The symbolic model of a net.

use std::sync::Arc;

use super::check;
use super::error::ModelError;
use super::net::Net;
use super::structure::Structure;
use super::symbols::{Element, NameId, Symbols};
use crate::event::EventTable;

/// What a source or a sink is bound to.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Binding {
    /// An event of that name.
    Event(String),
    /// A flag of a protocol array.
    Flag {
        /// The protocol's name.
        protocol: String,
        /// The flag's name.
        flag: String,
    },
}

impl Binding {
    /// A binding to the event called `name`.
    pub fn event(name: impl Into<String>) -> Self {
        Self::Event(name.into())
    }

    /// A binding to the flag called `flag` of the protocol called `protocol`.
    pub fn flag(protocol: impl Into<String>, flag: impl Into<String>) -> Self {
        Self::Flag {
            protocol: protocol.into(),
            flag: flag.into(),
        }
    }

    /// The name in the [`EventTable`]: the event's own, or `<protocol>.<flag>`.
    pub fn event_name(&self) -> String {
        match self {
            Self::Event(name) => name.clone(),
            Self::Flag { protocol, flag } => format!("{protocol}.{flag}"),
        }
    }
}

/// Who marks and who empties a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PlaceKind {
    /// The net's transitions mark and empty it.
    Internal,
    /// An incoming event or flag marks it.
    Source,
    /// Its mark is an outgoing event or flag; whoever consumes that empties it.
    Sink,
}

/// One place of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place<'a> {
    /// Its name.
    pub name: &'a str,
    /// Who marks and empties it.
    pub kind: PlaceKind,
    /// What it is bound to; internal places are bound to nothing.
    pub binding: Option<&'a Binding>,
    /// Whether it is marked initially.
    pub marked: bool,
}

/// One transition of a model. A place that is input and output keeps its mark.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Transition<'a> {
    /// Its name.
    pub name: &'a str,
    /// The names of its input places, in the order of declaration.
    pub inputs: Vec<&'a str>,
    /// The names of its output places, in the order of declaration.
    pub outputs: Vec<&'a str>,
}

/// A named set of places: an exclusion or an end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlaceSet<'a> {
    /// Its name.
    pub name: &'a str,
    /// The names of its places, in the order of declaration.
    pub places: Vec<&'a str>,
}

#[derive(Clone, Debug)]
pub(super) struct SetData {
    pub(super) name: String,
    pub(super) places: Vec<NameId>,
}

/// One name for two elements, the first of which keeps it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Duplicate {
    pub(super) name: NameId,
    pub(super) first: Element,
    pub(super) second: Element,
}

#[derive(Clone, Debug)]
pub(super) struct ModelData {
    pub(super) name: String,
    pub(super) symbols: Symbols,
    /// By place: its name.
    pub(super) places: Vec<NameId>,
    /// By place.
    pub(super) kinds: Vec<PlaceKind>,
    /// The sources and sinks, as indices into the places, in order.
    pub(super) bindings: Vec<(u32, Binding)>,
    pub(super) transitions: Vec<NameId>,
    pub(super) duplicates: Vec<Duplicate>,
    /// From and to.
    pub(super) arcs: Vec<(NameId, NameId)>,
    pub(super) marks: Vec<NameId>,
    pub(super) exclusions: Vec<SetData>,
    pub(super) ends: Vec<SetData>,
}

impl ModelData {
    pub(super) fn name_of(&self, id: NameId) -> &str {
        self.symbols.name(id)
    }
}

/// A net in names. Adding to it never fails; [`check`](Self::check) and
/// [`compile`](Self::compile) say what is wrong with the whole. Places and transitions are numbered
/// in the order of their declaration.
///
/// A compiled net shares the names, so that compiling copies none.
#[derive(Clone, Debug)]
pub struct NetModel {
    data: Arc<ModelData>,
}

impl NetModel {
    /// The most places that a net has.
    pub const MAX_PLACES: usize = 1 << 16;
    /// The most transitions that a net has.
    pub const MAX_TRANSITIONS: usize = 1 << 16;
    /// The most arcs that a net has.
    pub const MAX_ARCS: usize = 1 << 22;

    /// A net without places and transitions.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            data: Arc::new(ModelData {
                name: name.into(),
                symbols: Symbols::default(),
                places: Vec::new(),
                kinds: Vec::new(),
                bindings: Vec::new(),
                transitions: Vec::new(),
                duplicates: Vec::new(),
                arcs: Vec::new(),
                marks: Vec::new(),
                exclusions: Vec::new(),
                ends: Vec::new(),
            }),
        }
    }

    /// The net's name.
    pub fn name(&self) -> &str {
        &self.data.name
    }

    /// Adds an internal place.
    pub fn place(&mut self, name: impl AsRef<str>) -> &mut Self {
        self.add_place(name.as_ref(), PlaceKind::Internal, None)
    }

    /// Adds a source, which the flag or event it is bound to marks.
    pub fn source(&mut self, name: impl AsRef<str>, binding: Binding) -> &mut Self {
        self.add_place(name.as_ref(), PlaceKind::Source, Some(binding))
    }

    /// Adds a sink, whose mark becomes the flag or event it is bound to.
    pub fn sink(&mut self, name: impl AsRef<str>, binding: Binding) -> &mut Self {
        self.add_place(name.as_ref(), PlaceKind::Sink, Some(binding))
    }

    /// Marks `place`, which is added elsewhere, initially.
    pub fn mark(&mut self, place: &str) -> &mut Self {
        let data = self.edit();
        let place = data.symbols.intern(place);
        data.marks.push(place);
        self
    }

    /// Adds a transition with its arcs. The places are added elsewhere.
    pub fn transition(
        &mut self,
        name: impl AsRef<str>,
        inputs: &[&str],
        outputs: &[&str],
    ) -> &mut Self {
        let data = self.edit();
        let number = data.transitions.len() as u32;
        let transition = data.symbols.intern(name.as_ref());
        data.transitions.push(transition);
        declare(data, transition, Element::Transition(number));
        for input in inputs {
            let input = data.symbols.intern(input);
            data.arcs.push((input, transition));
        }
        for output in outputs {
            let output = data.symbols.intern(output);
            data.arcs.push((transition, output));
        }
        self
    }

    /// Adds an arc from a place to a transition or from a transition to a place, both of which are
    /// added elsewhere.
    pub fn arc(&mut self, from: &str, to: &str) -> &mut Self {
        let data = self.edit();
        let arc = (data.symbols.intern(from), data.symbols.intern(to));
        data.arcs.push(arc);
        self
    }

    /// Declares that at most one of `places` is ever marked. The analysis proves it; the executor
    /// does not look at it.
    pub fn exclusion(&mut self, name: impl Into<String>, places: &[&str]) -> &mut Self {
        let set = self.set(name.into(), places);
        self.edit().exclusions.push(set);
        self
    }

    /// Declares a marking in which the net may rest for ever: exactly these internal places are
    /// marked, and sources and sinks are empty.
    pub fn end(&mut self, name: impl Into<String>, places: &[&str]) -> &mut Self {
        let set = self.set(name.into(), places);
        self.edit().ends.push(set);
        self
    }

    /// Everything that is wrong with the model; nothing if it compiles.
    pub fn check(&self) -> Vec<ModelError> {
        check::resolve(&self.data).err().unwrap_or_default()
    }

    /// The checked model in numbers instead of names.
    pub fn structure(&self) -> Result<Structure, Vec<ModelError>> {
        check::resolve(&self.data)
    }

    /// Checks the model and makes the net, whose events are entered into `events`. Not for
    /// real-time threads.
    pub fn compile(&self, events: &mut EventTable) -> Result<Net, Vec<ModelError>> {
        Net::new(self.structure()?, Arc::clone(&self.data), events).map_err(|error| vec![error])
    }

    /// All places, in the order of declaration.
    pub fn places(&self) -> impl ExactSizeIterator<Item = Place<'_>> {
        let data = &*self.data;
        let mut marked = vec![false; data.places.len()];
        for &mark in &data.marks {
            if let Element::Place(number) = data.symbols.element(mark) {
                marked[number as usize] = true;
            }
        }
        let mut bindings = data.bindings.iter().peekable();
        let all = data.places.iter().zip(&data.kinds).zip(marked).enumerate();
        all.map(move |(index, ((&name, &kind), marked))| {
            let binding = bindings.next_if(|&&(place, _)| place as usize == index);
            Place {
                name: data.name_of(name),
                kind,
                binding: binding.map(|(_, binding)| binding),
                marked,
            }
        })
    }

    /// All transitions, in the order of declaration. Arcs that [`check`](Self::check) refuses are
    /// left out.
    pub fn transitions(&self) -> impl ExactSizeIterator<Item = Transition<'_>> {
        let data = &*self.data;
        let mut transitions: Vec<_> = data
            .transitions
            .iter()
            .map(|&name| Transition {
                name: data.name_of(name),
                inputs: Vec::new(),
                outputs: Vec::new(),
            })
            .collect();
        for &(from, to) in &data.arcs {
            match (data.symbols.element(from), data.symbols.element(to)) {
                (Element::Place(_), Element::Transition(number)) => {
                    transitions[number as usize].inputs.push(data.name_of(from));
                }
                (Element::Transition(number), Element::Place(_)) => {
                    transitions[number as usize].outputs.push(data.name_of(to));
                }
                _ => {}
            }
        }
        transitions.into_iter()
    }

    /// All exclusions, in the order of declaration.
    pub fn exclusions(&self) -> impl ExactSizeIterator<Item = PlaceSet<'_>> {
        self.data.exclusions.iter().map(|set| self.named(set))
    }

    /// All ends, in the order of declaration.
    pub fn ends(&self) -> impl ExactSizeIterator<Item = PlaceSet<'_>> {
        self.data.ends.iter().map(|set| self.named(set))
    }

    pub(super) fn from_data(data: Arc<ModelData>) -> Self {
        Self { data }
    }

    fn edit(&mut self) -> &mut ModelData {
        Arc::make_mut(&mut self.data)
    }

    fn add_place(&mut self, name: &str, kind: PlaceKind, binding: Option<Binding>) -> &mut Self {
        let data = self.edit();
        let number = data.places.len() as u32;
        let name = data.symbols.intern(name);
        data.places.push(name);
        data.kinds.push(kind);
        data.bindings
            .extend(binding.map(|binding| (number, binding)));
        declare(data, name, Element::Place(number));
        self
    }

    fn set(&mut self, name: String, places: &[&str]) -> SetData {
        let data = self.edit();
        let places = places
            .iter()
            .map(|place| data.symbols.intern(place))
            .collect();
        SetData { name, places }
    }

    fn named<'a>(&'a self, set: &'a SetData) -> PlaceSet<'a> {
        PlaceSet {
            name: &set.name,
            places: set
                .places
                .iter()
                .map(|&place| self.data.name_of(place))
                .collect(),
        }
    }
}

fn declare(data: &mut ModelData, name: NameId, second: Element) {
    if let Err(first) = data.symbols.declare(name, second) {
        data.duplicates.push(Duplicate {
            name,
            first,
            second,
        });
    }
}
