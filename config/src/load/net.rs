//! The sections of a net file.

use std::collections::BTreeMap;
use std::path::Path;

use ::coordination::petri::{Binding, PlaceKind};

use super::{document, read};
use crate::check;
use crate::diagnostic::ConfigError;
use crate::net::{
    NetArray, NetCommand, NetConfig, NetFlag, NetParty, NetPlace, NetProtocol, NetRole, NetSet,
    NetSituation, NetTransition,
};
use crate::origin::Origin;
use crate::reader;
use crate::report::Report;
use description::geometry::Pose2;
use description::keys::{Fault, Field, Need, Optional, Pose, Quantity, Source, Words as _};

const SPEED: Quantity = Quantity::new("a speed", "m/s").above(0.0).at_most(3.0);
const POSITION: Quantity = Quantity::new("a position", "m")
    .at_least(-10_000.0)
    .at_most(10_000.0);

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
    let mut net = reader::Section::root(&report, &entries, |root| net(root, report.origin.clone()));
    check::net(&mut net, &report);
    report.finish(net)
}

fn net(root: &dyn Source, origin: Origin) -> NetConfig {
    let name = root.id("name", "the net's name");
    let about = root.text("about", "what the net is for", Need::Optional);
    let roles = named(root, "roles", "sections [roles.<id>]", role);
    let protocols = named(root, "protocols", "sections [protocols.<id>]", protocol);
    let mut places = Vec::new();
    root.table("places", "a table", Need::Optional, &mut |s| {
        let texts = s.each_text("what a token in the place means");
        places.extend(texts.into_iter().map(|(id, about)| NetPlace {
            id,
            kind: PlaceKind::Internal,
            about,
            binding: None,
        }));
    });
    for (key, kind) in [("sources", PlaceKind::Source), ("sinks", PlaceKind::Sink)] {
        root.table(key, "a table", Need::Optional, &mut |s| {
            let texts = s.each_text("a flag as \"<role>.<flag>\", or an event's name");
            places.extend(texts.into_iter().map(|(id, text)| NetPlace {
                id,
                kind,
                about: String::new(),
                binding: Some(binding(&text)),
            }));
        });
    }
    NetConfig {
        name,
        about,
        roles,
        protocols,
        places,
        transitions: named(root, "transitions", "sections [transitions.<id>]", |s| {
            NetTransition {
                id: s.name().to_owned(),
                from: s.texts("from", "a place's id"),
                to: s.texts("to", "a place's id"),
            }
        }),
        exclusions: sets(root, "exclusions"),
        ends: sets(root, "ends"),
        endless: root.truth("endless", Need::Optional).unwrap_or(false),
        situations: named(root, "situations", "sections [situations.<id>]", |s| {
            NetSituation {
                id: s.name().to_owned(),
                about: s.text("about", "when the net begins like this", Need::Optional),
                marked: s.texts("marked", "an internal place's id"),
            }
        }),
        origin,
        compiled: BTreeMap::new(),
    }
}

/// A required table of tables that the file names.
fn named<T>(
    s: &dyn Source,
    key: &'static str,
    expected: &str,
    read: impl Fn(&dyn Source) -> T,
) -> Vec<T> {
    let mut values = Vec::new();
    s.table(key, expected, Need::Required, &mut |s| {
        s.each(&mut |s| values.push(read(s)));
    });
    values
}

fn role(s: &dyn Source) -> NetRole {
    let protocol = s.text("protocol", "a protocol's id", Need::Required);
    NetRole {
        id: s.name().to_owned(),
        protocol: protocol.unwrap_or_default(),
        about: s.text("about", "what the role is", Need::Optional),
    }
}

fn protocol(s: &dyn Source) -> NetProtocol {
    let keeper = s.word("keeper", NetParty::WORDS, Need::Optional);
    let mut start = Vec::new();
    let arrays = if s.has("arrays") {
        start = s.texts("start", "an array's id");
        named(s, "arrays", "sections [protocols.<id>.arrays.<id>]", |s| {
            NetArray {
                id: s.name().to_owned(),
                flags: flags(s),
                then: s.texts("then", "an array's id"),
            }
        })
    } else {
        vec![NetArray {
            id: "flags".to_owned(),
            flags: flags(s),
            then: Vec::new(),
        }]
    };
    NetProtocol {
        id: s.name().to_owned(),
        keeper: keeper.map(NetParty::of),
        start,
        arrays,
    }
}

fn flags(s: &dyn Source) -> Vec<NetFlag> {
    const EXPECTED: &str = "an array of { robot = \"<flag>\" } and { mediator = \"<flag>\" }";
    let mut flags = Vec::new();
    s.list("flags", EXPECTED, Need::Required, &mut |s| {
        flags.push(flag(s))
    });
    flags
}

fn flag(s: &dyn Source) -> NetFlag {
    let wrong = |key: &str, found: &str, expected: &str| {
        s.refuse(
            Fault::Inconsistent,
            key,
            found.to_owned(),
            expected.to_owned(),
        );
    };
    let one = "exactly one of `robot` and `mediator`";
    let (flag, by) = match (s.has("robot"), s.has("mediator")) {
        (true, false) => (s.id("robot", "a flag"), NetParty::Robot),
        (false, true) => (s.id("mediator", "a flag"), NetParty::Mediator),
        (true, true) => {
            wrong("mediator", "both of them", one);
            (String::new(), NetParty::Mediator)
        }
        // Reported as missing.
        (false, false) => (s.id("robot", one), NetParty::Robot),
    };
    if by == NetParty::Robot {
        for key in ["enters", "speed_limit_m_s", "stop_pose"] {
            if s.has(key) && !flag.is_empty() {
                let found = format!("`{key}` with the robot's flag `{flag}`");
                wrong(key, &found, "commands only with flags of the mediator");
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
            speed_limit_m_s: s.number("speed_limit_m_s", &SPEED, Need::Optional),
            stop_pose: <Option<Pose2> as Field<_>>::read(
                s,
                "stop_pose",
                &Optional(Pose(POSITION)),
                None,
            ),
        },
    }
}

fn sets(root: &dyn Source, key: &'static str) -> Vec<NetSet> {
    let mut sets = Vec::new();
    root.table(key, "a table", Need::Optional, &mut |s| {
        let texts = s.each_texts("a place's id").into_iter();
        sets.extend(texts.map(|(id, places)| NetSet { id, places }));
    });
    sets
}

/// "role.flag" is a flag; a name without a dot is an event.
fn binding(text: &str) -> Binding {
    match text.split_once('.') {
        Some((role, flag)) => Binding::flag(role, flag),
        None => Binding::event(text),
    }
}
