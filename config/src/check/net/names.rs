//! Names in a net file: where they stand, and what can be wrong with them.

use std::collections::BTreeSet;

use ::coordination::petri::PlaceKind;

use crate::diagnostic::ProblemKind;
use crate::net::NetPlace;
use crate::report::Report;

/// Where a place stands in the file.
pub(super) fn key_of(place: &NetPlace) -> String {
    let section = match place.kind {
        PlaceKind::Internal => "places",
        PlaceKind::Source => "sources",
        PlaceKind::Sink => "sinks",
    };
    format!("{section}.{}", place.id)
}

/// What a place is called.
pub(super) fn kind(kind: PlaceKind) -> &'static str {
    match kind {
        PlaceKind::Internal => "place",
        PlaceKind::Source => "source",
        PlaceKind::Sink => "sink",
    }
}

/// Reports each name that stands a second time in a list.
pub(super) fn repeated(report: &Report, key: &str, names: &[String]) {
    let mut seen = BTreeSet::new();
    for (index, name) in names.iter().enumerate() {
        if !name.is_empty() && !seen.insert(name) {
            let key = format!("{key}[{index}]");
            let found = format!("`{name}` a second time");
            report.wrong(ProblemKind::Duplicate, &key, found, "each name once");
        }
    }
}
