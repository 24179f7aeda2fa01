//! The corridor with its lanes, areas, skills and machine, as the reference site describes it.

use crate::closed_loop::floor::{area, line, rect, region, setup_of, state, transition};
use description::geometry::{Pose2, Segment};
use description::site::{
    ControllerConfig, Feature, FsmConfig, Lane, Monitor, MonitorKind, PerceptionKind, Site,
    SkillConfig, TurnDirection, Wall,
};
use skills::navigator::NavigatorSetup;

pub fn walls() -> Vec<Segment> {
    site().walls.into_iter().map(|wall| wall.line).collect()
}

fn site() -> Site {
    let wall = |id: &str, from, to| Wall {
        id: id.into(),
        line: line(from, to),
    };
    let lane = |id: &str, from, to, end: &str| Lane {
        id: id.into(),
        line: line(from, to),
        end_wall: Some(end.into()),
    };
    let area = |id, min, max, lane, limit_m_s| area(id, rect(min, max), lane, limit_m_s, 0.3);
    let kind = |name: &str, tracks: &[Feature], searches: &[Feature]| {
        let (tracks, searches) = (tracks.into(), searches.into());
        (name.to_owned(), PerceptionKind { tracks, searches })
    };
    let monitor = |event: &str, kind| Monitor {
        event: event.into(),
        kind,
    };
    let stable = MonitorKind::EstimateStable {
        feature: Feature::LaneEnd,
        scans: 5,
        max_std_m: 0.05,
    };
    Site {
        walls: vec![
            wall("south", [0.0, -1.6], [10.0, -1.6]),
            wall("north", [0.0, 1.6], [10.0, 1.6]),
            wall("east", [10.0, -1.6], [10.0, 1.6]),
            wall("west", [0.0, -1.6], [0.0, 1.6]),
        ],
        lanes: vec![
            lane("east", [1.2, -0.5], [8.8, -0.5], "east"),
            lane("west", [8.8, 0.5], [1.2, 0.5], "west"),
        ],
        areas: vec![
            area("1", [1.5, -0.9], [5.5, 0.0], Some("east"), 0.4),
            area("2", [5.5, -0.9], [8.5, 0.0], Some("east"), 0.4),
            area("3", [8.5, -1.6], [10.0, 1.6], None, 0.3),
            area("4", [4.5, 0.0], [8.5, 1.6], Some("west"), 0.4),
            area("6", [1.5, 0.0], [4.5, 1.6], Some("west"), 0.4),
            area("7", [0.0, -1.6], [1.5, 1.6], None, 0.3),
        ],
        perception_kinds: [
            kind("corridor", &[Feature::Corridor], &[]),
            kind("search", &[Feature::Corridor], &[Feature::LaneEnd]),
            kind("both", &[Feature::Corridor, Feature::LaneEnd], &[]),
        ]
        .into(),
        monitors: vec![
            monitor("in-2", region([5.5, -0.9], [8.5, 0.0])),
            monitor("in-3", region([8.5, -1.6], [10.0, 1.6])),
            monitor("in-6", region([1.5, 0.0], [4.5, 1.6])),
            monitor("end-stable", stable),
            monitor("lane-ended", MonitorKind::ManoeuvreDone),
            monitor("turned", MonitorKind::ManoeuvreDone),
            monitor("strayed", MonitorKind::Deviation { limit_m: None }),
        ],
        skills: skills(),
        ..Site::default()
    }
}

fn skills() -> Vec<SkillConfig> {
    let skill = |id: &str, controller, perception: &str, monitors: &[&str]| SkillConfig {
        id: id.into(),
        controller,
        speed_m_s: None,
        perception: perception.into(),
        monitors: monitors.iter().map(|&name| name.into()).collect(),
    };
    let follow = || ControllerConfig::Corridor { offset_m: 0.0 };
    let end = ControllerConfig::EndOfLane { distance_m: 1.2 };
    let turn = ControllerConfig::UTurn {
        direction: TurnDirection::Left,
        radius_m: 0.5,
    };
    let on_lane = ["in-2", "in-6", "strayed"];
    let searching = ["end-stable", "in-3", "strayed"];
    vec![
        skill("follow-lane", follow(), "corridor", &on_lane),
        skill("search-end", follow(), "search", &searching),
        skill("end-of-lane", end, "both", &["lane-ended", "strayed"]),
        skill("u-turn-left", turn, "both", &["turned"]),
        skill("stop", ControllerConfig::Stop, "corridor", &[]),
    ]
}

const TRANSITIONS: [(&str, &str, &str, &[&str]); 12] = [
    ("drive-1", "in-2", "search-2", &[]),
    ("search-2", "end-stable", "end-2", &[]),
    ("end-2", "lane-ended", "u-turn-3", &[]),
    ("u-turn-3", "turned", "drive-4", &[]),
    ("drive-4", "in-6", "search-6", &[]),
    ("search-6", "end-stable", "end-6", &[]),
    ("end-6", "lane-ended", "u-turn-7", &[]),
    ("u-turn-7", "turned", "drive-1", &["lap"]),
    ("drive-1", "strayed", "halt-1", &[]),
    ("halt-1", "reset", "drive-1", &[]),
    ("search-2", "in-3", "halt-2", &[]),
    ("halt-2", "reset", "search-2", &[]),
];

pub fn setup(start: Pose2) -> NavigatorSetup {
    let states = [
        ("drive-1", "1", "follow-lane"),
        ("search-2", "2", "search-end"),
        ("end-2", "2", "end-of-lane"),
        ("u-turn-3", "3", "u-turn-left"),
        ("drive-4", "4", "follow-lane"),
        ("search-6", "6", "search-end"),
        ("end-6", "6", "end-of-lane"),
        ("u-turn-7", "7", "u-turn-left"),
        ("halt-1", "1", "stop"),
        ("halt-2", "2", "stop"),
    ];
    let fsm = FsmConfig {
        initial: "drive-1".into(),
        states: states
            .map(|(name, area, skill)| state(name, area, skill))
            .into(),
        transitions: { TRANSITIONS.iter() }
            .map(|(from, on, to, outputs)| transition(from, on, to, outputs))
            .collect(),
        ..FsmConfig::default()
    };
    setup_of(site(), fsm, start)
}
