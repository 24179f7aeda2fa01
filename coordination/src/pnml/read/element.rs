//! Elements: which ones may stand where, what text they have, and how messages name them.

use std::collections::HashMap;

use roxmltree::Node;

use super::super::error::{At, ReadError};
use super::super::grammar::NAMESPACE;

/// Ids seen so far, and where in the text their elements begin.
pub(super) type Unique<'a> = HashMap<&'a str, usize>;

/// How much of a text from a document a message repeats, in characters.
const SHOWN: usize = 80;

pub(super) fn shortened(text: &str) -> String {
    match text.char_indices().nth(SHOWN) {
        None => text.to_owned(),
        Some((end, _)) => format!("{}…", &text[..end]),
    }
}

pub(super) fn at(node: Node<'_, '_>) -> At {
    let name = shortened(node.tag_name().name());
    At {
        line: node.document().text_pos_at(node.range().start).row,
        element: match node.attribute("id") {
            Some(id) => format!("{name} `{}`", shortened(id)),
            None => name,
        },
    }
}

pub(super) fn unexpected(
    node: Node<'_, '_>,
    found: &str,
    expected: impl Into<String>,
) -> ReadError {
    ReadError::Unexpected {
        at: at(node),
        found: shortened(found),
        expected: expected.into(),
    }
}

/// The elements in `node`, between which there is nothing but white space and comments.
pub(super) fn elements<'a, 'input>(
    node: Node<'a, 'input>,
    expected: &[&str],
) -> Result<impl Iterator<Item = Node<'a, 'input>>, ReadError> {
    let text =
        |child: &Node<'_, '_>| child.is_text() && !child.text().unwrap_or("").trim().is_empty();
    match node.children().find(text) {
        Some(child) => {
            let found = format!(
                "the text `{}`",
                shortened(child.text().unwrap_or("").trim())
            );
            Err(unexpected(node, &found, one_of(expected)))
        }
        None => Ok(node.children().filter(Node::is_element)),
    }
}

/// The name of an element of PNML that may stand where this one stands.
pub(super) fn known<'a>(node: Node<'_, 'a>, expected: &[&str]) -> Result<&'a str, ReadError> {
    let tag = node.tag_name();
    let is_pnml = tag.namespace().is_none_or(|ns| ns == NAMESPACE);
    if is_pnml && expected.contains(&tag.name()) {
        return Ok(tag.name());
    }
    let found = match is_pnml {
        true => "an element that no place/transition net has here",
        false => "an element of another namespace",
    };
    Err(unexpected(node, found, one_of(expected)))
}

fn one_of(names: &[&str]) -> String {
    format!("an element `{}`", names.join("`, `"))
}

/// An attribute that `node` must have.
pub(super) fn required<'a>(
    node: Node<'a, '_>,
    attribute: &'static str,
) -> Result<&'a str, ReadError> {
    node.attribute(attribute)
        .filter(|value| !value.is_empty())
        .ok_or_else(|| ReadError::Missing {
            at: at(node),
            what: attribute,
        })
}

/// The element's id, which no other one may have.
pub(super) fn unique<'a>(node: Node<'a, '_>, ids: &mut Unique<'a>) -> Result<&'a str, ReadError> {
    let id = required(node, "id")?;
    match ids.insert(id, node.range().start) {
        None => Ok(id),
        Some(first) => Err(ReadError::DuplicateId {
            at: at(node),
            first: node.document().text_pos_at(first).row,
        }),
    }
}

/// The text of a label, which is in an element `text`.
pub(super) fn label(node: Node<'_, '_>) -> Result<Option<String>, ReadError> {
    const IN_LABELS: &[&str] = &["text", "graphics", "toolspecific"];
    let mut found = None;
    for child in elements(node, IN_LABELS)? {
        if known(child, IN_LABELS)? != "text" {
            continue;
        }
        if let Some(inner) = child.children().find(Node::is_element) {
            return Err(unexpected(
                inner,
                "an element",
                "nothing but text in `text`",
            ));
        }
        let text = child
            .children()
            .filter(Node::is_text)
            .filter_map(|text| text.text())
            .collect();
        if found.replace(text).is_some() {
            return Err(unexpected(child, "a second `text`", "one"));
        }
    }
    Ok(found)
}

/// The number in a label.
pub(super) fn number(node: Node<'_, '_>, expected: &str) -> Result<Option<u64>, ReadError> {
    let Some(text) = label(node)? else {
        return Ok(None);
    };
    match text.trim().parse() {
        Ok(number) => Ok(Some(number)),
        Err(_) => Err(unexpected(node, &format!("`{}`", text.trim()), expected)),
    }
}
