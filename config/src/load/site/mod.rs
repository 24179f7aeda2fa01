//! The sections of a site file.

mod coordination;
mod fsm;
mod monitors;
mod skills;

use std::collections::BTreeMap;

use crate::choices::{FEATURES, MANOEUVRES};
use crate::quantity::{Count, POSITION, Quantity};
use crate::reader::Section;
use crate::report::Report;
use crate::site::{
    Area, ControlLayer, Lane, Manoeuvre, PerceptionKind, PerceptionZone, SiteConfig, Wall,
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
        s.each(|event, s| monitors::read(event, s, &areas, &perception, report))
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
        skills: root.section("skills", "sections [skills.<id>]", |s| {
            s.each(|id, s| skills::read(id, s, report))
        }),
        fsm: root
            .section("fsm", "sections [fsm.<role>]", |s| s.each(fsm::read))
            .into_iter()
            .collect::<BTreeMap<_, _>>(),
        robots: root
            .section("robots", "sections [robots.<id>]", |s| s.each(fsm::robot))
            .into_iter()
            .collect::<BTreeMap<_, _>>(),
        roles: root
            .section_or_defaults("roles", |s| s.each(coordination::role))
            .into_iter()
            .collect(),
        coordinations: root
            .section_or_defaults("coordinations", |s| s.each(coordination::read))
            .into_iter()
            .collect(),
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
