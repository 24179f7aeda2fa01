//! A robot on a corridor's ring of areas against a mediator that grants what a test says.

mod areas;
mod lease;
mod lost;
mod mediator;

use std::collections::{BTreeMap, BTreeSet};

use contract::floor::Floor;
use contract::protocols::{self, GRANTED, MEDIATOR};
use contract::timing::LISTENS_FIRST_NS;
use contract::wire::{self, AccessGrant, MediatorReport, RobotReport, TakeUp};
use contract::{VERSION, level};
use coordination::event::EventId;
use coordination::fsm::StateId;
use coordination::protocol::{FlagId, Party, Protocol, Replica, Side};
use description::areas::AreaIndex;
use description::geometry::{Footprint, Point2, Pose2, Rect};
use nalgebra::Matrix3;
use skills::borders::BorderGains;
use skills::navigator::{Instructed, Instruction};
use std::sync::Arc;

use super::*;
use crate::symbols::values::FleetState;

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
    let state = |name: &str, areas: &[u8], next: &[usize], accepts: &[&str]| StatePlan {
        name: name.into(),
        areas: areas.iter().copied().map(AreaIndex).collect(),
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
        began: Began::Afresh { ended: None },
        start: Pose2::new(2.0, -0.5, 0.0),
        areas: vec![
            area("1", rect((1.5, -0.9), (5.5, 0.0))),
            area("2", rect((5.5, -0.9), (8.5, 0.0))),
            area("3", rect((8.5, -1.6), (10.0, 1.6))),
            area("4", rect((4.5, 0.0), (8.5, 1.6))),
            area("5", rect((3.0, -1.6), (5.0, -0.9))),
        ],
        floor: Floor::default(),
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
        factsheet: contract::wire::Factsheet::default(),
    }
}

pub(super) fn at(x_m: f64, y_m: f64, theta_rad: f64, std_m: f64) -> UncertainPose {
    let variance = std_m * std_m;
    UncertainPose {
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
    /// Of the robot's newest report.
    heard: u64,
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
            heard: 0,
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
        self.heard = report.sequence;
        for access in &report.access {
            let new = || (protocols::begin(&self.flags, self.party), 0);
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
                ..AccessGrant::default()
            });
        MediatorReport {
            mediator_epoch: self.epoch,
            session: self.session,
            robot_sequence: self.heard,
            access: access.collect(),
            control: self.control.clone(),
            take_up: self.take_up.clone(),
            ..said(self.sequence)
        }
    }
}

/// A message of the mediator that registers nobody.
fn said(sequence: u64) -> MediatorReport {
    MediatorReport {
        version: Some(VERSION.into()),
        instance: 60,
        journal: 60,
        mediator_epoch: 1,
        sequence,
        robot_id: "amr-1".into(),
        boot_epoch: 7,
        floor_hash: Floor::default().hash(),
        ..MediatorReport::default()
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
    fn be(&mut self, state: &str, place: UncertainPose) {
        let sense = sense(state, place, 0.4);
        self.with(&sense);
    }

    fn with(&mut self, sense: &Sense) {
        if self.now_ns == 0 {
            // It has listened for long enough to be alone with its mediator.
            (0..=LISTENS_FIRST_NS / (100 * MS)).for_each(|_| self.talk(sense, 100 * MS));
        }
        (0..6).for_each(|_| self.talk(sense, 10 * MS));
        self.member.step(sense, self.now_ns);
    }

    fn talk(&mut self, sense: &Sense, since_ns: u64) {
        self.now_ns += since_ns;
        self.member.step(sense, self.now_ns);
        if self.member.is_report_due(self.now_ns) {
            self.mediator.hear(&self.member.report(self.now_ns));
        }
        self.member.receive(&self.mediator.say(), self.now_ns);
    }

    fn state(&self) -> FleetState {
        self.member.state(self.now_ns)
    }

    fn holds(&self) -> String {
        self.state().holds.as_str().to_owned()
    }

    fn allowed(&self) -> Vec<usize> {
        self.member.allowed().iter().map(AreaIndex::place).collect()
    }

    fn directives(&mut self) -> Vec<Directive> {
        std::iter::from_fn(|| self.member.next_directive()).collect()
    }
}

fn sense(state: &str, place: UncertainPose, speed_m_s: f64) -> Sense {
    let state = setup().states.iter().position(|one| one.name == state);
    Sense {
        place: Some(place),
        pose: Some(wire::Pose::default()),
        speed_m_s,
        state: Some(state.expect("a state")),
        waiting_for: None,
    }
}
