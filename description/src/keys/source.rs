//! Where values come from.

use super::quantity::{Count, Quantity};

/// Whether a key must be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// Its absence is a fault.
    Required,
    /// It may be absent.
    Optional,
}

/// What sort of fault a section finds in its own keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A key is missing.
    Missing,
    /// A value is outside what is possible.
    OutOfRange,
    /// Values do not fit together.
    Inconsistent,
}

/// A table of a file, as its declaration reads it.
///
/// `None` means: not written, and it need not be. What is missing or wrong is remembered by the source, which answers
/// with a placeholder (NaN, 0, empty), so that one reading finds every fault. A table with faults is never used.
pub trait Source {
    /// The table's own name: the last part of its path.
    fn name(&self) -> &str;

    /// Whether the key is written. It counts as known from now on.
    fn has(&self, key: &'static str) -> bool;

    /// A number within its limits.
    fn number(&self, key: &'static str, quantity: &Quantity, need: Need) -> Option<f64>;

    /// A whole number within its limits.
    fn count(&self, key: &'static str, count: &Count, need: Need) -> Option<u32>;

    /// A list of whole numbers, not empty.
    fn counts(&self, key: &'static str, count: &Count, need: Need) -> Option<Vec<u32>>;

    /// `true` or `false`.
    fn truth(&self, key: &'static str, need: Need) -> Option<bool>;

    /// One line of text, not empty.
    fn text(&self, key: &'static str, expected: &str, need: Need) -> Option<String>;

    /// A name that can stand in keys and paths.
    fn id(&self, key: &'static str, expected: &str) -> String;

    /// A list of texts; empty when absent.
    fn texts(&self, key: &'static str, expected: &str) -> Vec<String>;

    /// One of a few words; `None` also when it is another one.
    fn word(&self, key: &'static str, words: &[&'static str], need: Need) -> Option<&'static str>;

    /// A list of words out of a few; what is none of them is left out.
    fn words(&self, key: &'static str, words: &[&'static str], need: Need) -> Vec<&'static str>;

    /// A word out of a few, or a whole number from 0 to `most`; `None` also when it is neither.
    fn word_or_number(
        &self,
        key: &'static str,
        words: &[&'static str],
        most: u32,
        expected: &str,
    ) -> Option<Result<&'static str, u32>>;

    /// One of a few whole numbers.
    fn one_of(&self, key: &'static str, numbers: &[u32], expected: &str) -> u32;

    /// A point `[x, y]`.
    fn point(&self, key: &'static str, quantity: &Quantity) -> [f64; 2];

    /// A table. Where an optional one is absent, `read` sees an empty one.
    fn table(
        &self,
        key: &'static str,
        expected: &str,
        need: Need,
        read: &mut dyn FnMut(&dyn Source),
    );

    /// A list of tables; a required one has at least one.
    fn list(
        &self,
        key: &'static str,
        expected: &str,
        need: Need,
        read: &mut dyn FnMut(&dyn Source),
    );

    /// Every key that was not asked for before, as a table named by its key.
    fn each(&self, read: &mut dyn FnMut(&dyn Source));

    /// Every key that was not asked for before, as a name with a text.
    fn each_text(&self, expected: &str) -> Vec<(String, String)>;

    /// Every key that was not asked for before, as a name with a list of texts.
    fn each_texts(&self, expected: &str) -> Vec<(String, Vec<String>)>;

    /// Remembers a fault.
    fn refuse(&self, fault: Fault, key: &str, found: String, expected: String);
}
