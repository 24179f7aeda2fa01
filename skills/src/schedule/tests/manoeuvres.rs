//! A junction, a shoulder and a wall to dock at: what can be driven there.

use super::*;
use description::geometry::Pose2;
use description::site::{SiteRobot, StopPlace};

const REACH: RobotReach = RobotReach {
    footprint: FOOTPRINT,
    sees_m: 4.0,
    tube_curvature_1_m: 8.0,
    ahead_of_border_m: 0.31,
    behind_border_m: 0.36,
};

fn yard() -> Site {
    let skill = |id: &str, controller| skill(id, controller, &["late"]);
    let stop_at = |place| ControllerConfig::StopAt { place };
    let (offset_m, within_m) = (0.0, 1.5);
    let skills = vec![
        skill("drive", ControllerConfig::Corridor { offset_m }),
        skill("shift", ControllerConfig::Shift { offset_m, within_m }),
        skill("turn", ControllerConfig::Turn { radius_m: 0.8 }),
        skill(
            "before",
            stop_at(StopPlace::BeforeArea {
                area: "b".into(),
                margin_m: 0.05,
            }),
        ),
        skill("pose", stop_at(StopPlace::Pose(Pose2::new(4.0, 0.1, 0.0)))),
        skill("dock", ControllerConfig::Dock { distance_m: 0.3 }),
        skill("creep", ControllerConfig::Creep { distance_m: -0.4 }),
    ];
    let areas = ["a", "side", "north", "a", "a", "b", "b"];
    let name = |skill: &SkillConfig| skill.id.clone();
    let fsm = FsmConfig {
        initial: "drive".into(),
        states: { skills.iter().map(name).zip(areas) }
            .map(|(name, area)| state(&name, area, &name))
            .collect(),
        transitions: { skills.iter().map(name) }
            .map(|name| transition("drive", &format!("to-{name}"), &name))
            .collect(),
        ..FsmConfig::default()
    };
    let kind = PerceptionKind {
        tracks: vec![Feature::Walls],
        searches: vec![Feature::LaneEnd],
    };
    Site {
        walls: vec![
            wall("east", line(10.0, -2.0, 10.0, 2.0)),
            wall("south", line(0.0, -2.0, 10.0, -2.0)),
            wall("corner", line(5.0, 2.0, 5.0, 8.0)),
        ],
        lanes: vec![
            lane("out", line(1.0, 0.0, 9.0, 0.0)),
            lane("shoulder", line(2.0, -0.7, 6.0, -0.7)),
            lane("north", line(7.0, 1.0, 7.0, 8.0)),
        ],
        areas: vec![
            area("a", [[0.0, -0.4], [6.0, 0.4]], Some("out"), 0.4),
            area("side", [[2.0, -1.1], [6.0, -0.4]], Some("shoulder"), 0.4),
            area("north", [[6.0, 1.0], [8.0, 8.0]], Some("north"), 0.4),
            area("b", [[6.0, -0.4], [10.0, 0.4]], Some("out"), 0.4),
        ],
        perception_kinds: [("all".into(), kind)].into(),
        monitors: vec![Monitor {
            event: "late".into(),
            kind: MonitorKind::After { after_s: 3.0 },
        }],
        skills,
        fsm: [(ROLE.into(), fsm)].into(),
        ..Site::default()
    }
}

#[test]
fn every_controller_finds_its_lanes_and_places() {
    let mut tight = yard();
    tight.skills[2].controller = ControllerConfig::Turn { radius_m: 0.4 };
    assert!(compiled(&tight).is_ok());
    let schedules = compiled(&yard()).unwrap();
    assert_eq!((schedules[1].lane, schedules[1].from_lane), (Some(1), None));
    assert_eq!(
        (schedules[2].lane, schedules[2].from_lane),
        (Some(2), Some(0))
    );
    // The lane begins at x = 1, the border lies at x = 6.
    let border = StopAt::Border {
        along_m: 5.0,
        margin_m: 0.05,
    };
    assert_eq!(schedules[3].controller, Controller::StopAt(border));
    let pose = StopAt::Pose {
        along_m: 3.0,
        offset_m: 0.1,
    };
    assert_eq!(schedules[4].controller, Controller::StopAt(pose));
    // Creeping has a speed of its own.
    assert!((schedules[6].speed_limit_m_s - 0.1).abs() < 1e-9);
}

#[test]
fn what_cannot_be_driven_is_refused_with_the_reason() {
    let cases: [(Spoil, &str); 19] = [
        (
            |yard| yard.skills[0].controller = ControllerConfig::Corridor { offset_m: -1.9 },
            "state `drive`, which cannot be driven: -1.9 m beside lane `out` it would be -0.05 m from wall `south`",
        ),
        (
            |yard| yard.skills[0].speed_m_s = Some(0.0),
            "skills.drive.speed_m_s: found 0.0, expected a speed above 0",
        ),
        (
            |yard| yard.monitors[0].kind = MonitorKind::After { after_s: 0.0 },
            "monitors.late.after_s: found 0.0, expected a duration above 0",
        ),
        (
            |yard| {
                yard.skills[1].controller = ControllerConfig::Shift {
                    offset_m: 0.0,
                    within_m: 1.0,
                }
            },
            "state `shift`, which cannot be driven: 0.70 m aside within 1 m is too sharp: it takes 1.38 m",
        ),
        (
            |yard| yard.lanes[1].line.b.y_m = -1.5,
            "state `shift`, which cannot be driven: its lanes must run along each other, and differ by 11°",
        ),
        (
            |yard| yard.skills[2].controller = ControllerConfig::Turn { radius_m: 0.39 },
            "skills.turn.radius_m: found 0.39, expected at least 0.400 m, for the robot's `navigation.max_curvature_1_m`",
        ),
        (
            |yard| yard.skills[2].controller = ControllerConfig::Turn { radius_m: 7.0 },
            "state `turn`, which cannot be driven: a curve of radius 7 m begins 7.00 m before the lanes meet, and the lane before the turn leaves 6.00 m",
        ),
        (
            |yard| {
                yard.skills[2].controller = ControllerConfig::Turn { radius_m: 4.0 };
                yard.walls[2].line.a.y_m = 0.6;
            },
            "state `turn`, which cannot be driven: on its way it would touch wall `corner`",
        ),
        (
            |yard| {
                yard.areas[2].lane = Some("out".into());
            },
            "state `turn`, which needs a lane to turn from",
        ),
        (
            |yard| {
                let place = StopPlace::BeforeArea {
                    area: "z".into(),
                    margin_m: 0.1,
                };
                yard.skills[3].controller = ControllerConfig::StopAt { place };
            },
            "skills.before.before_area: found area `z`, which does not exist",
        ),
        (
            |yard| {
                let place = StopPlace::BeforeArea {
                    area: "north".into(),
                    margin_m: 0.1,
                };
                yard.skills[3].controller = ControllerConfig::StopAt { place };
            },
            "skills.before.before_area: found area `north`, which lane `out` of state `before` does not lead to",
        ),
        (
            |yard| {
                let place = StopPlace::BeforeArea {
                    area: "b".into(),
                    margin_m: -0.1,
                };
                yard.skills[3].controller = ControllerConfig::StopAt { place };
            },
            "skills.before.margin_m: found -0.1, expected a length at least 0",
        ),
        (
            |yard| {
                let place = StopPlace::Pose(Pose2::new(4.0, 0.9, 0.0));
                yard.skills[4].controller = ControllerConfig::StopAt { place };
            },
            "skills.pose.pose: found (4.0, 0.9, 0.0 rad), 0.900 m from lane `out` of state `pose`",
        ),
        (
            |yard| {
                let place = StopPlace::Pose(Pose2::new(4.0, 0.0, 3.0));
                yard.skills[4].controller = ControllerConfig::StopAt { place };
            },
            "at most 0.2 rad off its direction",
        ),
        (
            |yard| drop(yard.walls.remove(0)),
            "state `dock`, which needs a lane that a wall closes",
        ),
        (
            |yard| yard.skills[5].controller = ControllerConfig::Dock { distance_m: 0.01 },
            "closer than the 0.05 m that can be measured",
        ),
        (
            |yard| yard.skills[6].controller = ControllerConfig::Creep { distance_m: 0.0 },
            "skills.creep.distance_m: found 0.0, expected a way of at least 0.01 m",
        ),
        (
            |yard| yard.skills[6].speed_m_s = Some(0.3),
            "state `creep`, which cannot be driven: backward at 0.3 m/s is faster",
        ),
        (
            |yard| {
                yard.skills[6].controller = ControllerConfig::Creep {
                    distance_m: f64::NAN,
                }
            },
            "skills.creep.distance_m: found NaN, expected a way",
        ),
    ];
    for (change, expected) in cases {
        let mut yard = yard();
        change(&mut yard);
        let message = compiled(&yard).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}\nexpected {expected}");
    }
}

#[test]
fn a_dock_must_track_the_wall_that_it_goes_up_to() {
    let mut yard = yard();
    let robot = SiteRobot {
        role: ROLE.into(),
        start: Pose2::new(2.0, 0.0, 0.0),
        start_state: None,
    };
    yard.robots.insert("one".into(), robot);
    let messages = |yard: &Site| -> Vec<String> {
        let errors = check(yard, "one", &REACH).expect_err("refused");
        errors.into_iter().map(|error| error.to_string()).collect()
    };
    let docks = |message: &&String| message.starts_with("skills.dock.perception");
    let told = messages(&yard);
    assert_eq!(
        told.iter().find(docks).unwrap(),
        "skills.dock.perception: found kind `all`, which does not track `lane-end`, expected a kind that does, for the controller `dock`"
    );
    let kind = yard.perception_kinds.get_mut("all").unwrap();
    kind.tracks.append(&mut kind.searches);
    assert_eq!(messages(&yard).iter().find(docks), None);
    let unknown = check(&yard, "two", &REACH).unwrap_err().to_string();
    assert_eq!(
        unknown,
        "robots.two: found robot `two`, which does not exist, expected the name of a robot"
    );
}

/// 0.40 m of body, with 0.31 m before the one border and 0.36 m behind the other.
#[test]
fn an_area_to_wait_in_holds_the_whole_robot() {
    let told = |length_m: f64, managed: bool, also: bool| {
        let mut yard = yard();
        let split_m = 6.0 + length_m;
        yard.areas_managed = managed;
        yard.areas[3].region = Rect::new([6.0, -0.4].into(), [split_m, 0.4].into());
        let beyond = [[split_m, -0.4], [10.0, 0.4]];
        yard.areas.push(area("c", beyond, Some("out"), 0.4));
        let mut states = ["a", "b", "c"].map(|id| state(id, id, "drive"));
        if also {
            states[1].also.push("a".into());
        }
        let fsm = FsmConfig {
            initial: "a".into(),
            states: states.into(),
            transitions: vec![transition("a", "to-b", "b"), transition("b", "to-c", "c")],
            ..FsmConfig::default()
        };
        yard.fsm.insert(ROLE.into(), fsm);
        let robot = SiteRobot {
            role: ROLE.into(),
            start: Pose2::new(2.0, 0.0, 0.0),
            start_state: None,
        };
        yard.robots.insert("one".into(), robot);
        let errors = check(&yard, "one", &REACH).err();
        let keys = errors.into_iter().flatten();
        let found = keys.map(|error| error.to_string());
        { found }.find(|text| text.contains("where the robot waits"))
    };
    assert_eq!(
        told(1.0, true, false).expect("too short"),
        format!(
            "fsm.{ROLE}.states.b: found area `b`, where the robot waits in 1 m of its lane, expected at least 1.07 m: the body and what it keeps from both borders while it knows its place as at its start; or the area behind in the state's `also`"
        )
    );
    assert_eq!(told(1.08, true, false), None, "long enough");
    assert_eq!(told(1.0, true, true), None, "it waits with what is behind");
    assert_eq!(told(1.0, false, false), None, "nobody waits for areas");
}
