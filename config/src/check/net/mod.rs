//! Nets: names, who may set what, arcs, and whether models come out that compile.

mod arcs;
mod names;
mod protocols;

use std::collections::BTreeMap;

use ::coordination::petri::{Binding, PlaceKind};
use ::coordination::protocol::{ABORTED, Party};

use crate::check::reference::unknown;
use crate::diagnostic::ProblemKind;
use crate::net::{MEDIATOR, NetConfig, NetPlace};
use crate::report::Report;
use names::{key_of, kind};

/// More than a person writes, and little enough to be checked at once.
const MOST: &[(&str, usize)] = &[
    ("roles", 64),
    ("protocols", 64),
    ("places", 1000),
    ("sources", 1000),
    ("sinks", 1000),
    ("transitions", 1000),
    ("exclusions", 100),
    ("ends", 100),
    ("situations", 50),
];

/// As [`MOST`], for all arcs together.
const MOST_ARCS: usize = 10_000;

pub(crate) fn check(net: &mut NetConfig, report: &Report) {
    if !sizes(net, report) {
        return;
    }
    protocols::check(net, report);
    let elements = names(net, report);
    for place in &net.places {
        if let Some(binding) = &place.binding {
            bound(net, place, binding, report);
        }
    }
    arcs::check(net, &elements, report);
    if report.touched(&["roles", "protocols", "places", "sources", "sinks"])
        || report.touched(&["transitions", "exclusions", "ends", "situations", "name"])
    {
        return;
    }
    for (situation, model) in net.models() {
        for error in model.check() {
            let key = format!("situations.{situation}");
            let expected = "a net that can begin like this";
            report.wrong(ProblemKind::Inconsistent, &key, error.to_string(), expected);
        }
    }
}

/// Whether the net is small enough for the slower checks.
fn sizes(net: &NetConfig, report: &Report) -> bool {
    let of_kind = |kind| net.places.iter().filter(|place| place.kind == kind).count();
    let mut good = true;
    let mut check = |key: &str, found: usize, most: usize| {
        if found > most {
            good = false;
            let (found, expected) = (format!("{found} entries"), format!("at most {most}"));
            report.wrong(ProblemKind::OutOfRange, key, found, expected);
        }
    };
    for &(key, most) in MOST {
        let found = match key {
            "roles" => net.roles.len(),
            "protocols" => net.protocols.len(),
            "places" => of_kind(PlaceKind::Internal),
            "sources" => of_kind(PlaceKind::Source),
            "sinks" => of_kind(PlaceKind::Sink),
            "transitions" => net.transitions.len(),
            "exclusions" => net.exclusions.len(),
            "ends" => net.ends.len(),
            _ => net.situations.len(),
        };
        check(key, found, most);
    }
    let arcs = net.transitions.iter().map(|t| t.from.len() + t.to.len());
    check("transitions", arcs.sum(), MOST_ARCS);
    let sets = net.exclusions.iter().chain(&net.ends);
    check(
        "exclusions",
        sets.map(|set| set.places.len()).sum(),
        MOST_ARCS,
    );
    let marks = net
        .situations
        .iter()
        .map(|situation| situation.marked.len());
    check("situations", marks.sum(), MOST_ARCS);
    good && protocols::sizes(net, report)
}

/// Places by id; a name may stand for one thing only.
fn names<'a>(net: &'a NetConfig, report: &Report) -> BTreeMap<&'a str, &'a NetPlace> {
    let mut keys: BTreeMap<&str, String> = BTreeMap::new();
    let mut places = BTreeMap::new();
    let mut add = |id: &'a str, key: String| match keys.get(id) {
        None => {
            keys.insert(id, key);
            true
        }
        Some(first) => {
            let found = format!("the name `{id}` a second time");
            let expected = "each name for one place or transition";
            let problem = report.problem(ProblemKind::Duplicate, &key, found, expected);
            report.push(report.origin.also(problem, first, "first here"));
            false
        }
    };
    for place in &net.places {
        if add(&place.id, key_of(place)) {
            places.insert(place.id.as_str(), place);
        }
    }
    for transition in &net.transitions {
        add(&transition.id, format!("transitions.{}", transition.id));
    }
    places
}

/// A source reads the robot's flags, a sink sets the mediator's.
fn bound(net: &NetConfig, place: &NetPlace, binding: &Binding, report: &Report) {
    let key = key_of(place);
    let (role, flag) = match binding {
        Binding::Event(event) => return event_name(&key, event, report),
        Binding::Flag { protocol, flag } => (protocol, flag),
    };
    let roles: Vec<&str> = net.roles.iter().map(|role| role.id.as_str()).collect();
    if !roles.contains(&role.as_str()) {
        return unknown(report, &key, role, "role", &roles);
    }
    // A missing protocol has already been reported.
    let Some(protocol) = net.compiled.get(role) else {
        return;
    };
    let (expected, verb) = match place.kind {
        PlaceKind::Sink => (Party::Second, "sets"),
        _ => (Party::First, "waits for"),
    };
    let is_abort = flag == ABORTED && place.kind == PlaceKind::Source;
    let owner = match protocol.flag(flag) {
        None if is_abort && protocol.keeper() == Some(Party::First) => return,
        None => {
            let flags = protocol.flags().filter(|&(_, _, owner)| owner == expected);
            let flags: Vec<&str> = flags.map(|(_, name, _)| name).collect();
            return unknown(report, &key, flag, "flag", &flags);
        }
        Some(flag) => protocol.owner(flag),
    };
    if owner != Some(expected) {
        report.wrong(
            ProblemKind::Inconsistent,
            &key,
            format!(
                "flag `{flag}` of the {}",
                party(owner.unwrap_or(expected.other()))
            ),
            format!(
                "a flag of the {}, which a {} {verb}",
                party(expected),
                kind(place.kind)
            ),
        );
    }
}

fn party(party: Party) -> &'static str {
    match party {
        Party::First => "robot",
        Party::Second => MEDIATOR,
    }
}

fn event_name(key: &str, event: &str, report: &Report) {
    let good = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if !event.is_empty() && !event.chars().all(good) {
        let found = format!("{event:?}");
        let expected = "\"<role>.<flag>\", or an event's name of letters, digits, `-` and `_`";
        report.wrong(ProblemKind::OutOfRange, key, found, expected);
    }
}
