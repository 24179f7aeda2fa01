//! From a document to nets.

mod build;
mod element;
mod limits;
mod net;
mod own;
mod references;

use std::collections::HashMap;

use roxmltree::{Document, ParsingOptions};

use self::element::{Unique, elements, known, shortened, unexpected};
use self::limits::MAX_NODES;
use self::net::RawNet;
use super::error::ReadError;
use super::grammar::NAMESPACE;
use crate::petri::NetModel;

pub use self::limits::{MAX_BYTES, MAX_DEPTH};

/// The net of a document that has one.
///
/// # Errors
/// If the document is no PNML, has no net or several, or has what a safe net has not.
pub fn read(text: &str) -> Result<NetModel, ReadError> {
    let mut nets = read_all(text)?;
    match (nets.pop(), nets.len()) {
        (Some(net), 0) => Ok(net),
        (None, _) => Err(ReadError::NotOneNet { found: 0 }),
        (Some(_), others) => Err(ReadError::NotOneNet { found: others + 1 }),
    }
}

/// All nets of a document.
///
/// # Errors
/// If the document is no PNML, or one of its nets has what a safe net has not.
pub fn read_all(text: &str) -> Result<Vec<NetModel>, ReadError> {
    if text.len() > MAX_BYTES {
        return Err(ReadError::TooLong {
            found: text.len(),
            limit: MAX_BYTES,
        });
    }
    let options = ParsingOptions {
        nodes_limit: MAX_NODES,
        ..ParsingOptions::default()
    };
    let text = text.strip_prefix('\u{FEFF}').unwrap_or(text);
    let document = Document::parse_with_options(text, options).map_err(|error| ReadError::Xml {
        line: error.pos().row,
        reason: shortened(&error.to_string()),
    })?;
    let root = document.root_element();
    let is_ours = root.tag_name().namespace().is_none_or(|ns| ns == NAMESPACE);
    if root.tag_name().name() != "pnml" || !is_ours {
        let found = format!(
            "`{}` of namespace `{}`",
            root.tag_name().name(),
            root.tag_name().namespace().unwrap_or_default()
        );
        let expected = format!("`pnml` of namespace `{NAMESPACE}`");
        return Err(unexpected(root, &found, expected));
    }
    let mut ids: Unique<'_> = HashMap::new();
    let mut nets = Vec::new();
    for child in elements(root, &["net"])? {
        if known(child, &["net", "toolspecific"])? == "net" {
            nets.push(build::model(&RawNet::read(child, &mut ids)?)?);
        }
    }
    Ok(nets)
}
