//! A robot on a corridor's ring of areas against a mediator that grants what a test says.

use std::collections::{BTreeMap, BTreeSet};

use contract::protocols::{self, GRANTED, MEDIATOR};
use contract::wire::{self, AccessGrant, MediatorReport, RobotReport, TakeUp};
use contract::{VERSION, level};
use coordination::event::EventId;
use coordination::fsm::StateId;
use coordination::protocol::{FlagId, Party, Protocol, Replica, Side};
use description::geometry::{Footprint, Point2, Pose2, Rect};
use nalgebra::Matrix3;
use skills::borders::BorderGains;
use skills::navigator::Instruction;
use std::sync::Arc;

use super::*;

const MS: u64 = 1_000_000;

fn rect(min_m: (f64, f64), max_m: (f64, f64)) -> Rect {
    Rect::new(Point2::new(min_m.0, min_m.1), Point2::new(max_m.0, max_m.1))
}

/// Events of the test's machine have the length of their names for numbers.
fn number(event: &str) -> EventId {
    EventId(u16::try_from(event.len()).expect("short"))
}

/// As `config/sites/corridor.toml`: areas 1 to 5, numbered from 0.
pub(super) fn setup() -> Setup {
    let area = |id: &str, region| AreaPlace {
        id: id.into(),
        region,
    };
    let state = |name: &str, areas: &[usize], next: &[usize], accepts: &[&str]| StatePlan {
        name: name.into(),
        areas: areas.to_vec(),
        next: next.to_vec(),
        least_way_m: if name.starts_with("u-turn") {
            1.57
        } else {
            0.0
        },
        accepts: { accepts.iter() }
            .map(|&event| (event.to_owned(), number(event)))
            .collect(),
    };
    Setup {
        robot_id: "amr-1".into(),
        site: "corridor".into(),
        boot_epoch: 7,
        areas: vec![
            area("1", rect((1.5, -0.9), (5.5, 0.0))),
            area("2", rect((5.5, -0.9), (8.5, 0.0))),
            area("3", rect((8.5, -1.6), (10.0, 1.6))),
            area("4", rect((4.5, 0.0), (8.5, 1.6))),
            area("5", rect((3.0, -1.6), (5.0, -0.9))),
        ],
        states: vec![
            state("drive-1", &[0], &[1], &["in-2", "aside"]),
            state("search-2", &[1], &[2], &["end-stable"]),
            state("end-2", &[1], &[3], &["lane-ended"]),
            state("u-turn-3", &[2], &[4], &["turned"]),
            state("drive-4", &[3], &[], &[]),
            state("shift-5", &[4, 0], &[6], &["done"]),
            state("wait-5", &[4], &[], &["go"]),
            // Two areas at once, without an order.
            state("wide-1", &[0], &[8], &["in-2"]),
            state("wide-2", &[1, 3], &[], &[]),
        ],
        footprint: Footprint {
            front_m: 0.32,
            rear_m: 0.08,
            left_m: 0.15,
            right_m: 0.15,
        },
        borders: BorderGains::default(),
        deceleration_m_s2: 0.4,
        max_speed_m_s: 0.4,
        request_ahead_m: 0.5,
        silent_after_ns: 1000 * MS,
        start: Pose2::new(2.0, -0.5, 0.0),
        start_state: StateId(0),
    }
}

pub(super) fn at(x_m: f64, y_m: f64, theta_rad: f64, std_m: f64) -> Place {
    let variance = std_m * std_m;
    Place {
        pose: Pose2::new(x_m, y_m, theta_rad),
        covariance: Matrix3::from_diagonal_element(variance),
    }
}

/// One robot's mediator: the other side of protocol 1, and nothing else.
struct Mediator {
    flags: Arc<Protocol>,
    granted: FlagId,
    party: Party,
    runs: BTreeMap<String, (Replica, u64)>,
    free: BTreeSet<String>,
    sequence: u64,
    epoch: u64,
    session: u64,
    control: Option<wire::Control>,
    take_up: Option<TakeUp>,
}

impl Mediator {
    fn new(free: &[&str]) -> Self {
        let flags = Arc::new(protocols::access());
        Self {
            granted: flags.flag(GRANTED).expect("a flag"),
            party: flags.party(MEDIATOR).expect("a party"),
            flags,
            runs: BTreeMap::new(),
            free: free.iter().map(|&area| area.to_owned()).collect(),
            sequence: 0,
            epoch: 1,
            session: 1,
            control: None,
            take_up: None,
        }
    }

    fn hear(&mut self, report: &RobotReport) {
        if (report.mediator_epoch, report.session) != (self.epoch, self.session) {
            return;
        }
        for access in &report.access {
            let new = || {
                (
                    Replica::new(&self.flags, level::PROTOCOL_ID, self.party, 0),
                    0,
                )
            };
            let (replica, fence) = self.runs.entry(access.area.clone()).or_insert_with(new);
            let level = level::decode(access.level.as_ref()).expect("a level");
            replica.merge(level).expect("a level that can follow");
            while replica.poll().is_some() {}
            if self.free.contains(&access.area) && replica.set(self.granted).is_ok() {
                *fence += 1;
            }
        }
    }

    fn say(&mut self) -> MediatorReport {
        self.sequence += 1;
        let access = self
            .runs
            .iter()
            .map(|(area, (replica, fence))| AccessGrant {
                area: area.clone(),
                level: Some(level::encode(replica.level())),
                fence: *fence,
                waits_for: format!("area {area} is held by amr-2"),
            });
        MediatorReport {
            version: Some(VERSION.into()),
            mediator_epoch: self.epoch,
            sequence: self.sequence,
            robot_id: "amr-1".into(),
            boot_epoch: 7,
            session: self.session,
            access: access.collect(),
            control: self.control.clone(),
            take_up: self.take_up.clone(),
            ..MediatorReport::default()
        }
    }
}

struct Scene {
    member: Member,
    mediator: Mediator,
    now_ns: u64,
}

impl Scene {
    fn new(free: &[&str]) -> Self {
        Self {
            member: Member::new(setup(), 0),
            mediator: Mediator::new(free),
            now_ns: 0,
        }
    }

    /// The robot is there and drives at 0.4 m/s; messages both ways, until all is said.
    fn be(&mut self, state: &str, place: Place) {
        let sense = sense(state, place, 0.4);
        self.with(&sense);
    }

    fn with(&mut self, sense: &Sense) {
        for _ in 0..6 {
            self.now_ns += 10 * MS;
            self.member.step(sense, self.now_ns);
            if self.member.is_report_due(self.now_ns) {
                self.mediator.hear(&self.member.report(self.now_ns));
            }
            self.member.receive(&self.mediator.say(), self.now_ns);
        }
        self.member.step(sense, self.now_ns);
    }

    fn holds(&self) -> String {
        self.member.standing().holds
    }

    fn allowed(&self) -> Vec<usize> {
        self.member.allowed().iter().collect()
    }

    fn directives(&mut self) -> Vec<Directive> {
        std::iter::from_fn(|| self.member.next_directive()).collect()
    }
}

fn sense(state: &str, place: Place, speed_m_s: f64) -> Sense {
    let state = setup().states.iter().position(|one| one.name == state);
    Sense {
        place: Some(place),
        pose: Some(wire::Pose::default()),
        speed_m_s,
        state: Some(state.expect("a state")),
        waiting_for: None,
    }
}

#[test]
fn areas_are_asked_for_ahead_and_given_back_behind() {
    let mut scene = Scene::new(&["1", "2", "3", "4"]);
    assert!(
        scene.allowed().is_empty(),
        "nothing before the mediator spoke"
    );
    scene.be("drive-1", at(3.0, -0.5, 0.0, 0.01));
    assert_eq!(scene.holds(), "1");
    // 0.2 m to stop, 0.12 m until then, and 0.5 m more.
    scene.be("drive-1", at(4.2, -0.5, 0.0, 0.01));
    assert_eq!(scene.holds(), "1");
    scene.be("drive-1", at(4.6, -0.5, 0.0, 0.01));
    assert_eq!((scene.holds(), scene.allowed()), ("1 2".into(), vec![0, 1]));
    scene.be("search-2", at(5.55, -0.5, 0.0, 0.01));
    assert_eq!(scene.holds(), "1 2", "its rear is in area 1 still");
    scene.be("search-2", at(5.8, -0.5, 0.0, 0.01));
    assert_eq!((scene.holds(), scene.allowed()), ("2".into(), vec![1]));
    let standing = scene.member.standing();
    assert_eq!((standing.session, standing.mediator_epoch), (1, 1));
}

#[test]
fn what_is_not_free_is_waited_for_with_the_reason() {
    let mut scene = Scene::new(&["1"]);
    scene.be("drive-1", at(5.0, -0.5, 0.0, 0.01));
    assert_eq!((scene.holds(), scene.allowed()), ("1".into(), vec![0]));
    assert_eq!(scene.member.standing().waits, "2: area 2 is held by amr-2");
    scene.mediator.free.insert("2".into());
    scene.mediator.hear(&scene.member.report(scene.now_ns));
    scene.be("drive-1", at(5.1, -0.5, 0.0, 0.01));
    assert_eq!(scene.allowed(), [0, 1]);
}

#[test]
fn a_request_is_kept_when_the_robot_slows_down_before_the_border() {
    let mut scene = Scene::new(&["1", "2"]);
    scene.be("drive-1", at(4.5, -0.5, 0.0, 0.01));
    assert_eq!(scene.holds(), "1 2");
    scene.with(&sense("drive-1", at(4.5, -0.5, 0.0, 0.01), 0.0));
    assert_eq!(scene.holds(), "1 2");
}

#[test]
fn a_manoeuvre_begins_when_it_has_all_its_areas() {
    let mut scene = Scene::new(&["1", "2"]);
    scene.be("wide-1", at(5.0, -0.5, 0.0, 0.01));
    assert_eq!((scene.holds(), scene.allowed()), ("1 2".into(), vec![0]));
    scene.mediator.free.insert("4".into());
    scene.mediator.hear(&scene.member.report(scene.now_ns));
    scene.be("wide-1", at(5.0, -0.5, 0.0, 0.01));
    assert_eq!(scene.allowed(), [0, 1, 3]);
}

#[test]
fn what_keeps_the_robot_from_going_on_is_asked_for() {
    let mut scene = Scene::new(&["1", "5"]);
    scene.be("drive-1", at(4.0, -0.5, 0.0, 0.01));
    assert_eq!(scene.holds(), "1");
    scene.with(&Sense {
        waiting_for: Some(4),
        ..sense("drive-1", at(4.0, -0.7, 0.0, 0.01), 0.0)
    });
    assert_eq!(scene.holds(), "1 5");
}

#[test]
fn a_silent_mediator_leaves_what_the_robot_has_and_gives_no_more() {
    let mut scene = Scene::new(&["1", "2"]);
    scene.be("drive-1", at(4.0, -0.5, 0.0, 0.01));
    assert_eq!(scene.member.troubles(scene.now_ns), Troubles::default());
    let later_ns = scene.now_ns + 1100 * MS;
    let near = sense("drive-1", at(5.0, -0.5, 0.0, 0.01), 0.0);
    scene.member.step(&near, later_ns);
    assert!(scene.member.troubles(later_ns).silent);
    assert_eq!(scene.allowed(), [0]);
    let report = scene.member.report(later_ns);
    let asked = report.access.iter().any(|access| access.area == "2");
    assert!(!asked, "nobody is there to ask");
}

#[test]
fn nobody_at_all_is_told_too() {
    let mut member = Member::new(setup(), 0);
    assert!(!member.troubles(900 * MS).silent);
    assert!(member.troubles(1100 * MS).silent);
    member.receive(
        &MediatorReport {
            version: Some(VERSION.into()),
            mediator_epoch: 1,
            sequence: 1,
            robot_id: "amr-1".into(),
            boot_epoch: 7,
            refusal: "site `corridor` is not ours".into(),
            ..MediatorReport::default()
        },
        1200 * MS,
    );
    let troubles = member.troubles(1300 * MS);
    assert!(troubles.refused && !troubles.silent);
    assert!(member.refusal().contains("corridor"));
}

#[test]
fn a_mediator_of_another_version_is_refused_in_words() {
    let mut member = Member::new(setup(), 0);
    let message = MediatorReport {
        version: Some(wire::Version { major: 9, minor: 0 }),
        mediator_epoch: 1,
        sequence: 1,
        robot_id: "amr-1".into(),
        boot_epoch: 7,
        session: 1,
        ..MediatorReport::default()
    };
    member.receive(&message, MS);
    assert!(member.troubles(3 * MS).refused);
    assert!(member.refusal().contains("9.0"), "{}", member.refusal());
    let message = MediatorReport {
        version: Some(VERSION.into()),
        ..message
    };
    member.receive(&message, 4 * MS);
    assert!(!member.troubles(5 * MS).refused);
}

#[test]
fn an_uncertain_pose_gives_nothing_back() {
    let mut scene = Scene::new(&["1", "2"]);
    scene.be("drive-1", at(5.0, -0.5, 0.0, 0.01));
    assert_eq!(scene.holds(), "1 2");
    scene.with(&Sense {
        place: None,
        ..sense("drive-1", at(0.0, 0.0, 0.0, 1.0), 0.0)
    });
    assert_eq!(scene.holds(), "1 2");
    assert!(!scene.member.report(scene.now_ns).located);
}

#[test]
fn a_restarted_robot_goes_on_where_the_mediator_knows_it() {
    let mut scene = Scene::new(&["1"]);
    scene.mediator.take_up = Some(TakeUp {
        pose: Some(wire::Pose {
            x_m: 6.0,
            y_m: -0.5,
            ..wire::Pose::default()
        }),
        fsm_state: "search-2".into(),
    });
    // It thinks that it is at its start.
    scene.be("drive-1", at(2.0, -0.5, 0.0, 0.1));
    assert!(!scene.member.report(scene.now_ns).located);
    assert!(scene.allowed().is_empty());
    let directives = scene.directives();
    let [Directive::Relocate { pose, state, .. }] = directives.as_slice() else {
        panic!("{directives:?}");
    };
    assert_eq!((pose.x_m, *state), (6.0, StateId(1)));
    scene.member.relocated();
    scene.mediator.free.insert("2".into());
    scene.be("search-2", at(6.0, -0.5, 0.0, 0.1));
    assert_eq!(scene.allowed(), [1]);
}

#[test]
fn a_robot_that_nobody_can_place_waits_for_an_operator() {
    let mut scene = Scene::new(&["1"]);
    scene.mediator.take_up = Some(TakeUp {
        pose: None,
        fsm_state: "search-2".into(),
    });
    scene.be("drive-1", at(2.0, -0.5, 0.0, 0.1));
    assert!(scene.member.troubles(scene.now_ns).lost && scene.allowed().is_empty());
    assert!(scene.directives().is_empty());
    scene.member.reset();
    assert_eq!(scene.directives().len(), 1, "to its start");
    scene.member.relocated();
    scene.be("drive-1", at(2.0, -0.5, 0.0, 0.1));
    assert!(!scene.member.troubles(scene.now_ns).lost);
    assert_eq!(scene.allowed(), [0]);
}

#[test]
fn a_restarted_mediator_changes_nothing() {
    let mut scene = Scene::new(&["1", "2"]);
    scene.be("drive-1", at(4.6, -0.5, 0.0, 0.01));
    (scene.mediator.epoch, scene.mediator.sequence) = (2, 0);
    scene.be("drive-1", at(4.7, -0.5, 0.0, 0.01));
    assert_eq!(scene.holds(), "1 2");
    assert_eq!(scene.member.standing().mediator_epoch, 2);
    assert_eq!(scene.member.report(scene.now_ns).mediator_epoch, 2);
}

/// Protocol 2 with one step: go aside into area 5, done on the output "aside-done".
fn control(progress: u32) -> wire::Control {
    let flag = |name: &str, by_mediator| wire::ControlFlag {
        name: name.into(),
        by_mediator,
        ..wire::ControlFlag::default()
    };
    wire::Control {
        coordination: 3,
        level: Some(wire::Level {
            progress,
            ..wire::Level::default()
        }),
        net: "overtaking".into(),
        flags: vec![
            flag("acquire", true),
            flag("acquired", false),
            wire::ControlFlag {
                instruction: Some(wire::Instruction {
                    event: "aside".into(),
                    speed_limit_m_s: 0.2,
                    stop_at: None,
                    areas: vec!["5".into()],
                }),
                ..flag("e5", true)
            },
            wire::ControlFlag {
                on_output: "aside-done".into(),
                ..flag("done5", false)
            },
            flag("release", true),
            flag("released", false),
        ],
        paths: Vec::new(),
    }
}

#[test]
fn an_acquired_robot_asks_for_nothing_by_itself_and_does_as_ordered() {
    let mut scene = Scene::new(&["1", "2", "5"]);
    scene.be("drive-1", at(3.5, -0.5, 0.0, 0.01));
    scene.mediator.control = Some(control(1));
    scene.be("drive-1", at(4.6, -0.5, 0.0, 0.01));
    let standing = scene.member.standing();
    assert!(standing.acquired && standing.coordination == 3);
    assert_eq!(scene.holds(), "1", "area 2 is near, and not ordered");
    scene.mediator.control = Some(control(3));
    scene.be("drive-1", at(4.6, -0.5, 0.0, 0.01));
    assert_eq!(scene.holds(), "1 5");
    let ordered = Directive::Instruct(Instruction {
        speed_limit_m_s: Some(0.2),
        ..Instruction::plain(number("aside"))
    });
    assert_eq!(scene.directives(), [ordered]);
    scene.member.answered(Answer::Taken);
    scene.be("shift-5", at(4.6, -0.8, -0.3, 0.01));
    assert_eq!((scene.directives(), scene.allowed()), (vec![], vec![0, 4]));
    scene.member.output("aside-done");
    assert!(scene.member.is_report_due(scene.now_ns));
    let control_level = scene.member.report(scene.now_ns).control;
    let progress = control_level
        .and_then(|control| control.level)
        .map(|level| level.progress);
    assert_eq!(progress, Some(4));
    scene.mediator.control = Some(control(5));
    scene.be("wait-5", at(4.6, -1.2, 0.0, 0.01));
    assert!(!scene.member.standing().acquired);
    assert_eq!(scene.holds(), "5");
}
