//! What our `toolspecific` elements say.

use roxmltree::Node;

use super::super::error::ReadError;
use super::super::own::{
    END, ENDLESS, EVENT, EXCLUSION, FLAG, NAME, PLACE, PROTOCOL, REF, SINK, SOURCE, TOOL, VERBATIM,
    VERSION,
};
use super::element::{elements, required, unexpected};
use crate::petri::Binding;

/// That a place is a source or a sink.
pub(super) struct Port<'a> {
    pub(super) is_source: bool,
    event: Option<&'a str>,
    flag: Option<(&'a str, &'a str)>,
}

impl Port<'_> {
    pub(super) fn binding(&self) -> Binding {
        match (self.event, self.flag) {
            (None, Some((protocol, flag))) => Binding::flag(protocol, flag),
            (event, _) => Binding::event(event.unwrap_or_default()),
        }
    }
}

/// An exclusion or an end.
pub(super) struct RawSet<'a, 'input> {
    pub(super) name: &'a str,
    pub(super) is_end: bool,
    /// An element for each place.
    pub(super) places: Vec<(Node<'a, 'input>, &'a str)>,
}

/// What a net declares.
#[derive(Default)]
pub(super) struct Declared<'a, 'input> {
    pub(super) sets: Vec<RawSet<'a, 'input>>,
    pub(super) endless: bool,
    pub(super) verbatim: bool,
}

/// Whether an element `toolspecific` is ours; then it must have the version that is understood here.
fn is_ours(node: Node<'_, '_>) -> Result<bool, ReadError> {
    match (node.attribute("tool"), node.attribute("version")) {
        (Some(TOOL), Some(VERSION)) => Ok(true),
        (Some(TOOL), version) => {
            let found = format!("version `{}`", version.unwrap_or_default());
            Err(unexpected(node, &found, format!("version `{VERSION}`")))
        }
        _ => Ok(false),
    }
}

/// The port that the element makes of its place.
pub(super) fn port<'a>(node: Node<'a, '_>) -> Result<Option<Port<'a>>, ReadError> {
    if !is_ours(node)? {
        return Ok(None);
    }
    let mut found = None;
    for child in elements(node, &[SOURCE, SINK])? {
        let (protocol, flag) = (child.attribute(PROTOCOL), child.attribute(FLAG));
        let port = Port {
            is_source: child.tag_name().name() == SOURCE,
            event: child.attribute(EVENT),
            flag: protocol.zip(flag),
        };
        let is_known = port.is_source || child.tag_name().name() == SINK;
        let one_binding =
            port.event.is_some() != port.flag.is_some() && protocol.is_some() == flag.is_some();
        if !is_known || !one_binding || found.replace(port).is_some() {
            return Err(unexpected(
                child,
                "something else",
                format!(
                    "one `{SOURCE}` or `{SINK}`, with `{EVENT}` or with `{PROTOCOL}` and `{FLAG}`"
                ),
            ));
        }
    }
    Ok(found)
}

impl<'a, 'input> Declared<'a, 'input> {
    /// Takes in an element of a net.
    pub(super) fn read(&mut self, node: Node<'a, 'input>) -> Result<(), ReadError> {
        if !is_ours(node)? {
            return Ok(());
        }
        const KNOWN: &[&str] = &[EXCLUSION, END, ENDLESS, VERBATIM];
        for child in elements(node, KNOWN)? {
            match child.tag_name().name() {
                ENDLESS => self.endless = true,
                VERBATIM => self.verbatim = true,
                set @ (EXCLUSION | END) => {
                    let mut places = Vec::new();
                    for place in elements(child, &[PLACE])? {
                        if place.tag_name().name() != PLACE {
                            return Err(unexpected(place, "something else", PLACE));
                        }
                        places.push((place, required(place, REF)?));
                    }
                    self.sets.push(RawSet {
                        name: required(child, NAME)?,
                        is_end: set == END,
                        places,
                    });
                }
                _ => return Err(unexpected(child, "something else", KNOWN.join(", "))),
            }
        }
        Ok(())
    }
}
