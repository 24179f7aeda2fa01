//! Names and what they stand for.

use alloc::sync::Arc;
use alloc::vec::Vec;

use hashbrown::HashMap;

/// A name that a model mentions, declared or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in crate::petri) struct NameId(u32);

impl NameId {
    pub(in crate::petri) fn index(self) -> usize {
        self.0 as usize
    }
}

/// What a name stands for; numbers count in the order of declaration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::petri) enum Element {
    Unknown,
    Place(u32),
    Transition(u32),
}

impl Element {
    pub(in crate::petri) fn kind(self) -> &'static str {
        match self {
            Self::Unknown => "nothing",
            Self::Place(_) => "a place",
            Self::Transition(_) => "a transition",
        }
    }
}

/// All names of a model. Names are looked up while the model is built, so that checking and
/// compiling it need numbers only.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(in crate::petri) struct Names {
    names: Vec<Arc<str>>,
    elements: Vec<Element>,
    ids: HashMap<Arc<str>, NameId>,
    /// The id of the empty name.
    empty: Option<NameId>,
}

impl Names {
    /// The id of `name`, which is added if it is new.
    pub(in crate::petri) fn intern(&mut self, name: &str) -> NameId {
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
    pub(in crate::petri) fn declare(
        &mut self,
        id: NameId,
        element: Element,
    ) -> Result<(), Element> {
        let present = &mut self.elements[id.0 as usize];
        match *present {
            Element::Unknown => {
                *present = element;
                Ok(())
            }
            other => Err(other),
        }
    }

    pub(in crate::petri) fn element(&self, id: NameId) -> Element {
        self.elements[id.0 as usize]
    }

    pub(in crate::petri) fn name(&self, id: NameId) -> &str {
        &self.names[id.0 as usize]
    }

    /// How many names there are.
    pub(in crate::petri) fn len(&self) -> usize {
        self.names.len()
    }

    /// What the empty name stands for.
    pub(in crate::petri) fn nameless(&self) -> Element {
        self.empty
            .map_or(Element::Unknown, |empty| self.element(empty))
    }

    pub(in crate::petri) fn find(&self, name: &str) -> Element {
        self.ids
            .get(name)
            .map_or(Element::Unknown, |&id| self.element(id))
    }
}
