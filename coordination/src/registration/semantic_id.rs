//! What a registered object is called.

use std::fmt;

/// A symbolic name that is the same in models, in storage and between processes: what kind of thing
/// it is, and which one.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SemanticId {
    datatype: Box<str>,
    model: Box<str>,
}

impl SemanticId {
    /// The id of `model`, which is a `datatype`.
    pub fn new(datatype: impl Into<Box<str>>, model: impl Into<Box<str>>) -> Self {
        Self {
            datatype: datatype.into(),
            model: model.into(),
        }
    }

    /// What kind of thing it is.
    pub fn datatype(&self) -> &str {
        &self.datatype
    }

    /// Which one of its kind.
    pub fn model(&self) -> &str {
        &self.model
    }
}

impl fmt::Display for SemanticId {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} {}", self.datatype, self.model)
    }
}
