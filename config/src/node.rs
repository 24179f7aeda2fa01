//! Values of a file, each with its place.

use crate::spot::Spot;

/// A value of the tree.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    Text(String),
    Integer(i64),
    /// An integer that no 64 bits hold, as it was written.
    HugeInteger(String),
    Float(f64),
    Boolean(bool),
    Datetime(String),
    Array(Vec<Node>),
    Table(Vec<Entry>),
}

/// A value and where it stands.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) spot: Spot,
    pub(crate) value: Value,
}

/// A key with its value, in the order of the file.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) key: String,
    pub(crate) spot: Spot,
    pub(crate) node: Node,
}

impl Value {
    /// The value as an error shows it.
    pub(crate) fn show(&self) -> String {
        match self {
            Value::Text(text) => {
                let short: String = text.chars().take(40).collect();
                let dots = if short.len() < text.len() { "…" } else { "" };
                format!("text {:?}", format!("{short}{dots}"))
            }
            Value::Integer(number) => number.to_string(),
            Value::HugeInteger(digits) => digits.clone(),
            // `{:?}` keeps the `.0` that tells a float from an integer.
            Value::Float(number) => format!("{number:?}"),
            Value::Boolean(truth) => truth.to_string(),
            Value::Datetime(time) => format!("date or time {time}"),
            Value::Array(items) if items.len() == 1 => "an array of 1 value".to_owned(),
            Value::Array(items) => format!("an array of {} values", items.len()),
            Value::Table(_) => "a table".to_owned(),
        }
    }
}
