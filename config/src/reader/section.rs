//! A table of the file while it is being read: which keys it was asked for, and which are missing.

use std::cell::RefCell;

use crate::diagnostic::ProblemKind;
use crate::hint;
use crate::node::{Entry, Node, Value};
use crate::report::Report;
use crate::spot::join;
use description::keys::{Need, Source, quoted_list};

/// A table of the file, while it is being read.
pub(crate) struct Section<'a> {
    pub(super) report: &'a Report,
    pub(super) path: String,
    /// None: the section is absent, was reported, and stays silent.
    pub(super) entries: Option<&'a [Entry]>,
    known: RefCell<Vec<&'static str>>,
    missing: RefCell<Vec<(&'static str, String)>>,
}

impl<'a> Section<'a> {
    /// Reads the whole document.
    pub(crate) fn root<T>(
        report: &'a Report,
        entries: &'a [Entry],
        read: impl FnOnce(&dyn Source) -> T,
    ) -> T {
        Self::read(report, String::new(), Some(entries), read)
    }

    pub(super) fn read<T>(
        report: &'a Report,
        path: String,
        entries: Option<&'a [Entry]>,
        read: impl FnOnce(&dyn Source) -> T,
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
    pub(super) fn at(&self, key: &str) -> String {
        join(&self.path, key)
    }

    /// The key's value. A required one that is absent is reported when the section ends.
    pub(super) fn find(
        &self,
        key: &'static str,
        need: Need,
        expected: impl FnOnce() -> String,
    ) -> Option<&'a Node> {
        let mut known = self.known.borrow_mut();
        if !known.contains(&key) {
            known.push(key);
        }
        let entries = self.entries?;
        let node = entries.iter().find(|entry| entry.key == key);
        if node.is_none() && need == Need::Required {
            self.missing.borrow_mut().push((key, expected()));
        }
        node.map(|entry| &entry.node)
    }

    /// The keys that nobody has asked for; from now on all keys are known.
    pub(super) fn take_rest(&self) -> Vec<&'a Entry> {
        let mut known = self.known.borrow_mut();
        let entries = self.entries.unwrap_or_default().iter();
        let rest = entries.filter(|entry| !known.iter().any(|known| *known == entry.key));
        let rest = rest.collect();
        known.push("*");
        rest
    }

    /// Every key that nobody has asked for, as a name with a value.
    pub(super) fn each_named<T>(&self, read: impl Fn(&str, &'a Node) -> T) -> Vec<(String, T)> {
        let one = |entry: &'a Entry| {
            let path = self.at(&entry.key);
            self.check_id(&path, &entry.key);
            (entry.key.clone(), read(&path, &entry.node))
        };
        self.take_rest().into_iter().map(one).collect()
    }

    /// The entries of a table.
    pub(super) fn entries_of(
        &self,
        path: &str,
        value: &'a Value,
        expected: &str,
    ) -> Option<&'a [Entry]> {
        if let Value::Table(entries) = value {
            return Some(entries);
        }
        self.wrong_type(path, value, expected);
        None
    }

    pub(super) fn wrong_type(&self, path: &str, value: &Value, expected: &str) {
        self.report
            .wrong(ProblemKind::WrongType, path, value.show(), expected);
    }

    pub(super) fn check_id(&self, path: &str, id: &str) {
        const LONGEST: usize = 48;
        let good = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if id.is_empty() || id.len() > LONGEST || !id.chars().all(good) {
            self.report.wrong(
                ProblemKind::OutOfRange,
                path,
                format!("the name {id:?}"),
                format!("letters, digits, `-` and `_`, at most {LONGEST}"),
            );
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
                format!("a known key {place}: {}", quoted_list(&known, "or")),
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
            self.report
                .wrong(ProblemKind::MissingKey, &path, "nothing", expected);
        }
    }
}
