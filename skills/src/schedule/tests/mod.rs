use super::*;
use crate::control::TurnDirection;
use crate::map::{AreaData, LaneData, MapData, SemanticMap, WallData};
use crate::monitors::MonitorKind;
use crate::perception::Feature;
use coordination::event::EventTable;
use coordination::fsm::{Machine, MachineModel};
use description::geometry::{Footprint, Point2, Rect, Segment};

mod manoeuvres;

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
