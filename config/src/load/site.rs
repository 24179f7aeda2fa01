//! The sections of a site file.

use std::collections::BTreeMap;

use crate::choices::{DIRECTIONS, FEATURES, MANOEUVRES};
use crate::diagnostic::ProblemKind;
use crate::geometry::Rect;
use crate::quantity::{Count, POSITION, Quantity};
use crate::reader::Section;
use crate::report::Report;
use crate::site::{
    Area, ControlLayer, ControllerConfig, Feature, FsmConfig, FsmState, FsmTransition, Lane,
    Manoeuvre, Monitor, MonitorKind, PerceptionKind, PerceptionZone, RegionRef, SiteConfig,
    SiteRobot, SkillConfig, TurnDirection, Wall,
};

const LENGTH: Quantity = Quantity::new("a length", "m").above(0.0).at_most(100.0);
const SPEED: Quantity = Quantity::new("a speed", "m/s").above(0.0).at_most(3.0);

pub(super) fn read(root: &Section<'_>, report: &Report) -> SiteConfig {
    let name = root.id("name", "the site's name");
    let walls = root.section("walls", "sections [walls.<id>]", |s| s.each(wall));
    let lanes = root.section("lanes", "sections [lanes.<id>]", |s| s.each(lane));
    let (areas_managed, areas) = root.section("areas", "[areas] and sections [areas.<id>]", |s| {
        (s.boolean("managed"), s.each(area))
    });
    let (perception_kinds, perception) =
        root.section("perception", "sections [perception.kinds.<kind>]", |s| {
            let kinds = s.section("kinds", "sections [perception.kinds.<kind>]", |s| {
                s.each(kind)
            });
            let zones = s.section_or_defaults("zones", |s| s.each(zone));
            (kinds.into_iter().collect::<BTreeMap<_, _>>(), zones)
        });
    let monitors = root.section("monitors", "sections [monitors.<event>]", |s| {
        s.each(|event, s| monitor(event, s, &areas, &perception, report))
    });
    SiteConfig {
        name,
        areas_managed,
        walls,
        lanes,
        areas,
        perception,
        perception_kinds,
        monitors,
        skills: root.section("skills", "sections [skills.<id>]", |s| s.each(skill)),
        fsm: root
            .section("fsm", "sections [fsm.<role>]", |s| s.each(fsm))
            .into_iter()
            .collect::<BTreeMap<_, _>>(),
        robots: root
            .section("robots", "sections [robots.<id>]", |s| s.each(robot))
            .into_iter()
            .collect::<BTreeMap<_, _>>(),
        origin: report.origin.clone(),
    }
}

fn wall(id: &str, s: &Section<'_>) -> Wall {
    Wall {
        id: id.to_owned(),
        from_m: s.point("from_m", POSITION),
        to_m: s.point("to_m", POSITION),
    }
}

fn lane(id: &str, s: &Section<'_>) -> Lane {
    Lane {
        id: id.to_owned(),
        from_m: s.point("from_m", POSITION),
        to_m: s.point("to_m", POSITION),
        end_wall: s.text_if("end_wall", "a wall's id"),
    }
}

fn area(id: &str, s: &Section<'_>) -> Area {
    Area {
        id: id.to_owned(),
        region: s.rect("region", POSITION),
        lane: s.text_if("lane", "a lane's id"),
        capacity: s.integer_or("capacity", Count::new("a number of robots", 1, 1000), 1),
        control: ControlLayer {
            manoeuvre: s
                .choice("manoeuvre", MANOEUVRES)
                .unwrap_or(Manoeuvre::Forward),
            speed_limit_m_s: s.number("speed_limit_m_s", SPEED),
            deviation_limit_m: s.number("deviation_limit_m", LENGTH),
        },
    }
}

fn kind(id: &str, s: &Section<'_>) -> (String, PerceptionKind) {
    let features = |key| {
        s.choices(key, FEATURES, false)
            .into_iter()
            .flatten()
            .collect()
    };
    (
        id.to_owned(),
        PerceptionKind {
            tracks: features("tracks"),
            searches: features("searches"),
        },
    )
}

fn zone(id: &str, s: &Section<'_>) -> PerceptionZone {
    PerceptionZone {
        id: id.to_owned(),
        kind: s.text("kind", "a perception kind"),
        region: s.rect("region", POSITION),
    }
}

fn monitor(
    event: &str,
    s: &Section<'_>,
    areas: &[Area],
    zones: &[PerceptionZone],
    report: &Report,
) -> Monitor {
    #[derive(Clone, Copy)]
    enum Kind {
        Region,
        Stable,
        Done,
        Deviation,
    }
    let kind = s.choice(
        "kind",
        &[
            ("region-reached", Kind::Region),
            ("estimate-stable", Kind::Stable),
            ("manoeuvre-done", Kind::Done),
            ("deviation", Kind::Deviation),
        ],
    );
    let kind = match kind {
        Some(Kind::Region) => region_reached(s, areas, zones, report),
        Some(Kind::Stable) => MonitorKind::EstimateStable {
            feature: s.choice("feature", FEATURES).unwrap_or(Feature::LaneEnd),
            scans: s.integer("scans", Count::new("a number of scans", 1, 1000)),
            max_std_m: s.number("max_std_m", LENGTH),
        },
        Some(Kind::Deviation) => MonitorKind::Deviation {
            limit_m: s.number_if("limit_m", LENGTH),
        },
        Some(Kind::Done) => MonitorKind::ManoeuvreDone,
        None => {
            // The kind is wrong; its parameters are not to blame.
            for key in [
                "area",
                "zone",
                "region",
                "feature",
                "scans",
                "max_std_m",
                "limit_m",
            ] {
                let _ = s.has(key);
            }
            MonitorKind::ManoeuvreDone
        }
    };
    Monitor {
        event: event.to_owned(),
        kind,
    }
}

fn region_reached(
    s: &Section<'_>,
    areas: &[Area],
    zones: &[PerceptionZone],
    report: &Report,
) -> MonitorKind {
    let area = s.text_if("area", "an area's id");
    let zone = s.text_if("zone", "a perception zone's id");
    let own = s.has("region").then(|| s.rect("region", POSITION));
    // A name that nothing has is reported with the other references.
    let (region, of) = match (area, zone, own) {
        (Some(id), None, None) => {
            let region = areas
                .iter()
                .find(|area| area.id == id)
                .map(|area| area.region);
            (region.unwrap_or_default(), RegionRef::Area(id))
        }
        (None, Some(id), None) => {
            let region = zones
                .iter()
                .find(|zone| zone.id == id)
                .map(|zone| zone.region);
            (region.unwrap_or_default(), RegionRef::Zone(id))
        }
        (None, None, Some(region)) => (region, RegionRef::Own),
        (area, zone, own) => {
            let count = [area.is_some(), zone.is_some(), own.is_some()]
                .iter()
                .filter(|x| **x)
                .count();
            let (kind, found) = match count {
                0 => (ProblemKind::MissingKey, "none of them".to_owned()),
                count => (ProblemKind::Inconsistent, format!("{count} of them")),
            };
            let expected = "exactly one of `area`, `zone` and `region`";
            report.push(report.problem(kind, &s.at("area"), found, expected));
            (Rect::default(), RegionRef::Own)
        }
    };
    MonitorKind::RegionReached { region, of }
}

fn skill(id: &str, s: &Section<'_>) -> SkillConfig {
    #[derive(Clone, Copy)]
    enum Kind {
        Corridor,
        EndOfLane,
        UTurn,
        Stop,
    }
    let kind = s.choice(
        "controller",
        &[
            ("corridor", Kind::Corridor),
            ("end-of-lane", Kind::EndOfLane),
            ("u-turn", Kind::UTurn),
            ("stop", Kind::Stop),
        ],
    );
    let controller = match kind {
        Some(Kind::Corridor) => ControllerConfig::Corridor,
        Some(Kind::EndOfLane) => ControllerConfig::EndOfLane {
            distance_m: s.number("distance_m", LENGTH),
        },
        Some(Kind::UTurn) => ControllerConfig::UTurn {
            direction: s
                .choice("direction", DIRECTIONS)
                .unwrap_or(TurnDirection::Left),
            radius_m: s.number("radius_m", LENGTH),
        },
        Some(Kind::Stop) => ControllerConfig::Stop,
        None => {
            for key in ["distance_m", "direction", "radius_m"] {
                let _ = s.has(key);
            }
            ControllerConfig::Stop
        }
    };
    SkillConfig {
        id: id.to_owned(),
        controller,
        perception: s.text("perception", "a perception kind"),
        monitors: s.texts("monitors", "a monitor's event"),
    }
}

fn fsm(role: &str, s: &Section<'_>) -> (String, FsmConfig) {
    let fsm = FsmConfig {
        initial: s.text("initial", "the name of a state"),
        external: s.texts("external", "an event's name"),
        states: s.section("states", "sections [fsm.<role>.states.<name>]", |s| {
            s.each(state)
        }),
        transitions: s.list(
            "transitions",
            "tables { from = …, on = …, to = … }",
            transition,
        ),
    };
    (role.to_owned(), fsm)
}

fn state(name: &str, s: &Section<'_>) -> FsmState {
    FsmState {
        name: name.to_owned(),
        area: s.text("area", "an area's id"),
        skill: s.text("skill", "a skill's id"),
    }
}

fn transition(s: &Section<'_>) -> FsmTransition {
    FsmTransition {
        from: s.text("from", "the name of a state"),
        on: s.text("on", "an event's name"),
        to: s.text("to", "the name of a state"),
        outputs: s.texts("outputs", "an event's name"),
    }
}

fn robot(id: &str, s: &Section<'_>) -> (String, SiteRobot) {
    let robot = SiteRobot {
        role: s.text("role", "the name of a state machine, as in [fsm.<role>]"),
        start: s.pose("start", POSITION),
        start_state: s.text_if("start_state", "the name of a state"),
    };
    (id.to_owned(), robot)
}
