use std::sync::Arc;
use std::time::Duration;

use contract::VERSION;
use contract::timing::{CANDIDATE_TIMEOUT_NS, LEVEL_PERIOD_NS};
use contract::wire::RobotReport;

use super::table::{Recognised, Sessions};
use crate::manager::alarm::Alarm;
use crate::manager::effects::Effects;
use crate::manager::names::Names;
use crate::setup::{RobotSetup, Setup};

const EPOCH: u64 = 3;
const SILENT_NS: u64 = 1_000;

fn sessions() -> (Sessions, Effects) {
    let robot = RobotSetup {
        id: "amr-1".into(),
        role: "normal".into(),
        priority: 0,
        starts_in: Vec::new(),
    };
    let setup = Setup {
        site: "hall".into(),
        areas: Vec::new(),
        robots: vec![robot],
        silent_after: Duration::from_nanos(SILENT_NS),
    };
    let names = Arc::new(Names::new(&setup).expect("valid"));
    (Sessions::new(&names, EPOCH, SILENT_NS), Effects::new(1))
}

fn report(boot_epoch: u64, session: u64, sequence: u64) -> RobotReport {
    RobotReport {
        version: Some(VERSION.into()),
        robot_id: "amr-1".into(),
        site: "hall".into(),
        mediator_epoch: if session == 0 { 0 } else { EPOCH },
        boot_epoch,
        session,
        sequence,
        ..RobotReport::default()
    }
}

/// Process 7 speaks for the robot, in session 1.
fn registered() -> (Sessions, Effects) {
    let (mut sessions, mut effects) = sessions();
    sessions.recognise(0, &report(7, 0, 1), 0, &mut effects);
    let recognised = sessions.recognise(0, &report(7, 1, 2), 0, &mut effects);
    assert!(recognised.promoted && recognised.counts);
    assert!(sessions.hear(0, 0, &mut effects).first);
    (sessions, effects)
}

#[test]
fn the_living_process_speaks_until_another_one_has_repeated_its_session() {
    let (mut sessions, mut effects) = registered();
    let offered = sessions.recognise(0, &report(8, 0, 9), 0, &mut effects);
    assert!(offered.changed && !offered.promoted && !offered.counts);
    assert!(
        sessions
            .recognise(0, &report(7, 1, 3), 0, &mut effects)
            .counts
    );
    let other = sessions.recognise(0, &report(8, 2, 10), 0, &mut effects);
    assert!(other.promoted && other.counts);
    // Its predecessor never comes back.
    let past = sessions.recognise(0, &report(7, 1, 4), 0, &mut effects);
    assert_eq!(past, Recognised::default());
    assert_eq!(effects.counters.stale, 1);
}

#[test]
fn nothing_counts_before_the_epoch_is_repeated_or_twice() {
    let (mut sessions, mut effects) = registered();
    let other_epoch = RobotReport {
        mediator_epoch: EPOCH - 1,
        ..report(7, 1, 3)
    };
    assert!(!sessions.recognise(0, &other_epoch, 0, &mut effects).counts);
    assert!(
        sessions
            .recognise(0, &report(7, 1, 4), 0, &mut effects)
            .counts
    );
    assert!(
        !sessions
            .recognise(0, &report(7, 1, 4), 0, &mut effects)
            .counts
    );
}

#[test]
fn a_candidate_that_does_not_come_back_is_given_up() {
    let (mut sessions, mut effects) = registered();
    sessions.recognise(0, &report(8, 0, 1), 0, &mut effects);
    sessions.keep_up(0, CANDIDATE_TIMEOUT_NS - 1, &mut effects);
    assert!(sessions.robot(0).candidate.is_some());
    sessions.keep_up(0, CANDIDATE_TIMEOUT_NS, &mut effects);
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
        let refused = sessions.recognise(0, &site, 0, &mut effects);
        assert_eq!(refused, Recognised::default());
    }
    assert!(sessions.robot(0).refusal(7).contains("yard"));
    assert!(matches!(&effects.alarms[..], [Alarm::Site { .. }]));
    let stranger = RobotReport {
        robot_id: "amr-9".into(),
        ..report(7, 0, 1)
    };
    assert_eq!(sessions.identify(&stranger, &mut effects), None);
    let refusal = sessions.next_refusal().expect("it is told");
    assert!(refusal.refusal.contains("amr-9") && refusal.session == 0);
    // With the right site it is welcome.
    sessions.recognise(0, &report(7, 0, 2), 0, &mut effects);
    assert_eq!(sessions.robot(0).refusal(7), "");
}

#[test]
fn silence_is_noticed_once_and_ends_with_a_report() {
    let (mut sessions, mut effects) = registered();
    assert!(!sessions.falls_silent(0, SILENT_NS));
    assert!(sessions.falls_silent(0, SILENT_NS + 1));
    assert!(!sessions.falls_silent(0, SILENT_NS + 2) && !sessions.is_heard(0));
    let heard = sessions.hear(0, SILENT_NS + 3, &mut effects);
    assert!(heard.again && !heard.first && sessions.is_heard(0));
    assert!(matches!(&effects.alarms[..], [Alarm::Back { .. }]));
}

#[test]
fn the_last_awaited_robot_completes_the_fleet() {
    let (mut sessions, mut effects) = sessions();
    sessions.wait_for(vec![0]);
    assert!(sessions.hear(0, 0, &mut effects).completes);
    assert!(!sessions.hear(0, 0, &mut effects).completes);
}

#[test]
fn the_candidate_is_told_before_the_process_that_speaks() {
    let (mut sessions, mut effects) = registered();
    sessions.recognise(0, &report(8, 0, 1), 0, &mut effects);
    sessions.keep_up(0, LEVEL_PERIOD_NS, &mut effects);
    let mut next = || sessions.next_listener(LEVEL_PERIOD_NS, &mut effects);
    assert_eq!(next(), Some((0, 8, 2)));
    assert_eq!(next(), Some((0, 7, 1)));
    assert_eq!(next(), None);
}
