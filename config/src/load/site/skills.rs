//! `[skills.<id>]`

use super::{LENGTH, SPEED};
use crate::choices::DIRECTIONS;
use crate::diagnostic::ProblemKind;
use crate::quantity::{POSITION, Quantity};
use crate::reader::Section;
use crate::report::Report;
use crate::site::{ControllerConfig, SkillConfig, StopPlace, TurnDirection};

const OFFSET: Quantity = Quantity::new("an offset", "m").at_least(-5.0).at_most(5.0);
const MARGIN: Quantity = Quantity::new("a length", "m").at_least(0.0).at_most(5.0);
const WAY: Quantity = Quantity::new("a way", "m").at_least(-10.0).at_most(10.0);

/// How far before a border a robot stops when the file does not say.
const MARGIN_M: f64 = 0.10;

#[derive(Clone, Copy)]
enum Kind {
    Corridor,
    EndOfLane,
    UTurn,
    Stop,
    Shift,
    Turn,
    StopAt,
    Dock,
    Creep,
}

const KINDS: &[(&str, Kind)] = &[
    ("corridor", Kind::Corridor),
    ("end-of-lane", Kind::EndOfLane),
    ("u-turn", Kind::UTurn),
    ("stop", Kind::Stop),
    ("shift", Kind::Shift),
    ("turn", Kind::Turn),
    ("stop-at", Kind::StopAt),
    ("dock", Kind::Dock),
    ("creep", Kind::Creep),
];

/// Every parameter of every controller, for when the controller itself is wrong.
const PARAMETERS: &[&str] = &[
    "distance_m",
    "direction",
    "radius_m",
    "offset_m",
    "within_m",
    "before_area",
    "margin_m",
    "pose",
    "speed_m_s",
];

pub(super) fn read(id: &str, s: &Section<'_>, report: &Report) -> SkillConfig {
    let kind = s.choice("controller", KINDS);
    let controller = match kind {
        Some(kind) => controller(kind, s, report),
        None => {
            for key in PARAMETERS {
                let _ = s.has(key);
            }
            ControllerConfig::Stop
        }
    };
    let speed_m_s = match kind {
        // What stands still has no speed.
        None | Some(Kind::Stop) => None,
        // So near to things, how fast is for a person to say.
        Some(Kind::Creep) => Some(s.number("speed_m_s", SPEED)),
        Some(_) => s.number_if("speed_m_s", SPEED),
    };
    SkillConfig {
        id: id.to_owned(),
        controller,
        speed_m_s,
        perception: s.text("perception", "a perception kind"),
        monitors: s.texts("monitors", "a monitor's event"),
    }
}

fn controller(kind: Kind, s: &Section<'_>, report: &Report) -> ControllerConfig {
    match kind {
        Kind::Corridor => ControllerConfig::Corridor {
            offset_m: s.number_or("offset_m", OFFSET, 0.0),
        },
        Kind::EndOfLane => ControllerConfig::EndOfLane {
            distance_m: s.number("distance_m", LENGTH),
        },
        Kind::UTurn => ControllerConfig::UTurn {
            direction: s
                .choice("direction", DIRECTIONS)
                .unwrap_or(TurnDirection::Left),
            radius_m: s.number("radius_m", LENGTH),
        },
        Kind::Stop => ControllerConfig::Stop,
        Kind::Shift => ControllerConfig::Shift {
            offset_m: s.number_or("offset_m", OFFSET, 0.0),
            within_m: s.number("within_m", LENGTH),
        },
        Kind::Turn => ControllerConfig::Turn {
            radius_m: s.number("radius_m", LENGTH),
        },
        Kind::StopAt => ControllerConfig::StopAt {
            place: stop_place(s, report),
        },
        Kind::Dock => ControllerConfig::Dock {
            distance_m: s.number("distance_m", LENGTH),
        },
        Kind::Creep => ControllerConfig::Creep {
            distance_m: way(s, report),
        },
    }
}

fn stop_place(s: &Section<'_>, report: &Report) -> StopPlace {
    let area = s.text_if("before_area", "an area's id");
    let margin_m = s.number_if("margin_m", MARGIN);
    let pose = s.has("pose").then(|| s.pose("pose", POSITION));
    let wrong = |key: &'static str, found: &str, expected: &str| {
        report.wrong(ProblemKind::Inconsistent, &s.at(key), found, expected);
    };
    if area.is_none() && margin_m.is_some() {
        let expected = "it with `before_area`, whose border it is measured from";
        wrong("margin_m", "a margin", expected);
    }
    match (area, pose) {
        (Some(_), Some(_)) => {
            let expected =
                "`before_area` or `pose`, or neither: the pose that comes with the event";
            wrong("pose", "`before_area` and `pose`", expected);
            StopPlace::Instructed
        }
        (Some(area), None) => StopPlace::BeforeArea {
            area,
            margin_m: margin_m.unwrap_or(MARGIN_M),
        },
        (None, Some(pose)) => StopPlace::Pose(pose),
        (None, None) => StopPlace::Instructed,
    }
}

/// A way, which is not zero.
fn way(s: &Section<'_>, report: &Report) -> f64 {
    const SHORTEST_M: f64 = 0.01;
    let way_m = s.number("distance_m", WAY);
    if way_m.abs() < SHORTEST_M {
        report.wrong(
            ProblemKind::OutOfRange,
            &s.at("distance_m"),
            format!("{way_m:?}"),
            format!("a way of at least {SHORTEST_M} m; negative: backward"),
        );
    }
    way_m
}
