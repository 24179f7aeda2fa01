//! Longer than 400 lines: one bench, on which all that areas promise is tried.

use contract::floor::Floor;
use std::sync::Arc;
use std::time::Duration;

use contract::wire::{Access, Level, RobotReport};

use super::reservations::{Reservations, Reserved};
use super::table::Areas;
use crate::journal::{Entry, Stored};
use crate::manager::alarm::{Alarm, BadReport};
use crate::manager::effects::Effects;
use crate::manager::names::Names;
use crate::manager::sessions::{Heard, Sessions};
use crate::nets::GivenBack;
use crate::setup::{AreaSetup, RobotSetup, Setup};

/// Nets that keep one area for one robot, or none.
#[derive(Default)]
struct Nets {
    keeps: Option<Reserved>,
    granted: Vec<(usize, usize)>,
    given_back: Vec<GivenBack>,
}

impl Reservations for Nets {
    fn kept(&self, area: usize) -> Vec<usize> {
        let kept = self.keeps.filter(|kept| kept.area == area);
        kept.map(|kept| kept.robot).into_iter().collect()
    }

    fn decide(&self, _area: usize, _robot: usize, _stands_in: &[usize]) -> bool {
        false
    }

    fn open(&self) -> Vec<Reserved> {
        self.keeps.into_iter().collect()
    }

    fn granted(&mut self, robot: usize, area: usize, _effects: &mut Effects) {
        self.granted.push((robot, area));
    }

    fn gave_back(&mut self, _: usize, _: usize, how: GivenBack, _: &mut Effects) {
        self.given_back.push(how);
    }
}

/// One area for one robot, and three robots that are heard; the last one goes first.
struct Bench {
    areas: Areas,
    sessions: Sessions,
    nets: Nets,
    effects: Effects,
}

impl Bench {
    fn new() -> Self {
        Self::restored(0)
    }

    /// Its journal knows this last fence.
    fn restored(fence: u64) -> Self {
        Self::holding(1, fence)
    }

    fn setup(capacity: u32) -> Setup {
        let robot = |(id, priority): (&str, u32)| RobotSetup {
            id: id.into(),
            role: "normal".into(),
            priority,
            ages_after: if priority == 0 { 2 } else { 0 },
            starts_in: Vec::new(),
        };
        Setup {
            site: "hall".into(),
            areas: vec![AreaSetup {
                id: "gate".into(),
                capacity,
            }],
            robots: [("a", 0), ("b", 0), ("first", 1)].map(robot).into(),
            floor: Floor::default(),
            silent_after: Duration::from_secs(1),
        }
    }

    fn holding(capacity: u32, fence: u64) -> Self {
        let setup = Self::setup(capacity);
        let names = Arc::new(Names::new(&setup).expect("valid"));
        let mut stored = Stored::new(1);
        stored.fences.insert("gate".into(), fence);
        let areas = Areas::restore(&setup, &names, &stored, 0).expect("valid");
        let mut sessions = Sessions::new(&names, 1, u64::MAX, 0);
        for robot in 0..3 {
            sessions.robot_mut(robot).registered = true;
        }
        Self {
            areas,
            sessions,
            nets: Nets::default(),
            effects: Effects::new(3),
        }
    }

    /// The robot reports where it stands, and its level of the gate: `path`, `progress` and `fence`.
    fn report(&mut self, robot: usize, stands: bool, level: (u32, u32, u64)) {
        self.take_in(robot, stands, level, false);
    }

    fn take_in(
        &mut self,
        robot: usize,
        stands: bool,
        (path, progress, fence): (u32, u32, u64),
        first: bool,
    ) {
        let level = Level {
            path,
            progress,
            ..Level::default()
        };
        let report = RobotReport {
            located: true,
            stands_in: stands.then(|| "gate".to_owned()).into_iter().collect(),
            access: vec![Access {
                area: "gate".into(),
                level: Some(level),
                fence,
            }],
            ..RobotReport::default()
        };
        let (nets, effects) = (&mut self.nets, &mut self.effects);
        let heard = Heard {
            first,
            awaited: first,
            ..Heard::default()
        };
        self.areas.take_in(robot, &report, heard, 0, nets, effects);
        self.areas.place(robot, &report, effects);
    }

    fn serve(&mut self) {
        (self.areas).serve(&self.sessions, &mut self.nets, &mut self.effects);
    }

    fn ask(&mut self, robot: usize) {
        self.report(robot, false, (0, 1, 0));
    }

    fn holder(&self) -> Option<usize> {
        (0..3).find(|&robot| self.areas.robot(robot).holds(0))
    }

    fn fence(&self) -> u64 {
        self.areas.area(0).fence
    }
}

#[test]
fn requests_are_served_by_priority_then_by_asking_with_growing_fences() {
    let mut bench = Bench::new();
    bench.ask(1);
    bench.ask(0);
    bench.ask(2);
    assert_eq!(bench.areas.area(0).queue, [2, 1, 0]);
    for (fence, robot) in [(1, 2), (2, 1), (3, 0)] {
        bench.serve();
        assert_eq!((bench.holder(), bench.fence()), (Some(robot), fence));
        bench.report(robot, false, (1, 3, fence));
    }
    assert_eq!(bench.holder(), None);
    assert_eq!(bench.nets.granted, [(2, 0), (1, 0), (0, 0)]);
}

#[test]
fn a_request_that_others_pass_ages() {
    let mut bench = Bench::new();
    bench.ask(0);
    bench.ask(2);
    assert_eq!(bench.areas.area(0).queue, [2, 0]);
    // The first two tickets are theirs.
    for (granted, queue) in [(1, [2, 0]), (3, [2, 0]), (4, [0, 2])] {
        bench.areas.pass(0, granted, &mut bench.effects);
        assert_eq!(bench.areas.area(0).queue, queue, "{granted}");
    }
    bench.serve();
    assert_eq!(bench.holder(), Some(0));
}

#[test]
fn a_release_of_an_older_grant_is_ignored() {
    let mut bench = Bench::new();
    bench.ask(0);
    bench.serve();
    bench.report(0, false, (1, 3, 7));
    assert_eq!(bench.holder(), Some(0));
    assert_eq!(bench.effects.counters.other_fence, 1);
}

#[test]
fn a_silent_robot_is_granted_nothing_and_keeps_what_it_has() {
    let mut bench = Bench::new();
    bench.sessions.robot_mut(0).silent = true;
    bench.ask(0);
    bench.ask(1);
    bench.serve();
    assert_eq!(bench.holder(), Some(1), "the next one may");
    bench.sessions.robot_mut(1).silent = true;
    bench.sessions.robot_mut(0).silent = false;
    bench.areas.touch(0);
    bench.serve();
    assert_eq!(bench.holder(), Some(1));
}

#[test]
fn nothing_is_granted_before_everybody_awaited_has_reported() {
    let mut bench = Bench::new();
    bench.sessions.wait_for(vec![2]);
    bench.ask(0);
    bench.serve();
    assert_eq!(bench.holder(), None);
    bench.sessions.hear(2, true, 0, &mut bench.effects);
    bench.areas.touch_all();
    bench.serve();
    assert_eq!(bench.holder(), Some(0));
}

#[test]
fn an_intruder_closes_the_area_until_it_has_left() {
    let mut bench = Bench::new();
    bench.report(0, false, (0, 0, 0));
    bench.report(0, true, (0, 0, 0));
    let alarms = &bench.effects.alarms;
    assert!(
        matches!(&alarms[..], [Alarm::Intruder { .. }]),
        "{alarms:?}"
    );
    assert!(bench.areas.is_closed(0));
    bench.ask(1);
    bench.serve();
    assert_eq!(bench.holder(), None);
    bench.report(0, false, (0, 0, 0));
    bench.serve();
    assert_eq!(bench.holder(), Some(1));
}

#[test]
fn an_intruder_closes_an_area_also_where_there_is_room_for_others() {
    let mut bench = Bench::holding(3, 0);
    bench.report(0, false, (0, 0, 0));
    bench.report(0, true, (0, 0, 0));
    bench.ask(1);
    bench.serve();
    assert_eq!(bench.holder(), None);
    // It asks, and has it: from then on it is one like others.
    bench.report(0, true, (0, 1, 0));
    bench.serve();
    let has = |robot| bench.areas.robot(robot).holds(0);
    assert!(has(0) && has(1));
}

/// Where both have room, neither waits until the other has left: each would for ever.
#[test]
fn of_two_intruders_each_has_the_area_that_both_fit_into_before_anybody_is_let_in() {
    let mut bench = Bench::holding(2, 0);
    for robot in [0, 1] {
        bench.report(robot, false, (0, 0, 0));
        bench.report(robot, true, (0, 0, 0));
        bench.report(robot, true, (0, 1, 0));
    }
    bench.ask(2);
    bench.serve();
    let has = |robot| bench.areas.robot(robot).holds(0);
    assert_eq!([0, 1, 2].map(has), [true, true, false]);
    assert!(!bench.areas.is_closed(0));
}

/// With a third one they are too many, and one has to leave.
#[test]
fn of_more_intruders_than_fit_none_has_the_area() {
    let mut bench = Bench::holding(2, 0);
    for robot in 0..3 {
        bench.report(robot, false, (0, 0, 0));
        bench.report(robot, true, (0, 0, 0));
        bench.report(robot, true, (0, 1, 0));
    }
    bench.serve();
    assert_eq!(bench.holder(), None);
    bench.report(1, false, (0, 0, 0));
    bench.serve();
    let has = |robot| bench.areas.robot(robot).holds(0);
    assert_eq!([0, 1, 2].map(has), [true, false, true]);
}

/// The last thing that it said while it knew where it was is that it had left; the report that said where it went was lost.
#[test]
fn a_robot_that_is_lost_is_not_where_it_had_left() {
    let mut bench = Bench::new();
    bench.ask(0);
    bench.serve();
    bench.report(0, true, (0, 3, 1));
    let lost = RobotReport {
        access: vec![Access {
            area: "gate".into(),
            level: Some(Level {
                progress: 4,
                ..Level::default()
            }),
            fence: 1,
        }],
        ..RobotReport::default()
    };
    let (nets, effects) = (&mut bench.nets, &mut bench.effects);
    bench
        .areas
        .take_in(0, &lost, Heard::default(), 0, nets, effects);
    bench.areas.place(0, &lost, &mut bench.effects);
    assert!(!bench.areas.robot(0).occupies(0) && bench.effects.alarms.is_empty());
    // Where it was and has not left, it may be.
    bench.report(1, true, (0, 0, 0));
    bench
        .areas
        .place(1, &RobotReport::default(), &mut bench.effects);
    assert!(bench.areas.robot(1).occupies(0));
}

#[test]
fn a_robot_that_was_found_in_the_area_is_no_intruder_and_comes_first() {
    let mut bench = Bench::new();
    bench.report(0, true, (0, 0, 0));
    assert!(bench.effects.alarms.is_empty());
    bench.ask(2);
    bench.report(0, true, (0, 1, 0));
    bench.serve();
    assert_eq!(bench.holder(), Some(0));
}

#[test]
fn a_grant_that_a_net_needs_is_asked_back_once_and_only_before_it_is_used() {
    let mut bench = Bench::new();
    bench.ask(0);
    bench.serve();
    bench.nets.keeps = Some(Reserved { area: 0, robot: 1 });
    bench.ask(1);
    for _ in 0..2 {
        bench.serve();
    }
    assert_eq!(bench.effects.counters.revocations, 1);
    assert_eq!(bench.areas.revocations_of(0, None)[0].fence, 1);
    assert_eq!(bench.holder(), Some(0), "until it has answered");

    let mut bench = Bench::new();
    bench.ask(0);
    bench.serve();
    bench.report(0, true, (0, 3, 1));
    bench.nets.keeps = Some(Reserved { area: 0, robot: 1 });
    bench.ask(1);
    bench.serve();
    assert_eq!(bench.effects.counters.revocations, 0);
}

/// What a net has let a robot into it may use to the end; who is there meanwhile keeps it out.
#[test]
fn what_a_robot_has_left_and_keeps_is_asked_back_only_if_it_would_meet_somebody() {
    let mut bench = Bench::new();
    bench.ask(0);
    bench.serve();
    bench.report(0, true, (0, 3, 1));
    bench.report(0, false, (0, 3, 1));
    bench.nets.keeps = Some(Reserved { area: 0, robot: 1 });
    bench.ask(1);
    bench.serve();
    bench.areas.revoke_what_is_not_used(0, &mut bench.effects);
    assert_eq!(bench.effects.counters.revocations, 0);
    bench.report(2, false, (0, 0, 0));
    bench.report(2, true, (0, 0, 0));
    bench.serve();
    assert_eq!(bench.effects.counters.revocations, 1);
    assert_eq!(bench.areas.revocations_of(0, None)[0].fence, 1);
}

#[test]
fn what_a_robot_gives_back_it_may_want_again_where_it_was_lost_started_anew_or_asked() {
    let given_back = |happens: fn(&mut Bench)| {
        let mut bench = Bench::new();
        bench.ask(0);
        bench.serve();
        bench.report(0, true, (0, 3, 1));
        bench.report(0, false, (0, 3, 1));
        happens(&mut bench);
        bench.report(0, false, (0, 4, 1));
        bench.nets.given_back
    };
    assert_eq!(given_back(|_| {}), [GivenBack::Used]);
    let happens: [fn(&mut Bench); 3] = [
        |bench| {
            let lost = RobotReport::default();
            bench.areas.place(0, &lost, &mut bench.effects);
            bench.report(0, false, (0, 3, 1));
        },
        |bench| {
            bench.areas.robots[0].forget_place();
            bench.report(0, false, (0, 3, 1));
        },
        |bench| {
            bench.report(2, false, (0, 0, 0));
            bench.report(2, true, (0, 0, 0));
            bench.serve();
        },
    ];
    for happens in happens {
        assert_eq!(given_back(happens), [GivenBack::Taken]);
    }
}

/// Until it has said where it stands it may be in what it has entered.
#[test]
fn what_a_robot_has_left_is_asked_back_when_it_says_where_it_is() {
    let mut bench = Bench::new();
    bench.ask(0);
    bench.serve();
    bench.report(0, true, (0, 3, 1));
    bench.report(0, false, (0, 3, 1));
    bench.areas.robots[0].forget_place();
    bench.report(2, false, (0, 0, 0));
    bench.report(2, true, (0, 0, 0));
    bench.serve();
    assert_eq!(bench.effects.counters.revocations, 0);
    bench.report(0, false, (0, 3, 1));
    bench.serve();
    assert_eq!(bench.effects.counters.revocations, 1);
}

#[test]
fn a_fence_is_written_down_with_its_grant() {
    let mut bench = Bench::new();
    bench.ask(0);
    bench.effects.entries.clear();
    bench.serve();
    let entries = &bench.effects.entries;
    let [Entry::Fence { fence: 1, .. }, Entry::Access { record, .. }] = &entries[..] else {
        panic!("{entries:?}");
    };
    assert_eq!(record.fence, 1);
}

/// What the manager said of the last report's area.
fn complaints(bench: &mut Bench) -> Vec<BadReport> {
    let alarms = bench.effects.alarms.drain(..);
    let bad = |alarm| match alarm {
        Alarm::BadReport { what, .. } => Some(what),
        _ => None,
    };
    alarms.filter_map(bad).collect()
}

#[test]
fn what_gives_a_grant_back_names_it_or_is_refused_in_words() {
    let mut bench = Bench::new();
    bench.ask(0);
    bench.serve();
    // Path 0 ends with `released`, path 1 with `returned`.
    for (path, progress) in [(0, 3), (0, 4), (1, 3)] {
        for found in [0, 2] {
            bench.report(0, false, (path, progress, found));
            assert_eq!(bench.holder(), Some(0), "{path} {progress} {found}");
        }
    }
    // Once for all of them, and counted.
    let expected = BadReport::Fence {
        found: 0,
        expected: 1,
    };
    assert_eq!(complaints(&mut bench), [expected]);
    assert_eq!(bench.effects.counters.other_fence, 6);
    // One that repeats its request knows nothing of the grant yet.
    bench.ask(0);
    assert_eq!(complaints(&mut bench), []);
    bench.report(0, false, (1, 3, 1));
    assert_eq!(bench.holder(), None);
}

#[test]
fn a_robot_that_claims_what_nobody_gave_it_is_not_believed() {
    let mut bench = Bench::new();
    bench.ask(0);
    bench.serve();
    bench.report(0, true, (0, 3, 1));
    // Nothing is frozen: the one that says so has restarted, or lies.
    bench.report(1, true, (0, 3, 2));
    assert_eq!((bench.holder(), bench.fence()), (Some(0), 1));
    assert!(matches!(complaints(&mut bench)[..], [BadReport::Merge(_)]));
    assert!(!bench.areas.robot(1).holds(0) && bench.areas.robot(1).stands_in(0));
}

#[test]
fn after_a_start_a_robot_is_believed_what_is_newer_than_the_journal() {
    let all = |fence: u64| {
        let mut bench = Bench::restored(5);
        bench.take_in(1, true, (0, 3, fence), true);
        (bench.holder(), bench.fence(), complaints(&mut bench))
    };
    assert_eq!(all(6), (Some(1), 6, vec![]));
    for found in [0, 5] {
        let no_grant = BadReport::NoGrant { found, after: 5 };
        assert_eq!(all(found), (None, 5, vec![no_grant]));
    }
    for found in [1 << 62, u64::MAX] {
        let (holder, fence, complaints) = all(found);
        assert_eq!((holder, fence), (None, 5));
        assert!(matches!(
            complaints[..],
            [BadReport::TooLarge { what: "fence", .. }]
        ));
    }
}

#[test]
fn an_intruder_takes_back_what_was_not_entered_yet() {
    let mut bench = Bench::new();
    bench.ask(0);
    bench.serve();
    bench.report(1, false, (0, 0, 0));
    bench.report(1, true, (0, 0, 0));
    (0..2).for_each(|_| bench.serve());
    assert_eq!(bench.effects.counters.revocations, 1);
    assert_eq!(bench.areas.revocations_of(0, None)[0].fence, 1);
    // It gives it back, and waits until the intruder has left.
    bench.report(0, false, (1, 3, 1));
    bench.take_in(0, false, (0, 1, 0), false);
    bench.serve();
    assert_eq!(bench.holder(), None);
}

#[test]
fn a_grant_that_was_kept_is_asked_back_again_until_it_is_entered_or_nobody_minds() {
    const SECOND_NS: u64 = 1_000_000_000;
    /// Answers the revocation of this run with `kept`, path 1.
    fn keeps(bench: &mut Bench, run: u32) {
        let level = Level {
            run,
            path: 1,
            progress: 2,
            ..Level::default()
        };
        let report = RobotReport {
            located: true,
            revocations: vec![Access {
                area: "gate".into(),
                level: Some(level),
                fence: 1,
            }],
            ..RobotReport::default()
        };
        let heard = Heard::default();
        let (nets, effects) = (&mut bench.nets, &mut bench.effects);
        bench.areas.take_in(0, &report, heard, 0, nets, effects);
    }
    for (stays, expected) in [(true, [1, 1, 2]), (false, [1, 1, 1])] {
        let mut bench = Bench::new();
        bench.ask(0);
        bench.serve();
        bench.report(1, false, (0, 0, 0));
        bench.report(1, true, (0, 0, 0));
        bench.serve();
        let run = bench.areas.revocations_of(0, None)[0]
            .level
            .map_or(0, |level| level.run);
        keeps(&mut bench, run);
        bench.report(1, stays, (0, 0, 0));
        let asked = [1, SECOND_NS, SECOND_NS + 1].map(|now_ns| {
            bench.areas.ask_again(now_ns);
            bench.serve();
            bench.effects.counters.revocations
        });
        assert_eq!(asked, expected);
        assert_eq!(bench.holder(), Some(0));
        if stays {
            // It is in the area: nobody asks a third time.
            keeps(&mut bench, run + 1);
            bench.report(0, true, (0, 3, 1));
            for seconds in 2..9 {
                bench.areas.ask_again(seconds * SECOND_NS);
                bench.serve();
            }
            assert_eq!(bench.effects.counters.revocations, 2);
        }
    }
}

#[test]
fn more_robots_than_an_area_holds_take_back_what_was_not_entered_yet() {
    let mut bench = Bench::holding(2, 0);
    bench.ask(0);
    bench.serve();
    assert_eq!(bench.holder(), Some(0));
    // Two were put into it: each was found there, and is no intruder.
    bench.report(1, true, (0, 0, 0));
    bench.serve();
    assert!(bench.effects.alarms.is_empty() && !bench.areas.is_closed(0));
    bench.report(2, true, (0, 0, 0));
    (0..2).for_each(|_| bench.serve());
    let overfull = Alarm::Overfull {
        area: "gate".into(),
        capacity: 2,
        found: 3,
        robots: "a, b, first".into(),
    };
    assert_eq!(bench.effects.alarms, [overfull]);
    assert!(bench.areas.is_closed(0));
    assert_eq!(bench.effects.counters.revocations, 1);
    assert_eq!(bench.areas.revocations_of(0, None)[0].fence, 1);
    // It gives it back, and the two that are left may be there.
    bench.report(0, false, (1, 3, 1));
    bench.serve();
    assert!(!bench.areas.is_closed(0));
    assert_eq!((bench.holder(), bench.effects.alarms.len()), (None, 1));
}

#[test]
fn one_intruder_takes_back_what_was_not_entered_yet_though_two_would_fit() {
    let mut bench = Bench::holding(2, 0);
    bench.ask(0);
    bench.serve();
    bench.report(1, false, (0, 0, 0));
    bench.report(1, true, (0, 0, 0));
    // Nobody waits, and there are not too many.
    (0..2).for_each(|_| bench.serve());
    assert!(bench.areas.is_closed(0));
    assert_eq!(bench.effects.counters.revocations, 1);
    assert_eq!(bench.areas.revocations_of(0, None)[0].fence, 1);
}

#[test]
fn how_often_others_have_passed_a_request_outlives_a_restart() {
    let mut bench = Bench::new();
    bench.ask(0);
    bench.ask(2);
    let mut stored = Stored::new(1);
    let mut pass = |bench: &mut Bench, granted| {
        bench.areas.pass(0, granted, &mut bench.effects);
        bench
            .effects
            .entries
            .drain(..)
            .for_each(|entry| stored.apply(entry));
        let names = Arc::clone(&bench.areas.names);
        let setup = Bench::setup(1);
        bench.areas = Areas::restore(&setup, &names, &stored, 0).expect("its own");
        bench.areas.area(0).queue.clone()
    };
    // The first two tickets are theirs; the first robot ages after two passes.
    assert_eq!(pass(&mut bench, 3), [2, 0]);
    assert_eq!(pass(&mut bench, 4), [0, 2]);
}
