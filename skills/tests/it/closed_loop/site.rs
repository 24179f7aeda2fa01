//! The corridor with its lanes, areas, skills and machine, as the reference site describes it.

use crate::closed_loop::floor::{FOOTPRINT, lidar, line, rect};
use coordination::event::EventTable;
use coordination::fsm::MachineModel;
use description::geometry::{Pose2, Segment};
use skills::control::TurnDirection;
use skills::map::{AreaData, LaneData, MapData, WallData};
use skills::monitors::MonitorKind;
use skills::navigator::{NavigationGains, NavigatorSetup};
use skills::perception::{Feature, FeatureSet};
use skills::schedule::{ControllerSetup, MonitorSetup, SkillSetup, StateSetup};

pub fn walls() -> Vec<Segment> {
    map().walls.into_iter().map(|wall| wall.line).collect()
}

fn map() -> MapData {
    let wall = |id: &str, from, to| WallData {
        id: id.into(),
        line: line(from, to),
    };
    let lane = |id: &str, from, to, end: &str| LaneData {
        id: id.into(),
        line: line(from, to),
        end_wall: Some(end.into()),
    };
    let area = |id: &str, min, max, lane: Option<&str>, speed_limit_m_s| AreaData {
        id: id.into(),
        region: rect(min, max),
        lane: lane.map(Into::into),
        speed_limit_m_s,
        deviation_limit_m: 0.3,
    };
    MapData {
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
    }
}

fn skills() -> Vec<SkillSetup> {
    let both = FeatureSet {
        corridor: true,
        lane_end: true,
        walls: false,
    };
    let corridor: FeatureSet = [Feature::Corridor].into_iter().collect();
    let lane_end: FeatureSet = [Feature::LaneEnd].into_iter().collect();
    let skill = |id: &str, controller, tracks, searches, monitors: &[&str]| SkillSetup {
        id: id.into(),
        controller,
        speed_m_s: None,
        tracks,
        searches,
        monitors: monitors.iter().map(|&name| name.into()).collect(),
    };
    let none = FeatureSet::default();
    let end = ControllerSetup::EndOfLane {
        distance_m: 1.2,
        exit_speed_m_s: None,
    };
    let turn = ControllerSetup::UTurn {
        direction: TurnDirection::Left,
        radius_m: 0.5,
    };
    vec![
        skill(
            "follow-lane",
            ControllerSetup::Corridor { offset_m: 0.0 },
            corridor,
            none,
            &["in-2", "in-6", "strayed"],
        ),
        skill(
            "search-end",
            ControllerSetup::Corridor { offset_m: 0.0 },
            corridor,
            lane_end,
            &["end-stable", "in-3", "strayed"],
        ),
        skill("end-of-lane", end, both, none, &["lane-ended", "strayed"]),
        skill("u-turn-left", turn, both, none, &["turned"]),
        skill("stop", ControllerSetup::Stop, corridor, none, &[]),
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

pub fn setup(start: Pose2) -> (NavigatorSetup, EventTable) {
    let mut model = MachineModel::new("normal");
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
    for (name, _, _) in states {
        model.state(name);
    }
    model.initial("drive-1");
    for (from, on, to, outputs) in TRANSITIONS {
        model.transition(from, on, to, outputs);
    }
    let mut events = EventTable::new();
    let machine = model.compile(&mut events).expect("a sound machine");
    let region = |min, max| MonitorKind::RegionReached {
        region: rect(min, max),
    };
    let kinds = [
        ("in-2", region([5.5, -0.9], [8.5, 0.0])),
        ("in-3", region([8.5, -1.6], [10.0, 1.6])),
        ("in-6", region([1.5, 0.0], [4.5, 1.6])),
        (
            "end-stable",
            MonitorKind::EstimateStable {
                feature: Feature::LaneEnd,
                scans: 5,
                max_std_m: 0.05,
            },
        ),
        ("lane-ended", MonitorKind::ManoeuvreDone),
        ("turned", MonitorKind::ManoeuvreDone),
        ("strayed", MonitorKind::Deviation { limit_m: None }),
    ];
    let monitors = kinds
        .into_iter()
        .map(|(id, kind)| MonitorSetup {
            id: id.into(),
            event: events.intern(id).expect("room for a few events"),
            kind,
        })
        .collect();
    let states = states
        .map(|(name, area, skill)| StateSetup {
            name: name.into(),
            area: Some(area.into()),
            lane: None,
            skill: skill.into(),
        })
        .into();
    let setup = NavigatorSetup {
        map: map(),
        machine,
        states,
        skills: skills(),
        monitors,
        gains: NavigationGains::default(),
        max_speed_m_s: 0.4,
        footprint: FOOTPRINT,
        beams: lidar().beams,
        start,
        start_state: None,
    };
    (setup, events)
}
