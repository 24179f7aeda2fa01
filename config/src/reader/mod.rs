//! Reads typed values out of the tree and collects every problem on the way.
//!
//! A value that is missing or wrong is reported and replaced by a placeholder
//! (NaN, 0, empty), so that reading goes on; a file with problems never becomes
//! a configuration. What a section is asked for is what it knows: every other
//! key in it is reported as unknown.

mod named;
mod values;

use std::cell::RefCell;

use crate::diagnostic::ProblemKind;
use crate::hint;
use crate::origin::join;
use crate::report::Report;
use crate::tree::{Entry, Node, Value};

/// A table of the file, while it is being read.
pub(crate) struct Section<'a> {
    report: &'a Report,
    path: String,
    /// None: the section is absent, was reported, and stays silent.
    entries: Option<&'a [Entry]>,
    known: RefCell<Vec<&'static str>>,
    missing: RefCell<Vec<(&'static str, String)>>,
}

impl<'a> Section<'a> {
    /// Reads the whole document.
    pub(crate) fn root<T>(
        report: &'a Report,
        entries: &'a [Entry],
        read: impl FnOnce(&Section<'a>) -> T,
    ) -> T {
        Self::read(report, String::new(), Some(entries), read)
    }

    fn read<T>(
        report: &'a Report,
        path: String,
        entries: Option<&'a [Entry]>,
        read: impl FnOnce(&Section<'a>) -> T,
    ) -> T {
        let section = Section {
            report,
            path,
            entries,
            known: RefCell::default(),
            missing: RefCell::default(),
        };
        let value = read(&section);
        section.finish();
        value
    }

    /// The full key of one of this section's keys.
    pub(crate) fn at(&self, key: &str) -> String {
        join(&self.path, key)
    }

    /// Whether the key is written.
    pub(crate) fn has(&self, key: &'static str) -> bool {
        self.optional(key).is_some()
    }

    fn optional(&self, key: &'static str) -> Option<&'a Node> {
        let mut known = self.known.borrow_mut();
        if !known.contains(&key) {
            known.push(key);
        }
        self.entries?
            .iter()
            .find(|entry| entry.key == key)
            .map(|entry| &entry.node)
    }

    fn required(&self, key: &'static str, expected: &str) -> Option<&'a Node> {
        let node = self.optional(key);
        if node.is_none() && self.entries.is_some() {
            self.missing.borrow_mut().push((key, expected.to_owned()));
        }
        node
    }

    /// A required table.
    pub(crate) fn section<T>(
        &self,
        key: &'static str,
        expected: &str,
        read: impl FnOnce(&Section<'a>) -> T,
    ) -> T {
        let node = self.required(key, expected);
        self.read_section(key, node, expected, read)
    }

    /// A table whose keys all have defaults.
    pub(crate) fn section_or_defaults<T>(
        &self,
        key: &'static str,
        read: impl FnOnce(&Section<'a>) -> T,
    ) -> T {
        match self.optional(key) {
            None => Self::read(self.report, self.at(key), None, read),
            node => self.read_section(key, node, "a table", read),
        }
    }

    fn read_section<T>(
        &self,
        key: &str,
        node: Option<&'a Node>,
        expected: &str,
        read: impl FnOnce(&Section<'a>) -> T,
    ) -> T {
        let entries = match node.map(|node| &node.value) {
            Some(Value::Table(entries)) => Some(entries.as_slice()),
            Some(other) => {
                self.wrong_type(&self.at(key), other, expected);
                None
            }
            None => None,
        };
        Self::read(self.report, self.at(key), entries, read)
    }

    /// Every key not asked for so far, as a table named by its key.
    pub(crate) fn each<T>(&self, read: impl Fn(&str, &Section<'a>) -> T) -> Vec<T> {
        let mut values = Vec::new();
        for entry in self.entries.unwrap_or_default() {
            if self.known.borrow().iter().any(|known| *known == entry.key) {
                continue;
            }
            let path = self.at(&entry.key);
            self.check_id(&path, &entry.key);
            let entries = match &entry.node.value {
                Value::Table(entries) => Some(entries.as_slice()),
                other => {
                    self.wrong_type(&path, other, "a table");
                    None
                }
            };
            values.push(Self::read(self.report, path, entries, |section| {
                read(&entry.key, section)
            }));
        }
        // All of them are known now.
        self.known.borrow_mut().push("*");
        values
    }

    /// A required array of tables, at least one.
    pub(crate) fn list<T>(
        &self,
        key: &'static str,
        expected: &str,
        read: impl Fn(&Section<'a>) -> T,
    ) -> Vec<T> {
        let Some(node) = self.required(key, expected) else {
            return Vec::new();
        };
        let path = self.at(key);
        let Value::Array(items) = &node.value else {
            self.wrong_type(&path, &node.value, expected);
            return Vec::new();
        };
        if items.is_empty() {
            self.report.push(self.report.problem(
                ProblemKind::OutOfRange,
                &path,
                "an empty array",
                expected,
            ));
        }
        let mut values = Vec::with_capacity(items.len());
        for (index, item) in items.iter().enumerate() {
            let path = format!("{path}[{index}]");
            let entries = match &item.value {
                Value::Table(entries) => Some(entries.as_slice()),
                other => {
                    self.wrong_type(&path, other, "a table");
                    None
                }
            };
            values.push(Self::read(self.report, path, entries, &read));
        }
        values
    }

    /// A required name that can stand in keys, paths and network names.
    pub(crate) fn id(&self, key: &'static str, expected: &str) -> String {
        let id = self.text(key, expected);
        if !id.is_empty() {
            self.check_id(&self.at(key), &id);
        }
        id
    }

    fn check_id(&self, path: &str, id: &str) {
        const LONGEST: usize = 48;
        let good = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if id.is_empty() || id.len() > LONGEST || !id.chars().all(good) {
            self.report.push(self.report.problem(
                ProblemKind::OutOfRange,
                path,
                format!("the name {id:?}"),
                format!("letters, digits, `-` and `_`, at most {LONGEST}"),
            ));
        }
    }

    /// Reports unknown keys, then the missing ones that no unknown key was meant for.
    fn finish(self) {
        let known = self.known.into_inner();
        let mut missing = self.missing.into_inner();
        let all_known = known.contains(&"*");
        let written = |key: &str| {
            let mut entries = self.entries.unwrap_or_default().iter();
            entries.any(|entry| entry.key == key)
        };
        let free: Vec<&str> = known.iter().copied().filter(|key| !written(key)).collect();
        for entry in self.entries.unwrap_or_default() {
            if all_known || known.iter().any(|key| *key == entry.key) {
                continue;
            }
            let place = if self.path.is_empty() {
                "at the top of the file".to_owned()
            } else {
                format!("in [{}]", self.path)
            };
            let mut problem = self.report.problem(
                ProblemKind::UnknownKey,
                &join(&self.path, &entry.key),
                format!("unknown key `{}`", entry.key),
                format!("a known key {place}: {}", hint::list(&known, "or")),
            );
            // Guessing takes time; a report that is full shows none of it.
            if !self.report.is_full()
                && let Some((meant, advice)) = hint::for_key(&entry.key, &free)
            {
                missing.retain(|(key, _)| *key != meant);
                problem = problem.with_hint(advice);
            }
            self.report.push(problem);
        }
        for (key, expected) in missing {
            let path = join(&self.path, key);
            self.report.push(self.report.problem(
                ProblemKind::MissingKey,
                &path,
                "nothing",
                expected,
            ));
        }
    }
}
