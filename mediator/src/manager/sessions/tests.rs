use contract::floor::Floor;
use std::ops::RangeInclusive;
use std::sync::Arc;
use std::time::Duration;

use contract::VERSION;
use contract::client::{LAST_NUMBER, SEQUENCE_STEP};
use contract::timing::{CANDIDATE_TIMEOUT_NS, DOUBLED_AFTER_NS, LEVEL_PERIOD_NS};
use contract::wire::RobotReport;

use super::numbers::MOST_AT_FIRST;
use super::session::SESSIONS_PER_EPOCH;
use super::table::{Recognised, Sessions};
use crate::journal::RobotRecord;
use crate::manager::alarm::Alarm;
use crate::manager::effects::Effects;
use crate::manager::names::Names;
use crate::setup::{RobotSetup, Setup};

const EPOCH: u64 = 3;
const SILENT_NS: u64 = 1_000_000_000;
/// Process 7 is silent by then.
const LATER_NS: u64 = SILENT_NS + 1;

fn sessions() -> (Sessions, Effects) {
    let robot = RobotSetup {
        id: "amr-1".into(),
        role: "normal".into(),
        priority: 0,
        ages_after: 0,
        starts_in: Vec::new(),
    };
    let setup = Setup {
        site: "hall".into(),
        areas: Vec::new(),
        robots: vec![robot],
        floor: Floor::default(),
        silent_after: Duration::from_nanos(SILENT_NS),
    };
    let names = Arc::new(Names::new(&setup).expect("valid"));
    (Sessions::new(&names, EPOCH, SILENT_NS, 0), Effects::new(1))
}

/// Of the first, second, ... session in this epoch; 0 of none.
fn number(session: u64) -> u64 {
    if session == 0 {
        return 0;
    }
    EPOCH * SESSIONS_PER_EPOCH + session
}

fn report(boot_epoch: u64, session: u64, sequence: u64) -> RobotReport {
    RobotReport {
        version: Some(VERSION.into()),
        robot_id: "amr-1".into(),
        site: "hall".into(),
        floor_hash: Floor::default().hash(),
        mediator_epoch: if session == 0 { 0 } else { EPOCH },
        boot_epoch,
        session: number(session),
        sequence,
        ..RobotReport::default()
    }
}

/// Process 7 speaks for the robot, in session 1.
fn registered() -> (Sessions, Effects) {
    let (mut sessions, mut effects) = sessions();
    sessions.recognise(0, &report(7, 0, 1), true, 0, &mut effects);
    let recognised = sessions.recognise(0, &report(7, 1, 2), true, 0, &mut effects);
    assert!(recognised.promoted && recognised.counts);
    assert!(sessions.hear(0, true, 0, &mut effects).first);
    (sessions, effects)
}

/// Somebody who speaks in its name cannot make what it says old: for good, or without its being told.
#[test]
fn a_number_that_a_process_cannot_have_reached_is_not_believed() {
    let (mut sessions, mut effects) = registered();
    let mut counts = |session, sequence| {
        let said = report(7, session, sequence);
        sessions.identify(&said, 0, &mut effects).is_some()
            && sessions.recognise(0, &said, true, 0, &mut effects).counts
    };
    let half = LAST_NUMBER / 2;
    for lie in [u64::MAX, LAST_NUMBER, half + 1] {
        assert!(!counts(1, lie), "{lie}");
    }
    // Of another session: the robot is told nothing of it.
    assert!(!counts(2, half));
    assert!(counts(1, 3));
    // One that counts leaves room, and is told.
    assert!(counts(1, half) && !counts(1, 4));
    assert!(!counts(1, half + 1 + SEQUENCE_STEP) && counts(1, half + SEQUENCE_STEP));
    assert_eq!(sessions.robot(0).sequence, half + SEQUENCE_STEP);
    assert_eq!((effects.counters.bad, effects.counters.stale), (4, 1));
    let told = { effects.alarms.iter() }.filter(|own| matches!(own, Alarm::MadeUpNumber { .. }));
    assert_eq!(told.count(), 4);
}

/// As after a start of the mediator: the robot has gone on from a lie that counted before.
#[test]
fn a_large_first_number_is_believed_of_a_process_that_says_no_smaller_one() {
    let half = LAST_NUMBER / 2;
    let (mut sessions, mut effects) = sessions();
    let mut believes = |boot_epoch, sequence, now_ns| {
        let said = report(boot_epoch, 0, sequence);
        { sessions.identify(&said, now_ns, &mut effects) }.is_some()
    };
    for now_ns in 0..=SILENT_NS / 200_000_000 {
        assert!(!believes(7, half + 1 + now_ns, now_ns * 200_000_000));
    }
    assert!(believes(7, half + 9, SILENT_NS + 1));
    // Of another one that is as large, and of one that leaves the robot no room.
    assert!(!believes(8, half + 9, SILENT_NS + 2));
    assert!(!believes(7, MOST_AT_FIRST + 1, SILENT_NS + 3));
    // One lie at first: the process itself says smaller ones.
    assert!(!believes(9, half + 9, 2 * SILENT_NS) && believes(9, 3, 2 * SILENT_NS + 1));
    assert!(!believes(9, half + 9, 4 * SILENT_NS));
    assert!(matches!(
        effects.alarms[..],
        [Alarm::MadeUpNumber { found, .. }] if found == MOST_AT_FIRST + 1
    ));
}

#[test]
fn a_restarted_process_speaks_when_the_one_before_is_silent() {
    let (mut sessions, mut effects) = registered();
    for now_ns in [0, SILENT_NS] {
        let early = sessions.recognise(0, &report(8, 0, 1 + now_ns), true, now_ns, &mut effects);
        assert_eq!(early, Recognised::default());
        let refusal = sessions.next_refusal().expect("it is told");
        assert!(refusal.identity_taken && refusal.session == 0 && refusal.boot_epoch == 8);
    }
    let mut offer = |boot_epoch| {
        let asks = report(boot_epoch, 0, LATER_NS);
        sessions.recognise(0, &asks, true, LATER_NS, &mut effects)
    };
    assert!(offer(8).changed && !offer(8).promoted && !offer(8).counts);
    // It says something again: then nobody takes its place.
    let lives = sessions.recognise(0, &report(7, 1, 3), true, LATER_NS, &mut effects);
    assert!(lives.counts);
    let answer = report(8, 2, 2 * LATER_NS);
    let early = sessions.recognise(0, &answer, true, LATER_NS, &mut effects);
    assert_eq!(early, Recognised::default());
    let (now_ns, repeats) = (2 * LATER_NS, report(8, 2, 2 * LATER_NS + 1));
    let other = sessions.recognise(0, &repeats, true, now_ns, &mut effects);
    assert!(other.promoted && other.counts);
    assert!(effects.alarms.is_empty(), "{:?}", effects.alarms);
    // Its predecessor never comes back, and hears why.
    while sessions.next_refusal().is_some() {}
    let past = sessions.recognise(0, &report(7, 1, 4), true, now_ns, &mut effects);
    assert_eq!(past, Recognised::default());
    assert_eq!(effects.counters.stale, 1);
    assert!(
        sessions
            .next_refusal()
            .is_some_and(|own| own.boot_epoch == 7)
    );
}

/// Reports of processes 7 and 8, five times a second. Returns how often the journal must know something.
fn both_report(
    sessions: &mut Sessions,
    effects: &mut Effects,
    times_ns: RangeInclusive<u64>,
) -> u64 {
    let mut changes = 0;
    for now_ns in times_ns.step_by(200_000_000) {
        // Each has heard what was sent to it last.
        let heard = sessions.robot(0).sent;
        let says = |boot_epoch, session| RobotReport {
            mediator_epoch: EPOCH,
            mediator_sequence: heard,
            ..report(boot_epoch, session, 10 + now_ns / 1_000_000)
        };
        let present = sessions.recognise(0, &says(7, 1), true, now_ns, effects);
        assert!(present.counts);
        let other = sessions.recognise(0, &says(8, 0), true, now_ns, effects);
        assert!(!other.promoted && !other.counts);
        changes += u64::from(other.changed);
    }
    changes
}

#[test]
fn a_second_process_is_told_of_once_and_not_taken_in_afterwards() {
    let (mut sessions, mut effects) = registered();
    let times_ns = 0..=DOUBLED_AFTER_NS;
    assert_eq!(both_report(&mut sessions, &mut effects, times_ns), 0);
    assert!(effects.alarms.is_empty() && !sessions.is_doubled(0, DOUBLED_AFTER_NS));
    let until_ns = 2 * DOUBLED_AFTER_NS;
    // The journal knows it from now on.
    let times_ns = DOUBLED_AFTER_NS + 200_000_000..=until_ns;
    assert_eq!(both_report(&mut sessions, &mut effects, times_ns), 1);
    assert!(matches!(&effects.alarms[..], [Alarm::Doubled { .. }]));
    assert!(sessions.is_doubled(0, until_ns) && sessions.robot(0).doubled == 1);
    assert!(sessions.robot(0).record().found.contains(&8));
    // The first one falls silent, but where its body is, nobody knows.
    let now_ns = until_ns + LATER_NS;
    for sequence in now_ns..now_ns + 3 {
        let asks = sessions.recognise(0, &report(8, 0, sequence), true, now_ns, &mut effects);
        assert_eq!(asks, Recognised::default());
    }
    assert!(sessions.robot(0).candidate.is_none());
    // A process that an operator has started since is another matter.
    let restarted = sessions.recognise(0, &report(9, 0, 1), true, now_ns, &mut effects);
    assert!(restarted.changed);
    assert!(!sessions.is_doubled(0, now_ns + LATER_NS), "it is gone");
}

#[test]
fn late_reports_of_another_process_are_no_second_one() {
    let (mut sessions, mut effects) = registered();
    for now_ns in (0..3 * DOUBLED_AFTER_NS).step_by(200_000_000) {
        sessions.recognise(0, &report(7, 1, 10 + now_ns), true, now_ns, &mut effects);
        // It has heard nothing of late.
        sessions.recognise(0, &report(8, 0, 5 + now_ns), true, now_ns, &mut effects);
    }
    assert!(effects.alarms.is_empty(), "{:?}", effects.alarms);
}

#[test]
fn nothing_counts_before_the_epoch_is_repeated_or_twice() {
    let (mut sessions, mut effects) = registered();
    let other_epoch = RobotReport {
        mediator_epoch: EPOCH - 1,
        ..report(7, 1, 3)
    };
    assert!(
        !sessions
            .recognise(0, &other_epoch, true, 0, &mut effects)
            .counts
    );
    assert!(
        sessions
            .recognise(0, &report(7, 1, 4), true, 0, &mut effects)
            .counts
    );
    assert!(
        !sessions
            .recognise(0, &report(7, 1, 4), true, 0, &mut effects)
            .counts
    );
}

#[test]
fn a_candidate_that_does_not_come_back_is_given_up() {
    let (mut sessions, mut effects) = registered();
    sessions.recognise(0, &report(8, 0, 1), true, LATER_NS, &mut effects);
    sessions.keep_up(LATER_NS + CANDIDATE_TIMEOUT_NS - 1, &mut effects);
    assert!(sessions.robot(0).candidate.is_some());
    sessions.keep_up(LATER_NS + CANDIDATE_TIMEOUT_NS, &mut effects);
    assert!(sessions.robot(0).candidate.is_none());
}

#[test]
fn another_site_or_version_or_robot_is_refused_once() {
    let (mut sessions, mut effects) = sessions();
    let site = RobotReport {
        site: "yard".into(),
        ..report(7, 0, 1)
    };
    for _ in 0..2 {
        let refused = sessions.recognise(0, &site, true, 0, &mut effects);
        assert_eq!(refused, Recognised::default());
    }
    assert!(sessions.robot(0).refusal(7).contains("yard"));
    assert!(matches!(&effects.alarms[..], [Alarm::Site { .. }]));
    let stranger = RobotReport {
        robot_id: "amr-9".into(),
        ..report(7, 0, 1)
    };
    assert_eq!(sessions.identify(&stranger, 0, &mut effects), None);
    let refusal = sessions.next_refusal().expect("it is told");
    assert!(refusal.refusal.contains("amr-9") && refusal.session == 0);
    // With the right site it is welcome.
    sessions.recognise(0, &report(7, 0, 2), true, 0, &mut effects);
    assert_eq!(sessions.robot(0).refusal(7), "");
}

#[test]
fn silence_is_noticed_once_and_ends_with_a_report() {
    let (mut sessions, mut effects) = registered();
    assert!(!sessions.falls_silent(0, SILENT_NS));
    assert!(sessions.falls_silent(0, SILENT_NS + 1));
    assert!(!sessions.falls_silent(0, SILENT_NS + 2) && !sessions.is_heard(0));
    let heard = sessions.hear(0, true, SILENT_NS + 3, &mut effects);
    assert!(heard.again && !heard.first && sessions.is_heard(0));
    assert!(matches!(&effects.alarms[..], [Alarm::Back { .. }]));
}

#[test]
fn the_last_awaited_robot_completes_the_fleet() {
    let (mut sessions, mut effects) = sessions();
    sessions.wait_for(vec![0]);
    assert!(sessions.hear(0, true, 0, &mut effects).completes);
    assert!(!sessions.hear(0, true, 0, &mut effects).completes);
}

#[test]
fn the_candidate_is_told_before_the_process_that_speaks() {
    let (mut sessions, mut effects) = registered();
    sessions.recognise(0, &report(8, 0, 1), true, LATER_NS, &mut effects);
    let now_ns = LATER_NS + LEVEL_PERIOD_NS;
    sessions.keep_up(now_ns, &mut effects);
    let mut next = || sessions.next_listener(now_ns, &mut effects);
    assert_eq!(next(), Some((0, 8, number(2))));
    assert_eq!(next(), Some((0, 7, number(1))));
    assert_eq!(next(), None);
}

#[test]
fn a_robot_that_has_used_up_its_sessions_is_told_so() {
    let (mut sessions, mut effects) = sessions();
    let record = RobotRecord {
        issued: number(SESSIONS_PER_EPOCH - 1),
        ..RobotRecord::default()
    };
    sessions.robot_mut(0).restore(&record, 0);
    assert!((sessions.recognise(0, &report(7, 0, 1), true, LATER_NS, &mut effects)).changed);
    assert!(effects.alarms.is_empty() && sessions.next_refusal().is_none());
    let last = sessions.recognise(0, &report(8, 0, 1), true, LATER_NS, &mut effects);
    assert_eq!(last, Recognised::default());
    let told = matches!(&effects.alarms[..], [Alarm::TooManySessions { .. }]);
    assert!(told, "{:?}", effects.alarms);
    let refusal = sessions.next_refusal().expect("it hears why");
    assert!(refusal.refusal.contains("gets no more"), "{refusal:?}");
    // The one that was offered the last one may still take it.
    let taken = report(7, SESSIONS_PER_EPOCH, 2);
    assert!((sessions.recognise(0, &taken, true, LATER_NS, &mut effects)).promoted);
}

/// One that is refused reports between the offer and its answer.
#[test]
fn one_that_is_refused_neither_keeps_another_out_nor_hears_a_number_of_its_own() {
    let (mut sessions, mut effects) = sessions();
    let refused = |sequence| RobotReport {
        floor_hash: 1,
        ..report(8, 0, sequence)
    };
    sessions.recognise(0, &report(9, 0, 1), true, 0, &mut effects);
    let own = sessions.recognise(0, &refused(18_000), true, 1, &mut effects);
    assert_eq!(own, Recognised::default());
    let told = sessions.next_refusal().expect("it hears why");
    assert!(told.boot_epoch == 8 && told.refusal.contains("floor") && told.sequence < 100);
    assert_eq!(told.floor_hash, Floor::default().hash());
    let taken_in = sessions.recognise(0, &report(9, 1, 2), true, 2, &mut effects);
    assert!(taken_in.promoted);
    // Its file was mended meanwhile: what it was told is over, what another one is offered is not.
    let (mut sessions, mut effects) = self::sessions();
    sessions.recognise(0, &refused(1), true, 0, &mut effects);
    sessions.recognise(0, &report(9, 0, 1), true, 1, &mut effects);
    sessions.recognise(0, &report(8, 0, 2), true, 2, &mut effects);
    let taken_in = sessions.recognise(0, &report(9, 1, 2), true, 3, &mut effects);
    assert!(taken_in.promoted);
}
