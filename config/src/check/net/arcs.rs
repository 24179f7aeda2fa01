//! Transitions, exclusions, ends and situations, against the places there are.

use std::collections::{BTreeMap, BTreeSet};

use ::coordination::petri::PlaceKind;

use super::names::{key_of, kind, repeated};
use crate::check::reference::unknown;
use crate::diagnostic::ProblemKind;
use crate::net::{NetConfig, NetPlace, NetSet};
use crate::report::Report;

type Places<'a> = BTreeMap<&'a str, &'a NetPlace>;

pub(super) fn check(net: &NetConfig, places: &Places<'_>, report: &Report) {
    let list = List {
        places,
        names: places.keys().copied().collect(),
        report,
    };
    for transition in &net.transitions {
        let key = format!("transitions.{}", transition.id);
        let from = format!("{key}.from");
        if transition.from.is_empty() && !report.touched(&[&from]) {
            let expected = "at least one place; without input it would fire for ever";
            report.wrong(ProblemKind::OutOfRange, &from, "no places", expected);
        }
        list.check(
            &from,
            &transition.from,
            Some((PlaceKind::Sink, "only its consumer empties it")),
        );
        let source = (PlaceKind::Source, "only its flag or event fills it");
        list.check(&format!("{key}.to"), &transition.to, Some(source));
    }
    for NetSet { id, places } in &net.exclusions {
        let key = format!("exclusions.{id}");
        if places.len() < 2 && !report.touched(&[&key]) {
            let found = format!("{} places", places.len());
            report.wrong(ProblemKind::OutOfRange, &key, found, "at least two places");
        }
        list.check(&key, places, None);
    }
    for NetSet { id, places } in &net.ends {
        list.check_internal(&format!("ends.{id}"), places);
    }
    for situation in &net.situations {
        list.check_internal(
            &format!("situations.{}.marked", situation.id),
            &situation.marked,
        );
    }
    if net.situations.is_empty() && !report.touched(&["situations"]) {
        let expected = "at least one situation, in which the net begins";
        report.wrong(
            ProblemKind::OutOfRange,
            "situations",
            "an empty section",
            expected,
        );
    }
    if !report.touched(&["transitions", "ends", "situations"]) {
        unused(net, report);
    }
}

/// Lists of places.
struct List<'a> {
    places: &'a Places<'a>,
    names: Vec<&'a str>,
    report: &'a Report,
}

impl List<'_> {
    /// Every name must be a place of a kind allowed here, and may be listed only once.
    fn check(&self, key: &str, names: &[String], refused: Option<(PlaceKind, &str)>) {
        for (index, name) in names.iter().enumerate() {
            let key = format!("{key}[{index}]");
            match (self.places.get(name.as_str()), refused) {
                _ if name.is_empty() => {}
                (None, _) => unknown(self.report, &key, name, "place", &self.names),
                (Some(place), Some((refused, why))) if place.kind == refused => {
                    let found = format!("the {} `{name}`", kind(refused));
                    let expected = format!("another place: {why}");
                    self.report
                        .wrong(ProblemKind::Inconsistent, &key, found, expected);
                }
                _ => {}
            }
        }
        repeated(self.report, key, names);
    }

    fn check_internal(&self, key: &str, names: &[String]) {
        for (index, name) in names.iter().enumerate() {
            if let Some(place) = self.places.get(name.as_str())
                && place.kind != PlaceKind::Internal
            {
                let key = format!("{key}[{index}]");
                let found = format!("the {} `{name}`", kind(place.kind));
                let expected = "an internal place; sources and sinks are empty then";
                self.report
                    .wrong(ProblemKind::Inconsistent, &key, found, expected);
            }
        }
        self.check(key, names, None);
    }
}

/// Places that no token ever enters, or none ever leaves.
fn unused(net: &NetConfig, report: &Report) {
    let all = |lists: &mut dyn Iterator<Item = &Vec<String>>| -> BTreeSet<String> {
        lists.flatten().cloned().collect()
    };
    let taken = all(&mut net.transitions.iter().map(|t| &t.from));
    let given = all(&mut net.transitions.iter().map(|t| &t.to));
    let marked = all(&mut net.situations.iter().map(|situation| &situation.marked));
    let ended = all(&mut net.ends.iter().map(|end| &end.places));
    for place in &net.places {
        let (is_taken, is_given) = (taken.contains(&place.id), given.contains(&place.id));
        let enters = is_given || place.kind == PlaceKind::Source || marked.contains(&place.id);
        let leaves = is_taken || place.kind == PlaceKind::Sink || ended.contains(&place.id);
        let fault = match (is_taken || is_given, enters, leaves) {
            (false, ..) => "which no transition touches",
            (_, false, _) => "which nothing ever marks",
            (.., false) => "which nothing ever empties and no end names",
            _ => continue,
        };
        let found = format!("{} `{}`, {fault}", kind(place.kind), place.id);
        let expected = "places that tokens enter and leave";
        report.wrong(ProblemKind::Inconsistent, &key_of(place), found, expected);
    }
}
