use super::*;
use crate::map::SemanticMap;
use coordination::event::EventTable;
use description::areas::AreaIndex;
use description::geometry::{Footprint, Point2, Rect, Segment};
use description::keys::KeyErrors;
use description::site::{
    Area, ControlLayer, ControllerConfig, Feature, FsmConfig, FsmState, FsmTransition, Lane,
    Manoeuvre, Monitor, MonitorKind, PerceptionKind, Site, SkillConfig, TurnDirection, Wall,
};

mod manoeuvres;

type Spoil = fn(&mut Site);

const FOOTPRINT: Footprint = Footprint {
    front_m: 0.32,
    rear_m: 0.08,
    left_m: 0.15,
    right_m: 0.15,
};
const ROLE: &str = "test";

fn line(ax: f64, ay: f64, bx: f64, by: f64) -> Segment {
    Segment::new(Point2::new(ax, ay), Point2::new(bx, by))
}

fn wall(id: &str, line: Segment) -> Wall {
    let id = id.into();
    Wall { id, line }
}

fn lane(id: &str, line: Segment) -> Lane {
    Lane {
        id: id.into(),
        line,
        end_wall: None,
    }
}

fn area(id: &str, [min, max]: [[f64; 2]; 2], lane: Option<&str>, speed_limit_m_s: f64) -> Area {
    Area {
        id: id.into(),
        region: Rect::new(min.into(), max.into()),
        lane: lane.map(Into::into),
        capacity: 1,
        control: ControlLayer {
            manoeuvre: Manoeuvre::Any,
            speed_limit_m_s,
            deviation_limit_m: 0.3,
        },
    }
}

fn skill(id: &str, controller: ControllerConfig, monitors: &[&str]) -> SkillConfig {
    SkillConfig {
        id: id.into(),
        controller,
        speed_m_s: None,
        perception: "all".into(),
        monitors: monitors.iter().map(|&name| name.into()).collect(),
    }
}

fn state(name: &str, area: &str, skill: &str) -> FsmState {
    FsmState {
        name: name.into(),
        area: area.into(),
        also: Vec::new(),
        lane: None,
        skill: skill.into(),
    }
}

fn transition(from: &str, on: &str, to: &str) -> FsmTransition {
    FsmTransition {
        from: from.into(),
        on: on.into(),
        to: to.into(),
        outputs: Vec::new(),
    }
}

fn site() -> Site {
    let kind = PerceptionKind {
        tracks: vec![Feature::Corridor],
        searches: vec![Feature::LaneEnd],
    };
    let end = ControllerConfig::EndOfLane { distance_m: 1.2 };
    let turn = ControllerConfig::UTurn {
        direction: TurnDirection::Left,
        radius_m: 0.5,
    };
    let floor = [[0.0, -1.0], [9.0, 1.0]];
    let fsm = FsmConfig {
        initial: "drive".into(),
        states: vec![
            state("drive", "a", "corridor"),
            state("end", "a", "end"),
            state("turn", "turn", "turn"),
            state("back", "b", "corridor"),
            state("halt", "a", "stop"),
        ],
        transitions: vec![
            transition("drive", "near", "end"),
            transition("end", "done", "turn"),
            transition("end", "lost", "halt"),
            transition("turn", "done", "back"),
        ],
        ..FsmConfig::default()
    };
    Site {
        walls: vec![wall("east", line(10.0, -2.0, 10.0, 2.0))],
        lanes: vec![
            lane("out", line(1.0, -0.5, 9.0, -0.5)),
            lane("back", line(9.0, 0.5, 1.0, 0.5)),
        ],
        areas: vec![
            area("a", floor, Some("out"), 0.4),
            area("turn", floor, None, 0.3),
            area("b", floor, Some("back"), 0.9),
        ],
        perception_kinds: [("all".into(), kind)].into(),
        monitors: vec![Monitor {
            event: "done".into(),
            kind: MonitorKind::ManoeuvreDone,
        }],
        skills: vec![
            skill(
                "corridor",
                ControllerConfig::Corridor { offset_m: 0.0 },
                &[],
            ),
            skill("end", end, &["done"]),
            skill("turn", turn, &["done"]),
            skill("stop", ControllerConfig::Stop, &[]),
        ],
        fsm: [(ROLE.into(), fsm)].into(),
        ..Site::default()
    }
}

fn compiled(site: &Site) -> Result<Vec<Schedule>, KeyErrors> {
    let robot = RobotLimits {
        max_speed_m_s: 0.5,
        max_curvature_1_m: 2.5,
        footprint: FOOTPRINT,
    };
    let mut events = EventTable::new();
    let map = SemanticMap::new(site)?;
    let machine = machine(site, ROLE, &mut events)?;
    compile(site, ROLE, &map, &machine, &events, &robot)
}

fn states(site: &mut Site) -> &mut Vec<FsmState> {
    &mut site.fsm.get_mut(ROLE).unwrap().states
}

#[test]
fn what_the_data_do_not_say_follows_from_the_machine() {
    let schedules = compiled(&site()).unwrap();
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
    let mut site = site();
    let back = &mut states(&mut site)[3];
    (back.area, back.lane) = ("a".into(), Some("back".into()));
    let schedules = compiled(&site).unwrap();
    assert_eq!(
        (schedules[3].area, schedules[3].lane),
        (AreaIndex::new(0), Some(1))
    );
}

#[test]
fn what_does_not_fit_is_refused_with_names() {
    let cases: [(Spoil, &str); 11] = [
        (
            |site| drop(states(site).pop()),
            "fsm.test: found machine `test`",
        ),
        (
            |site| {
                let twice = states(site)[0].clone();
                states(site).push(twice);
            },
            "fsm.test: found machine `test` has two states named `drive`",
        ),
        (
            |site| site.fsm.clear(),
            "fsm.test: found state machine `test`",
        ),
        (
            |site| states(site)[0].skill = "fly".into(),
            "fsm.test.states.drive.skill: found skill `fly`, which does not exist",
        ),
        (
            |site| states(site)[0].area = "z".into(),
            "fsm.test.states.drive.area: found area `z`, which does not exist",
        ),
        (
            |site| states(site)[0].lane = Some("z".into()),
            "fsm.test.states.drive.lane: found lane `z`, which does not exist",
        ),
        (
            |site| states(site)[0].area = "turn".into(),
            "fsm.test.states.drive: found state `drive`, which needs a lane",
        ),
        (
            |site| site.skills[0].monitors = vec!["m".into()],
            "skills.corridor.monitors[0]: found monitor `m`, which does not exist",
        ),
        (
            |site| {
                site.skills[2].controller = ControllerConfig::UTurn {
                    direction: TurnDirection::Right,
                    radius_m: 0.5,
                }
            },
            "turns away from lane `back`",
        ),
        (
            |site| {
                let distance_m = f64::NAN;
                site.skills[1].controller = ControllerConfig::EndOfLane { distance_m };
            },
            "skills.end.distance_m: found NaN, expected a length above 0",
        ),
        (
            |site| site.skills[0].speed_m_s = Some(0.0),
            "skills.corridor.speed_m_s: found 0.0, expected a speed above 0",
        ),
    ];
    for (spoil, expected) in cases {
        let mut site = site();
        spoil(&mut site);
        let message = compiled(&site).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}
