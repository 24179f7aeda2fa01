//! Names that stand for something else in the file.

use crate::diagnostic::ProblemKind;
use crate::hint;
use crate::report::Report;

/// Reports a name that is not in `names`. An empty name was reported already, and so was a section without any names.
pub(super) fn reference(report: &Report, key: &str, name: &str, what: &str, names: &[&str]) {
    if name.is_empty() || names.is_empty() || names.contains(&name) {
        return;
    }
    let mut problem = report.problem(
        ProblemKind::UnknownReference,
        key,
        format!("{what} `{name}`, which does not exist"),
        format!("the name of {}", article(what)),
    );
    if let Some(advice) = hint::for_name(name, names) {
        problem = problem.with_hint(advice);
    }
    report.push(problem);
}

/// The noun with its article.
pub(super) fn article(noun: &str) -> String {
    let an = noun.starts_with(['a', 'e', 'i', 'o']);
    format!("{} {noun}", if an { "an" } else { "a" })
}
