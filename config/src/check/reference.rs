//! Names that stand for something else in the file.

use crate::diagnostic::ProblemKind;
use crate::hint;
use crate::report::Report;
use description::keys::KeyError;

/// The names of all things of one sort.
pub(super) struct Names<'a> {
    what: &'static str,
    known: Vec<&'a str>,
}

impl<'a> Names<'a> {
    pub(super) fn new(what: &'static str, known: impl IntoIterator<Item = &'a String>) -> Self {
        let known = known.into_iter().map(String::as_str).collect();
        Self { what, known }
    }

    /// Reports a name that none of them is. An empty name was reported already, and so was a section without any names.
    pub(super) fn refer(&self, report: &Report, key: &str, name: &str) {
        if !(name.is_empty() || self.known.is_empty() || self.known.contains(&name)) {
            unknown(report, key, name, self.what, &self.known);
        }
    }

    /// The same for each name of a list.
    pub(super) fn refer_all(&self, report: &Report, key: &str, names: &[String]) {
        for (index, name) in names.iter().enumerate() {
            self.refer(report, &format!("{key}[{index}]"), name);
        }
    }
}

/// Reports a name that does not exist, with advice.
pub(super) fn unknown(report: &Report, key: &str, name: &str, what: &str, names: &[&str]) {
    let KeyError {
        found, expected, ..
    } = KeyError::unknown(key, what, name);
    let mut problem = report.problem(ProblemKind::UnknownReference, key, found, expected);
    // Guessing takes time; a report that is full shows none of it.
    if !report.is_full()
        && let Some(advice) = hint::for_name(name, names)
    {
        problem = problem.with_hint(advice);
    }
    report.push(problem);
}
