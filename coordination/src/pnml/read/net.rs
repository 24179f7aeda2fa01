//! One net as its document has it, pages flattened.

use std::collections::HashMap;

use roxmltree::Node;

use super::super::error::ReadError;
use super::super::grammar::PT_NET;
use super::super::own as words;
use super::element::{Unique, at, elements, known, label, number, required, unexpected, unique};
use super::limits::MAX_DEPTH;
use super::own::{Declared, Port, port};
use crate::petri::NetModel;

/// What an id stands for, by its number among its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Target {
    Place(usize),
    Transition(usize),
    Reference(usize),
}

/// A place or a transition.
pub(super) struct RawNode<'a> {
    pub(super) id: &'a str,
    pub(super) name: Option<String>,
    pub(super) marked: bool,
    pub(super) port: Option<Port<'a>>,
}

/// A node that stands for another one, of the same kind.
pub(super) struct Reference<'a, 'input> {
    pub(super) node: Node<'a, 'input>,
    pub(super) to: &'a str,
    pub(super) is_place: bool,
}

pub(super) struct RawArc<'a, 'input> {
    pub(super) node: Node<'a, 'input>,
    pub(super) from: &'a str,
    pub(super) to: &'a str,
}

/// A net before its names and references are resolved.
pub(super) struct RawNet<'a, 'input> {
    pub(super) id: &'a str,
    pub(super) name: Option<String>,
    pub(super) places: Vec<RawNode<'a>>,
    pub(super) transitions: Vec<RawNode<'a>>,
    pub(super) references: Vec<Reference<'a, 'input>>,
    pub(super) arcs: Vec<RawArc<'a, 'input>>,
    pub(super) targets: HashMap<&'a str, Target>,
    pub(super) declared: Declared<'a, 'input>,
}

const IN_PAGES: &[&str] = &[
    "place",
    "transition",
    "arc",
    "page",
    "referencePlace",
    "referenceTransition",
    "name",
    "graphics",
    "toolspecific",
];

impl<'a, 'input> RawNet<'a, 'input> {
    pub(super) fn read(node: Node<'a, 'input>, ids: &mut Unique<'a>) -> Result<Self, ReadError> {
        let id = unique(node, ids)?;
        let kind = required(node, "type")?;
        if kind != PT_NET {
            return Err(unexpected(
                node,
                &format!("a net of type `{kind}`"),
                format!("a place/transition net, `{PT_NET}`"),
            ));
        }
        let mut net = Self {
            id,
            name: None,
            places: Vec::new(),
            transitions: Vec::new(),
            references: Vec::new(),
            arcs: Vec::new(),
            targets: HashMap::new(),
            declared: Declared::default(),
        };
        for child in elements(node, IN_PAGES)? {
            match known(child, IN_PAGES)? {
                "name" => net.name = label(child)?,
                "toolspecific" => net.declared.read(child)?,
                kind => net.part(kind, child, 0, ids)?,
            }
        }
        Ok(net)
    }

    /// Something of a page.
    fn part(
        &mut self,
        kind: &str,
        node: Node<'a, 'input>,
        depth: usize,
        ids: &mut Unique<'a>,
    ) -> Result<(), ReadError> {
        match kind {
            "place" => self.place(node, ids),
            "transition" => self.transition(node, ids),
            "arc" => self.arc(node, ids),
            "page" => self.page(node, depth + 1, ids),
            "referencePlace" => self.reference(node, true, ids),
            "referenceTransition" => self.reference(node, false, ids),
            _ => Ok(()),
        }
    }

    fn page(
        &mut self,
        node: Node<'a, 'input>,
        depth: usize,
        ids: &mut Unique<'a>,
    ) -> Result<(), ReadError> {
        unique(node, ids)?;
        if depth > MAX_DEPTH {
            return Err(ReadError::TooMany {
                at: at(node),
                what: "pages in each other",
                limit: MAX_DEPTH,
            });
        }
        for child in elements(node, IN_PAGES)? {
            self.part(known(child, IN_PAGES)?, child, depth, ids)?;
        }
        Ok(())
    }

    fn place(&mut self, node: Node<'a, 'input>, ids: &mut Unique<'a>) -> Result<(), ReadError> {
        const IN_PLACES: &[&str] = &["name", "initialMarking", "graphics", "toolspecific"];
        let mut place = self.new_node(node, Target::Place(self.places.len()), ids)?;
        room(node, self.places.len(), "places", NetModel::MAX_PLACES)?;
        for child in elements(node, IN_PLACES)? {
            match known(child, IN_PLACES)? {
                "name" => place.name = label(child)?,
                "initialMarking" => {
                    const EXPECTED: &str = "0 or 1, as the net is safe";
                    place.marked = match number(child, EXPECTED)? {
                        None | Some(0) => false,
                        Some(1) => true,
                        Some(more) => {
                            return Err(unexpected(node, &format!("{more} tokens"), EXPECTED));
                        }
                    };
                }
                "toolspecific" => {
                    if let Some(found) = port(child)?
                        && place.port.replace(found).is_some()
                    {
                        return Err(unexpected(child, "a second binding", "one"));
                    }
                }
                _ => {}
            }
        }
        self.places.push(place);
        Ok(())
    }

    fn transition(
        &mut self,
        node: Node<'a, 'input>,
        ids: &mut Unique<'a>,
    ) -> Result<(), ReadError> {
        const IN_TRANSITIONS: &[&str] = &["name", "graphics", "toolspecific"];
        let mut transition =
            self.new_node(node, Target::Transition(self.transitions.len()), ids)?;
        let limit = NetModel::MAX_TRANSITIONS;
        room(node, self.transitions.len(), "transitions", limit)?;
        for child in elements(node, IN_TRANSITIONS)? {
            if known(child, IN_TRANSITIONS)? == "name" {
                transition.name = label(child)?;
            }
        }
        self.transitions.push(transition);
        Ok(())
    }

    fn new_node(
        &mut self,
        node: Node<'a, 'input>,
        target: Target,
        ids: &mut Unique<'a>,
    ) -> Result<RawNode<'a>, ReadError> {
        let id = unique(node, ids)?;
        self.targets.insert(id, target);
        Ok(RawNode {
            id,
            name: None,
            marked: false,
            port: None,
        })
    }

    fn reference(
        &mut self,
        node: Node<'a, 'input>,
        is_place: bool,
        ids: &mut Unique<'a>,
    ) -> Result<(), ReadError> {
        const IN_REFERENCES: &[&str] = &["name", "graphics", "toolspecific"];
        for child in elements(node, IN_REFERENCES)? {
            known(child, IN_REFERENCES)?;
        }
        let target = Target::Reference(self.references.len());
        self.targets.insert(unique(node, ids)?, target);
        let to = required(node, words::REF)?;
        self.references.push(Reference { node, to, is_place });
        Ok(())
    }

    fn arc(&mut self, node: Node<'a, 'input>, ids: &mut Unique<'a>) -> Result<(), ReadError> {
        const IN_ARCS: &[&str] = &["name", "inscription", "graphics", "toolspecific"];
        const EXPECTED: &str = "weight 1, as the net is safe";
        unique(node, ids)?;
        room(node, self.arcs.len(), "arcs", NetModel::MAX_ARCS)?;
        for child in elements(node, IN_ARCS)? {
            if known(child, IN_ARCS)? == "inscription"
                && let Some(weight) = number(child, EXPECTED)?
                && weight != 1
            {
                return Err(unexpected(node, &format!("weight {weight}"), EXPECTED));
            }
        }
        let (from, to) = (required(node, "source")?, required(node, "target")?);
        self.arcs.push(RawArc { node, from, to });
        Ok(())
    }
}

fn room(
    node: Node<'_, '_>,
    count: usize,
    what: &'static str,
    limit: usize,
) -> Result<(), ReadError> {
    match count < limit {
        true => Ok(()),
        false => Err(ReadError::TooMany {
            at: at(node),
            what,
            limit,
        }),
    }
}
