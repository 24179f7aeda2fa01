//! What can be wrong with a document, or with a net that is to become one.

use std::fmt;

use thiserror::Error;

use crate::petri::ModelError;

/// Where in a document: an element, and the line that it begins in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct At {
    /// The line, the first of which is 1.
    pub line: u32,
    /// The element, with its id if it has one: ``place `p1` ``.
    pub element: String,
}

impl fmt::Display for At {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "line {}, {}", self.line, self.element)
    }
}

/// Why a document is not read.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum ReadError {
    /// The text is longer than is looked at.
    #[error("the document has {found} bytes; expected at most {limit}")]
    TooLong { found: usize, limit: usize },
    /// The text is not XML, or has a document type, which PNML has not.
    #[error("line {line}: no XML without a document type: {reason}")]
    Xml { line: u32, reason: String },
    /// Something stands where something else must.
    #[error("{at}: found {found}; expected {expected}")]
    Unexpected {
        at: At,
        found: String,
        expected: String,
    },
    /// An element has not what it must have.
    #[error("{at}: {what} is missing")]
    Missing { at: At, what: &'static str },
    /// Two elements have one id.
    #[error("{at}: this id is taken, by the element in line {first}; expected one of its own")]
    DuplicateId { at: At, first: u32 },
    /// An arc or a reference leads nowhere.
    #[error("{at}: `{name}` is {found}; expected {expected}")]
    WrongReference {
        at: At,
        name: String,
        found: &'static str,
        expected: &'static str,
    },
    /// Reference nodes that refer to each other, and to no node.
    #[error("{at}: the references go round in a circle; expected them to lead to a node")]
    Circle { at: At },
    /// Two arcs of one direction between the same nodes, which weigh two together.
    #[error(
        "{at}: a second arc from `{from}` to `{to}` makes two tokens; expected arcs of weight 1"
    )]
    SecondArc { at: At, from: String, to: String },
    /// More of something than a net has.
    #[error("{at}: more than {limit} {what}")]
    TooMany {
        at: At,
        what: &'static str,
        limit: usize,
    },
    /// A document with no net, or with several where one was asked for.
    #[error("the document has {found} nets; expected one")]
    NotOneNet { found: usize },
}

/// Why a net does not become a document.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum WriteError {
    /// The net is not sound, so that a document could say something else than the net.
    #[error("the net does not compile: {}", .0.first().map_or_else(String::new, ToString::to_string))]
    Model(Vec<ModelError>),
    /// A name has a character that XML has no way to write.
    #[error("`{}` has the character U+{:04X}, which XML cannot hold", .name.escape_debug(), *.character as u32)]
    Character { name: String, character: char },
}
