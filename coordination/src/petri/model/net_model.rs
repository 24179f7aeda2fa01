//! The symbolic model of a net.

use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec;
use alloc::vec::Vec;

use super::binding::{Binding, PlaceKind};
use super::check;
use super::data::{Duplicate, ModelData, SetData};
use super::error::ModelError;
use super::names::{Element, NameId, Names};
use super::structure::Structure;

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
    pub const MAX_PLACES: usize = check::MAX_PLACES;
    /// The most transitions that a net has.
    pub const MAX_TRANSITIONS: usize = check::MAX_TRANSITIONS;
    /// The most arcs that a net has.
    pub const MAX_ARCS: usize = check::MAX_ARCS;

    /// A net without places and transitions.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            data: Arc::new(ModelData {
                name: name.into(),
                names: Names::default(),
                places: Vec::new(),
                kinds: Vec::new(),
                bindings: Vec::new(),
                transitions: Vec::new(),
                duplicates: Vec::new(),
                arcs: Vec::new(),
                marks: Vec::new(),
                exclusions: Vec::new(),
                ends: Vec::new(),
                endless: false,
            }),
        }
    }

    /// The net's name.
    #[must_use]
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
        let place = data.names.intern(place);
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
        let transition = data.names.intern(name.as_ref());
        data.transitions.push(transition);
        declare(data, transition, Element::Transition(number));
        for input in inputs {
            let input = data.names.intern(input);
            data.arcs.push((input, transition));
        }
        for output in outputs {
            let output = data.names.intern(output);
            data.arcs.push((transition, output));
        }
        self
    }

    /// Adds an arc from a place to a transition or from a transition to a place, both of which are
    /// added elsewhere.
    pub fn arc(&mut self, from: &str, to: &str) -> &mut Self {
        let data = self.edit();
        let arc = (data.names.intern(from), data.names.intern(to));
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

    /// Declares that the net's transitions may fire for ever without any flag or event from outside,
    /// for which the analysis refuses it otherwise.
    pub fn allow_endless(&mut self) -> &mut Self {
        self.edit().endless = true;
        self
    }

    /// Whether [`allow_endless`](Self::allow_endless) was called.
    #[must_use]
    pub fn allows_endless(&self) -> bool {
        self.data.endless
    }

    /// Everything that is wrong with the model; nothing if it compiles.
    #[must_use]
    pub fn check(&self) -> Vec<ModelError> {
        check::resolve(&self.data).err().unwrap_or_default()
    }

    /// The checked model in numbers instead of names.
    ///
    /// # Errors
    /// Everything that [`check`](Self::check) finds.
    pub fn structure(&self) -> Result<Structure, Vec<ModelError>> {
        check::resolve(&self.data)
    }

    /// All places, in the order of declaration.
    #[must_use]
    pub fn places(&self) -> impl ExactSizeIterator<Item = Place<'_>> {
        let data = &*self.data;
        let mut marked = vec![false; data.places.len()];
        for &mark in &data.marks {
            if let Element::Place(number) = data.names.element(mark) {
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
    #[must_use]
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
            match (data.names.element(from), data.names.element(to)) {
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
    #[must_use]
    pub fn exclusions(&self) -> impl ExactSizeIterator<Item = PlaceSet<'_>> {
        self.data.exclusions.iter().map(|set| self.named(set))
    }

    /// All ends, in the order of declaration.
    #[must_use]
    pub fn ends(&self) -> impl ExactSizeIterator<Item = PlaceSet<'_>> {
        self.data.ends.iter().map(|set| self.named(set))
    }

    pub(in crate::petri) fn from_data(data: Arc<ModelData>) -> Self {
        Self { data }
    }

    /// Whether both are one model: the same names and numbers, marks and bindings. Quick for a model
    /// and its clones.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.data, &other.data) || self.data == other.data
    }

    pub(in crate::petri) fn data(&self) -> &Arc<ModelData> {
        &self.data
    }

    fn edit(&mut self) -> &mut ModelData {
        Arc::make_mut(&mut self.data)
    }

    fn add_place(&mut self, name: &str, kind: PlaceKind, binding: Option<Binding>) -> &mut Self {
        let data = self.edit();
        let number = data.places.len() as u32;
        let name = data.names.intern(name);
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
            .map(|place| data.names.intern(place))
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
    if let Err(first) = data.names.declare(name, second) {
        data.duplicates.push(Duplicate {
            name,
            first,
            second,
        });
    }
}
