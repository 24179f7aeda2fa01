//! A section, and a field of it.

use super::error::KeyError;
use super::page::Page;
use super::source::Source;

/// A table of a file, made by [`section!`](crate::section) or [`kinds!`](crate::kinds).
pub trait Section: Sized {
    /// What it is, for the reference page.
    const ABOUT: &'static str;
    /// Its keys, as far as it has them itself.
    const KEYS: &'static [&'static str];

    /// Reads it; faults are left with the source.
    fn read(source: &dyn Source) -> Self;

    /// Checks every value against its limits.
    ///
    /// # Errors
    /// The first value out of range, by its key below the section.
    fn check(&self) -> Result<(), KeyError>;

    /// Writes its keys to the page's current table.
    fn document(page: &mut Page);

    /// Lets its keys count as known, without judging them.
    fn excuse(source: &dyn Source);
}

/// A value of a section, under a rule that says what it may be.
pub trait Field<R>: Sized {
    /// Reads it; `default` stands in where it is not written.
    fn read(source: &dyn Source, key: &'static str, rule: &R, default: Option<Self>) -> Self;

    /// Checks it against its limits.
    ///
    /// # Errors
    /// What is wrong, by its key.
    fn check(&self, key: &str, rule: &R) -> Result<(), KeyError> {
        let _ = (key, rule);
        Ok(())
    }

    /// Lets its key count as known, without judging it.
    fn excuse(source: &dyn Source, key: &'static str, rule: &R) {
        let _ = (source.has(key), rule);
    }

    /// Writes it to the page's current table.
    fn document(
        page: &mut Page,
        key: &'static str,
        rule: &R,
        default: Option<Self>,
        about: &'static str,
    );
}

impl Page {
    /// The keys of one kind of file.
    #[must_use]
    pub fn of<T: Section>() -> Self {
        let mut page = Self::default();
        page.table("", T::ABOUT, T::document);
        page
    }
}
