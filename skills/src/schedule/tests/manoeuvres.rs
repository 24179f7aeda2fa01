//! A junction, a shoulder and a wall to dock at: what can be driven there.

use super::*;
use crate::perception::FeatureSet;
use description::geometry::Pose2;

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
            "state `shift` cannot be driven: 0.70 m aside within 1 m is too sharp: it takes 1.38 m",
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
