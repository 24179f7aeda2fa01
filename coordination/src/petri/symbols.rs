//! Names and what they stand for.

use std::collections::HashMap;
use std::sync::Arc;

/// A name that a model mentions, declared or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct NameId(u32);

impl NameId {
    pub(super) fn index(self) -> usize {
        self.0 as usize
    }
}

/// What a name stands for; numbers count in the order of declaration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Element {
    Unknown,
    Place(u32),
    Transition(u32),
}

impl Element {
    pub(super) fn kind(self) -> &'static str {
        match self {
            Self::Unknown => "nothing",
            Self::Place(_) => "a place",
            Self::Transition(_) => "a transition",
        }
    }
}

/// All names of a model. Names are looked up while the model is built, so that checking and
/// compiling it need numbers only.
#[derive(Clone, Debug, Default)]
pub(super) struct Symbols {
    names: Vec<Arc<str>>,
    elements: Vec<Element>,
    ids: HashMap<Arc<str>, NameId>,
    /// The id of the empty name.
    empty: Option<NameId>,
}

impl Symbols {
    /// The id of `name`, which is added if it is new.
    pub(super) fn intern(&mut self, name: &str) -> NameId {
        if let Some(&id) = self.ids.get(name) {
            return id;
        }
        let id = NameId(self.names.len() as u32);
        if name.is_empty() {
            self.empty = Some(id);
        }
        let name: Arc<str> = name.into();
        self.names.push(Arc::clone(&name));
        self.elements.push(Element::Unknown);
        self.ids.insert(name, id);
        id
    }

    /// Lets `id` stand for `element`, unless it stands for something else, which is returned.
    pub(super) fn declare(&mut self, id: NameId, element: Element) -> Result<(), Element> {
        let present = &mut self.elements[id.0 as usize];
        match *present {
            Element::Unknown => {
                *present = element;
                Ok(())
            }
            other => Err(other),
        }
    }

    pub(super) fn element(&self, id: NameId) -> Element {
        self.elements[id.0 as usize]
    }

    pub(super) fn name(&self, id: NameId) -> &str {
        &self.names[id.0 as usize]
    }

    /// How many names there are.
    pub(super) fn len(&self) -> usize {
        self.names.len()
    }

    /// What the empty name stands for.
    pub(super) fn nameless(&self) -> Element {
        self.empty
            .map_or(Element::Unknown, |empty| self.element(empty))
    }

    pub(super) fn find(&self, name: &str) -> Element {
        self.ids
            .get(name)
            .map_or(Element::Unknown, |&id| self.element(id))
    }
}
