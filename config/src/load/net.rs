//! The sections of a net file.

use std::collections::BTreeMap;
use std::path::Path;

use ::coordination::petri::{Binding, PlaceKind};

use super::{document, read};
use crate::check;
use crate::diagnostic::{ConfigError, ProblemKind};
use crate::net::{
    NetArray, NetCommand, NetConfig, NetFlag, NetParty, NetPlace, NetProtocol, NetRole, NetSet,
    NetSituation, NetTransition,
};
use crate::quantity::{POSITION, Quantity};
use crate::reader::Section;
use crate::report::Report;

const SPEED: Quantity = Quantity::new("a speed", "m/s").above(0.0).at_most(3.0);
const PARTIES: &[(&str, NetParty)] = &[
    (NetParty::Robot.name(), NetParty::Robot),
    (NetParty::Mediator.name(), NetParty::Mediator),
];

/// Reads and checks a net file. The net is not analysed yet: see
/// [`NetConfig::analyse`](crate::NetConfig::analyse).
///
/// # Errors
/// Everything wrong with the file, at once.
pub fn load_net(path: impl AsRef<Path>) -> Result<NetConfig, ConfigError> {
    let path = path.as_ref();
    parse_net(&path.display().to_string(), &read(path, "net")?)
}

/// Like [`load_net`], from text; `file` is the name that errors show.
///
/// # Errors
/// As [`load_net`].
pub fn parse_net(file: &str, text: &str) -> Result<NetConfig, ConfigError> {
    let (origin, entries) = document(file, text, &[], &[])?;
    let report = Report::new(origin);
    let mut net = Section::root(&report, &entries, |root| net(root, &report));
    check::net(&mut net, &report);
    report.finish(net)
}

fn net(root: &Section<'_>, report: &Report) -> NetConfig {
    let name = root.id("name", "the net's name");
    let about = root.text_if("about", "what the net is for");
    let roles = root.section("roles", "sections [roles.<id>]", |s| s.each(role));
    let protocols = root.section("protocols", "sections [protocols.<id>]", |s| {
        s.each(|id, s| protocol(id, s, report))
    });
    let mut places = root.section_or_defaults("places", |s| {
        s.each_text("what a token in the place means")
            .into_iter()
            .map(|(id, about)| NetPlace {
                id,
                kind: PlaceKind::Internal,
                about,
                binding: None,
            })
            .collect::<Vec<_>>()
    });
    for (key, kind) in [("sources", PlaceKind::Source), ("sinks", PlaceKind::Sink)] {
        let bound = root.section_or_defaults(key, |s| {
            s.each_text("a flag as \"<role>.<flag>\", or an event's name")
        });
        places.extend(bound.into_iter().map(|(id, text)| NetPlace {
            id,
            kind,
            about: String::new(),
            binding: Some(binding(&text)),
        }));
    }
    NetConfig {
        name,
        about,
        roles,
        protocols,
        places,
        transitions: root.section("transitions", "sections [transitions.<id>]", |s| {
            s.each(|id, s| NetTransition {
                id: id.to_owned(),
                from: s.texts("from", "a place's id"),
                to: s.texts("to", "a place's id"),
            })
        }),
        exclusions: sets(root, "exclusions"),
        ends: sets(root, "ends"),
        situations: root.section("situations", "sections [situations.<id>]", |s| {
            s.each(|id, s| NetSituation {
                id: id.to_owned(),
                about: s.text_if("about", "when the net begins like this"),
                marked: s.texts("marked", "an internal place's id"),
            })
        }),
        origin: report.origin.clone(),
        compiled: BTreeMap::new(),
    }
}

fn role(id: &str, s: &Section<'_>) -> NetRole {
    NetRole {
        id: id.to_owned(),
        protocol: s.text("protocol", "a protocol's id"),
        about: s.text_if("about", "what the role is"),
    }
}

fn protocol(id: &str, s: &Section<'_>, report: &Report) -> NetProtocol {
    let keeper = s
        .has("keeper")
        .then(|| s.choice("keeper", PARTIES))
        .flatten();
    let mut start = Vec::new();
    let arrays = if s.has("arrays") {
        start = s.texts("start", "an array's id");
        s.section("arrays", "sections [protocols.<id>.arrays.<id>]", |s| {
            s.each(|id, s| NetArray {
                id: id.to_owned(),
                flags: flags(s, report),
                then: s.texts("then", "an array's id"),
            })
        })
    } else {
        let flags = flags(s, report);
        vec![NetArray {
            id: "flags".to_owned(),
            flags,
            then: Vec::new(),
        }]
    };
    NetProtocol {
        id: id.to_owned(),
        keeper,
        start,
        arrays,
    }
}

fn flags(s: &Section<'_>, report: &Report) -> Vec<NetFlag> {
    s.list(
        "flags",
        "an array of { robot = \"<flag>\" } and { mediator = \"<flag>\" }",
        |s| flag(s, report),
    )
}

fn flag(s: &Section<'_>, report: &Report) -> NetFlag {
    let wrong = |kind, key: &str, found: &str, expected: &str| {
        report.wrong(kind, &s.at(key), found, expected);
    };
    let one = "exactly one of `robot` and `mediator`";
    let (flag, by) = match (s.has("robot"), s.has("mediator")) {
        (true, false) => (s.id("robot", "a flag"), NetParty::Robot),
        (false, true) => (s.id("mediator", "a flag"), NetParty::Mediator),
        (true, true) => {
            wrong(ProblemKind::Inconsistent, "mediator", "both of them", one);
            (String::new(), NetParty::Mediator)
        }
        // Reported as missing.
        (false, false) => (s.id("robot", one), NetParty::Robot),
    };
    if by == NetParty::Robot {
        for key in ["enters", "speed_limit_m_s", "stop_pose"] {
            if s.has(key) && !flag.is_empty() {
                let found = format!("`{key}` with the robot's flag `{flag}`");
                let expected = "commands only with flags of the mediator";
                wrong(ProblemKind::Inconsistent, key, &found, expected);
            }
        }
        let command = NetCommand::default();
        return NetFlag { flag, by, command };
    }
    NetFlag {
        flag,
        by,
        command: NetCommand {
            enters: s.texts("enters", "an area's id"),
            speed_limit_m_s: s.number_if("speed_limit_m_s", SPEED),
            stop_pose: s.has("stop_pose").then(|| s.pose("stop_pose", POSITION)),
        },
    }
}

fn sets(root: &Section<'_>, key: &'static str) -> Vec<NetSet> {
    let sets = root.section_or_defaults(key, |s| s.each_texts("a place's id"));
    let set = |(id, places)| NetSet { id, places };
    sets.into_iter().map(set).collect()
}

/// "role.flag" is a flag; a name without a dot is an event.
fn binding(text: &str) -> Binding {
    match text.split_once('.') {
        Some((role, flag)) => Binding::flag(role, flag),
        None => Binding::event(text),
    }
}
