use super::*;
use crate::control::TurnDirection;
use crate::geometry::{Footprint, Point2, Rect, Segment};
use crate::map::{AreaData, LaneData, MapData, SemanticMap, WallData};
use crate::monitors::MonitorKind;
use crate::perception::Feature;
use coordination::event::EventTable;
use coordination::fsm::{Machine, MachineModel};

type Spoil = fn(&mut Plan);

const FOOTPRINT: Footprint = Footprint {
    front_m: 0.32,
    rear_m: 0.08,
    left_m: 0.15,
    right_m: 0.15,
};

struct Plan {
    map: SemanticMap,
    machine: Machine,
    states: Vec<StateSetup>,
    skills: Vec<SkillSetup>,
    monitors: Vec<MonitorSetup>,
}

fn plan() -> Plan {
    let line = |ax, ay, bx, by| Segment::new(Point2::new(ax, ay), Point2::new(bx, by));
    let lane = |id: &str, line| LaneData {
        id: id.into(),
        line,
        end_wall: None,
    };
    let area = |id: &str, lane: Option<&str>, speed_limit_m_s| AreaData {
        id: id.into(),
        region: Rect::new(Point2::new(0.0, -1.0), Point2::new(9.0, 1.0)),
        lane: lane.map(Into::into),
        speed_limit_m_s,
        deviation_limit_m: 0.3,
    };
    let map = SemanticMap::new(&MapData {
        walls: vec![WallData {
            id: "east".into(),
            line: line(10.0, -2.0, 10.0, 2.0),
        }],
        lanes: vec![
            lane("out", line(1.0, -0.5, 9.0, -0.5)),
            lane("back", line(9.0, 0.5, 1.0, 0.5)),
        ],
        areas: vec![
            area("a", Some("out"), 0.4),
            area("turn", None, 0.3),
            area("b", Some("back"), 0.9),
        ],
    });
    let mut model = MachineModel::new("test");
    model
        .state("drive")
        .state("end")
        .state("turn")
        .state("back")
        .state("halt");
    model.initial("drive");
    model.transition("drive", "near", "end", &[]);
    model.transition("end", "done", "turn", &[]);
    model.transition("end", "lost", "halt", &[]);
    model.transition("turn", "done", "back", &[]);
    let mut events = EventTable::new();
    let machine = model.compile(&mut events).unwrap();
    let skill = |id: &str, controller, monitors: &[&str]| SkillSetup {
        id: id.into(),
        controller,
        speed_m_s: None,
        tracks: [Feature::Corridor].into_iter().collect(),
        searches: [Feature::LaneEnd].into_iter().collect(),
        monitors: monitors.iter().map(|&name| name.into()).collect(),
    };
    let end = ControllerSetup::EndOfLane {
        distance_m: 1.2,
        exit_speed_m_s: None,
    };
    let turn = ControllerSetup::UTurn {
        direction: TurnDirection::Left,
        radius_m: 0.5,
    };
    let state = |name: &str, area: &str, skill: &str| StateSetup {
        name: name.into(),
        area: Some(area.into()),
        lane: None,
        skill: skill.into(),
    };
    Plan {
        map: map.unwrap(),
        machine,
        states: vec![
            state("drive", "a", "corridor"),
            state("end", "a", "end"),
            state("turn", "turn", "turn"),
            state("back", "b", "corridor"),
            state("halt", "a", "stop"),
        ],
        skills: vec![
            skill("corridor", ControllerSetup::Corridor { offset_m: 0.0 }, &[]),
            skill("end", end, &["done"]),
            skill("turn", turn, &["done"]),
            skill("stop", ControllerSetup::Stop, &[]),
        ],
        monitors: vec![MonitorSetup {
            id: "done".into(),
            event: events.id("done").unwrap(),
            kind: MonitorKind::ManoeuvreDone,
        }],
    }
}

impl Plan {
    fn compile(&self) -> Result<Vec<Schedule>, ScheduleError> {
        compile(
            &self.map,
            &self.machine,
            &self.states,
            &self.skills,
            &self.monitors,
            &RobotLimits {
                max_speed_m_s: 0.5,
                max_curvature_1_m: 2.5,
                footprint: FOOTPRINT,
            },
        )
    }
}

#[test]
fn what_the_data_do_not_say_follows_from_the_machine() {
    let schedules = plan().compile().unwrap();
    let turn = &schedules[2];
    assert_eq!((turn.lane, turn.end_lane), (Some(1), Some(0)));
    assert_eq!(turn.speed_limit_m_s, 0.3);
    // Of the states that follow the lane's end one turns, at 0.3 m/s, and one halts.
    let Controller::EndOfLane(end) = schedules[1].controller else {
        panic!("{:?}", schedules[1]);
    };
    assert_eq!(end.exit_speed_m_s, 0.3);
    assert_eq!(schedules[3].speed_limit_m_s, 0.5);
    assert!(schedules[0].features.lane_end && !schedules[0].tracks.lane_end);
    assert_eq!(
        (schedules[1].monitors.len(), schedules[0].monitors.len()),
        (1, 0)
    );
}

#[test]
fn a_lane_of_the_states_own_goes_before_the_areas() {
    let mut plan = plan();
    plan.states[3].area = Some("a".into());
    plan.states[3].lane = Some("back".into());
    let schedules = plan.compile().unwrap();
    assert_eq!((schedules[3].area, schedules[3].lane), (Some(0), Some(1)));
}

#[test]
fn what_does_not_fit_is_refused_with_names() {
    let cases: [(Spoil, &str); 9] = [
        (
            |plan| drop(plan.states.pop()),
            "state `halt` of the machine is described 0 times",
        ),
        (
            |plan| plan.states.push(plan.states[0].clone()),
            "state `drive` of the machine is described 2 times",
        ),
        (
            |plan| plan.states[0].name = "x".into(),
            "state `x` names the state of the machine `x`",
        ),
        (
            |plan| plan.states[0].skill = "fly".into(),
            "state `drive` names the skill `fly`",
        ),
        (
            |plan| plan.states[0].area = Some("z".into()),
            "state `drive` names the area `z`",
        ),
        (
            |plan| plan.states[0].lane = Some("z".into()),
            "state `drive` names the lane `z`",
        ),
        (
            |plan| plan.states[0].area = None,
            "state `drive` needs a lane",
        ),
        (
            |plan| plan.skills[0].monitors = vec!["m".into()],
            "skill `corridor` names the monitor `m`",
        ),
        (
            |plan| {
                plan.skills[2].controller = ControllerSetup::UTurn {
                    direction: TurnDirection::Right,
                    radius_m: 0.5,
                }
            },
            "turns away from lane `back`",
        ),
    ];
    for (spoil, expected) in cases {
        let mut plan = plan();
        spoil(&mut plan);
        let message = plan.compile().unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
    let mut plan = plan();
    plan.skills[1].controller = ControllerSetup::EndOfLane {
        distance_m: f64::NAN,
        exit_speed_m_s: None,
    };
    let message = plan.compile().unwrap_err().to_string();
    assert!(
        message.contains("distance of skill `end` must be positive"),
        "{message}"
    );
}

/// A junction, a shoulder and a wall to dock at.
mod manoeuvres {
    use super::*;
    use crate::geometry::Pose2;

    type Change = fn(&mut Yard);

    struct Yard {
        data: MapData,
        skills: Vec<SkillSetup>,
        after_s: f64,
    }

    fn skill(id: &str, controller: ControllerSetup) -> SkillSetup {
        SkillSetup {
            id: id.into(),
            controller,
            speed_m_s: None,
            tracks: [Feature::Walls].into_iter().collect(),
            searches: [Feature::LaneEnd].into_iter().collect(),
            monitors: vec!["late".into()],
        }
    }

    fn yard() -> Yard {
        let line = |ax, ay, bx, by| Segment::new(Point2::new(ax, ay), Point2::new(bx, by));
        let lane = |id: &str, line| LaneData {
            id: id.into(),
            line,
            end_wall: None,
        };
        let wall = |id: &str, line| WallData {
            id: id.into(),
            line,
        };
        let area = |id: &str, min: [f64; 2], max: [f64; 2], lane: &str| AreaData {
            id: id.into(),
            region: Rect::new(min.into(), max.into()),
            lane: Some(lane.into()),
            speed_limit_m_s: 0.4,
            deviation_limit_m: 0.3,
        };
        let stop_at = |target| ControllerSetup::StopAt { target };
        Yard {
            data: MapData {
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
                    area("a", [0.0, -0.4], [6.0, 0.4], "out"),
                    area("side", [2.0, -1.1], [6.0, -0.4], "shoulder"),
                    area("north", [6.0, 1.0], [8.0, 8.0], "north"),
                    area("b", [6.0, -0.4], [10.0, 0.4], "out"),
                ],
            },
            skills: vec![
                skill("drive", ControllerSetup::Corridor { offset_m: 0.0 }),
                skill(
                    "shift",
                    ControllerSetup::Shift {
                        offset_m: 0.0,
                        within_m: 1.5,
                    },
                ),
                skill("turn", ControllerSetup::Turn { radius_m: 0.8 }),
                skill(
                    "before",
                    stop_at(StopTarget::BeforeArea {
                        area: "b".into(),
                        margin_m: 0.05,
                    }),
                ),
                skill("pose", stop_at(StopTarget::Pose(Pose2::new(4.0, 0.1, 0.0)))),
                skill("dock", ControllerSetup::Dock { distance_m: 0.3 }),
                skill("creep", ControllerSetup::Creep { distance_m: -0.4 }),
            ],
            after_s: 3.0,
        }
    }

    impl Yard {
        fn compile(&self) -> Result<Vec<Schedule>, ScheduleError> {
            let map = SemanticMap::new(&self.data).unwrap();
            let areas = ["a", "side", "north", "a", "a", "b", "b"];
            let mut model = MachineModel::new("yard");
            let mut states = Vec::new();
            for (skill, area) in self.skills.iter().zip(areas) {
                model.state(&skill.id);
                states.push(StateSetup {
                    name: skill.id.clone(),
                    area: Some(area.into()),
                    lane: None,
                    skill: skill.id.clone(),
                });
                model.transition("drive", &format!("to-{}", skill.id), &skill.id, &[]);
            }
            model.initial("drive");
            let mut events = EventTable::new();
            let machine = model.compile(&mut events).unwrap();
            let late = MonitorSetup {
                id: "late".into(),
                event: events.intern("late").unwrap(),
                kind: MonitorKind::After {
                    seconds: self.after_s,
                },
            };
            let robot = RobotLimits {
                max_speed_m_s: 0.5,
                max_curvature_1_m: 2.5,
                footprint: FOOTPRINT,
            };
            compile(&map, &machine, &states, &self.skills, &[late], &robot)
        }
    }

    #[test]
    fn every_controller_finds_its_lanes_and_places() {
        let schedules = yard().compile().unwrap();
        assert_eq!((schedules[1].lane, schedules[1].from_lane), (Some(1), None));
        assert_eq!(
            (schedules[2].lane, schedules[2].from_lane),
            (Some(2), Some(0))
        );
        // The lane begins at x = 1, the border lies at x = 6.
        let border = StopPlace::Border {
            along_m: 5.0,
            margin_m: 0.05,
        };
        assert_eq!(schedules[3].controller, Controller::StopAt(border));
        let pose = StopPlace::Pose {
            along_m: 3.0,
            offset_m: 0.1,
        };
        assert_eq!(schedules[4].controller, Controller::StopAt(pose));
        // Creeping has a speed of its own.
        assert!((schedules[6].speed_limit_m_s - 0.1).abs() < 1e-9);
    }

    #[test]
    fn what_cannot_be_driven_is_refused_with_the_reason() {
        let cases: [(Change, &str); 20] = [
            (
                |yard| yard.skills[0].controller = ControllerSetup::Corridor { offset_m: -1.9 },
                "state `drive` cannot be driven: -1.9 m beside lane `out` it would be -0.05 m from wall `south`",
            ),
            (
                |yard| yard.skills[0].speed_m_s = Some(0.0),
                "speed of skill `drive` must be positive, found 0",
            ),
            (
                |yard| yard.after_s = 0.0,
                "seconds of monitor `late` must be positive, found 0",
            ),
            (
                |yard| {
                    yard.skills[1].controller = ControllerSetup::Shift {
                        offset_m: 0.0,
                        within_m: 1.0,
                    }
                },
                "state `shift` cannot be driven: 0.70 m aside within 1 m is too sharp: it takes 1.42 m",
            ),
            (
                |yard| yard.data.lanes[1].line.b.y_m = -1.5,
                "state `shift` cannot be driven: its lanes must run along each other, and differ by 11°",
            ),
            (
                |yard| yard.skills[2].controller = ControllerSetup::Turn { radius_m: 0.3 },
                "state `turn` cannot be driven: its radius is 0.3 m, and the tightest curve of 2.5 1/m needs 0.400 m",
            ),
            (
                |yard| yard.skills[2].controller = ControllerSetup::Turn { radius_m: 7.0 },
                "state `turn` cannot be driven: a curve of radius 7 m begins 7.00 m before the lanes meet, and the lane before the turn leaves 6.00 m",
            ),
            (
                |yard| {
                    yard.skills[2].controller = ControllerSetup::Turn { radius_m: 4.0 };
                    yard.data.walls[2].line.a.y_m = 0.6;
                },
                "state `turn` cannot be driven: on its way it would touch wall `corner`",
            ),
            (
                |yard| {
                    yard.data.areas[2].lane = Some("out".into());
                },
                "state `turn` needs a lane to turn from",
            ),
            (
                |yard| {
                    let target = StopTarget::BeforeArea {
                        area: "z".into(),
                        margin_m: 0.1,
                    };
                    yard.skills[3].controller = ControllerSetup::StopAt { target };
                },
                "skill `before` names the area `z`",
            ),
            (
                |yard| {
                    let target = StopTarget::BeforeArea {
                        area: "north".into(),
                        margin_m: 0.1,
                    };
                    yard.skills[3].controller = ControllerSetup::StopAt { target };
                },
                "area `north` does not begin ahead on lane `out`",
            ),
            (
                |yard| {
                    let target = StopTarget::BeforeArea {
                        area: "b".into(),
                        margin_m: -0.1,
                    };
                    yard.skills[3].controller = ControllerSetup::StopAt { target };
                },
                "margin of skill `before` must be zero or more, found -0.1",
            ),
            (
                |yard| {
                    let target = StopTarget::Pose(Pose2::new(4.0, 0.9, 0.0));
                    yard.skills[4].controller = ControllerSetup::StopAt { target };
                },
                "state `pose` cannot be driven: its stop pose lies 3.00 m along lane `out`, 0.90 m beside it",
            ),
            (
                |yard| {
                    let target = StopTarget::Pose(Pose2::new(4.0, 0.0, 3.0));
                    yard.skills[4].controller = ControllerSetup::StopAt { target };
                },
                "172° off",
            ),
            (
                |yard| drop(yard.data.walls.remove(0)),
                "state `dock` needs a lane that a wall closes",
            ),
            (
                |yard| yard.skills[5].searches = FeatureSet::default(),
                "state `dock` cannot be driven: skill `dock` docks at a wall and does not look for the lane's end",
            ),
            (
                |yard| yard.skills[5].controller = ControllerSetup::Dock { distance_m: 0.01 },
                "closer than the 0.05 m that can be measured",
            ),
            (
                |yard| yard.skills[6].controller = ControllerSetup::Creep { distance_m: 0.0 },
                "distance of skill `creep` must be other than zero",
            ),
            (
                |yard| yard.skills[6].speed_m_s = Some(0.3),
                "state `creep` cannot be driven: backward at 0.3 m/s is faster",
            ),
            (
                |yard| {
                    yard.skills[6].controller = ControllerSetup::Creep {
                        distance_m: f64::NAN,
                    }
                },
                "distance of skill `creep` must be a number",
            ),
        ];
        for (change, expected) in cases {
            let mut yard = yard();
            change(&mut yard);
            let message = yard.compile().unwrap_err().to_string();
            assert!(message.contains(expected), "{message}\nexpected {expected}");
        }
    }
}
