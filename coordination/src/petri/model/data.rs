//! What a model consists of, as it is being built.

use alloc::string::String;
use alloc::vec::Vec;

use super::binding::{Binding, PlaceKind};
use super::names::{Element, NameId, Names};

#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::petri) struct SetData {
    pub(in crate::petri) name: String,
    pub(in crate::petri) places: Vec<NameId>,
}

/// One name for two elements, the first of which keeps it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::petri) struct Duplicate {
    pub(in crate::petri) name: NameId,
    pub(in crate::petri) first: Element,
    pub(in crate::petri) second: Element,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::petri) struct ModelData {
    pub(in crate::petri) name: String,
    pub(in crate::petri) names: Names,
    /// By place: its name.
    pub(in crate::petri) places: Vec<NameId>,
    /// By place.
    pub(in crate::petri) kinds: Vec<PlaceKind>,
    /// The sources and sinks, as indices into the places, in order.
    pub(in crate::petri) bindings: Vec<(u32, Binding)>,
    pub(in crate::petri) transitions: Vec<NameId>,
    pub(in crate::petri) duplicates: Vec<Duplicate>,
    /// From and to.
    pub(in crate::petri) arcs: Vec<(NameId, NameId)>,
    pub(in crate::petri) marks: Vec<NameId>,
    pub(in crate::petri) exclusions: Vec<SetData>,
    pub(in crate::petri) ends: Vec<SetData>,
    /// Whether its transitions may fire for ever without any news from outside.
    pub(in crate::petri) endless: bool,
}

impl ModelData {
    pub(in crate::petri) fn name_of(&self, id: NameId) -> &str {
        self.names.name(id)
    }
}
