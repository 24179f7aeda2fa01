use contract::wire::{
    Access, AccessGrant, Control, ControlFlag, ControlPath, Level, MediatorReport, RobotReport,
    RobotState,
};

use super::*;
use crate::testing::{net, site};

const MS: u64 = 1_000_000;

fn observations() -> Observations {
    Observations::new(&site("corridor"), &[])
}

fn level(run: u32, path: u32, progress: u32) -> Option<Level> {
    Some(Level {
        run,
        path,
        progress,
        after_abort: false,
    })
}

fn says(robot: &str, area: &str, level: Option<Level>, fence: u64) -> RobotReport {
    RobotReport {
        robot_id: robot.into(),
        session: 1,
        access: vec![Access {
            area: area.into(),
            level,
            fence,
        }],
        ..RobotReport::default()
    }
}

fn hears(
    robot: &str,
    area: &str,
    level: Option<Level>,
    fence: u64,
    waits_for: &str,
) -> MediatorReport {
    MediatorReport {
        robot_id: robot.into(),
        session: 1,
        access: vec![AccessGrant {
            area: area.into(),
            level,
            fence,
            waits_for: waits_for.into(),
            ..AccessGrant::default()
        }],
        ..MediatorReport::default()
    }
}

#[test]
fn a_run_is_written_down_whatever_is_repeated_or_late() {
    let mut observations = observations();
    observations.report(&says("a", "2", level(1, 0, 1), 0), 10 * MS);
    observations.report(&says("a", "2", level(1, 0, 1), 0), 11 * MS);
    observations.answer(&hears("a", "2", level(1, 0, 2), 5, ""), 12 * MS);
    observations.report(&says("a", "2", level(1, 0, 3), 5), 20 * MS);
    observations.answer(&hears("a", "2", level(1, 0, 2), 5, ""), 21 * MS);
    observations.report(&says("a", "2", level(1, 0, 4), 5), 30 * MS);
    observations.report(&says("a", "2", level(1, 0, 3), 5), 31 * MS);
    let expected = Owning {
        area: "2".into(),
        robot: "a".into(),
        fence: 5,
        journal: 0,
        requested_ns: Some(10 * MS),
        granted_ns: 12 * MS,
        entered_ns: Some(20 * MS),
        released_ns: Some(30 * MS),
        returned: false,
    };
    assert_eq!(observations.ownings(), [expected]);
    assert!(!observations.had("a", "2", 11 * MS, 0));
    assert!(observations.had("a", "2", 11 * MS, MS));
    assert!(observations.had("a", "2", 30 * MS, 0));
    assert!(!observations.had("a", "2", 32 * MS, MS));
    assert!(!observations.had("b", "2", 20 * MS, MS));
    assert_eq!(observations.latencies().grants_ns, [2 * MS]);
}

#[test]
fn a_robot_that_is_registered_anew_counts_its_runs_from_the_first_again() {
    let mut observations = observations();
    observations.answer(&hears("a", "2", level(0, 0, 2), 1, ""), 12 * MS);
    observations.report(&says("a", "2", level(0, 0, 4), 1), 30 * MS);
    observations.answer(&hears("a", "2", level(1, 0, 0), 0, ""), 31 * MS);
    // An older message.
    observations.answer(&hears("a", "2", level(0, 0, 2), 1, ""), 32 * MS);
    observations.answer(&hears("a", "2", level(0, 0, 2), 4, ""), 40 * MS);
    observations.report(&says("a", "2", level(0, 0, 3), 4), 50 * MS);
    observations.report(&says("a", "2", level(0, 0, 4), 4), 60 * MS);
    let had: Vec<_> = { observations.ownings().iter() }
        .map(|own| (own.fence, own.granted_ns, own.released_ns))
        .collect();
    assert_eq!(
        had,
        [(1, 12 * MS, Some(30 * MS)), (4, 40 * MS, Some(60 * MS))]
    );
}

#[test]
fn a_grant_that_is_given_back_was_never_entered() {
    let mut observations = observations();
    observations.report(&says("a", "2", level(1, 0, 1), 0), 1);
    observations.answer(&hears("a", "2", level(1, 0, 2), 1, ""), 2);
    observations.report(&says("a", "2", level(1, 1, 3), 1), 3);
    let own = &observations.ownings()[0];
    assert_eq!(
        (own.entered_ns, own.released_ns, own.returned),
        (None, Some(3), true)
    );
    // An end that was not heard, because the mediator gave the run up.
    observations.answer(&hears("a", "2", level(2, 0, 2), 2, ""), 4);
    observations.answer(&hears("a", "2", level(3, 0, 0), 0, ""), 5);
    assert_eq!(observations.ownings()[1].released_ns, Some(5));
}

#[test]
fn who_must_wait_is_no_measure_of_the_mediator() {
    let mut observations = observations();
    observations.report(&says("a", "2", level(1, 0, 1), 0), 1);
    observations.answer(&hears("a", "2", level(1, 0, 2), 1, ""), 2);
    // The area is taken.
    observations.report(&says("b", "2", level(1, 0, 1), 0), 3);
    assert_eq!(observations.waitings()[1].to_ns, None);
    observations.answer(&hears("b", "2", level(1, 0, 1), 0, "for 1 s: a (in it)"), 4);
    observations.report(&says("a", "2", level(1, 0, 4), 1), 5);
    observations.answer(&hears("b", "2", level(1, 0, 2), 2, ""), 6);
    assert_eq!(observations.latencies().grants_ns, [1]);
    let waited = &observations.waitings()[1];
    assert_eq!((waited.from_ns, waited.to_ns), (3, Some(6)));
    assert_eq!(waited.why, "for 1 s: a (in it)");
    // The mediator has a reason that the listener cannot know.
    observations.report(&says("a", "3", level(1, 0, 1), 0), 7);
    observations.answer(&hears("a", "3", level(1, 0, 1), 0, "kept for b"), 8);
    observations.answer(&hears("a", "3", level(1, 0, 2), 1, ""), 9);
    assert_eq!(observations.latencies().grants_ns, [1]);
}

#[test]
fn a_robot_without_a_session_has_said_nothing_yet() {
    let mut observations = observations();
    let mut report = says("a", "2", level(1, 0, 3), 1);
    report.session = 0;
    observations.report(&report, 1);
    assert!(observations.ownings().is_empty());
}

#[test]
fn an_operator_takes_a_robot_out_of_an_area() {
    let mut observations = observations();
    observations.answer(&hears("a", "2", level(1, 0, 2), 1, ""), 1);
    observations.cleared("2", &["a"], 7);
    assert_eq!(observations.ownings()[0].released_ns, Some(7));
    // Its mediator has believed the robot since.
    observations.cleared("2", &["a"], 8);
    observations.report(&says("a", "2", level(1, 0, 2), 1), 9);
    assert!(!observations.had("a", "2", 9, 0), "it says so alone");
    observations.answer(&hears("a", "2", level(1, 0, 2), 1, ""), 10);
    assert!(observations.had("a", "2", 11, 0));
    observations.answer(&hears("a", "2", level(1, 0, 2), 1, ""), 12);
    assert_eq!(observations.ownings().len(), 2);
}

fn control(number: u64, progress: u32, with_flags: bool) -> Option<Control> {
    let flag = |name: &str, by_mediator| ControlFlag {
        name: name.into(),
        by_mediator,
        ..ControlFlag::default()
    };
    let flags = vec![
        flag("acquire", true),
        flag("acquired", false),
        flag("e1", true),
        flag("done1", false),
        flag("release", true),
        flag("released", false),
    ];
    let path = ControlPath {
        flags: (0..6).collect(),
    };
    Some(Control {
        coordination: number,
        level: level(0, 0, progress),
        net: if with_flags { "passing" } else { "" }.into(),
        flags: if with_flags { flags } else { Vec::new() },
        paths: if with_flags { vec![path] } else { Vec::new() },
    })
}

fn ordered(robot: &str, control: Option<Control>) -> MediatorReport {
    MediatorReport {
        robot_id: robot.into(),
        session: 1,
        control,
        ..MediatorReport::default()
    }
}

fn answered(robot: &str, control: Option<Control>) -> RobotReport {
    RobotReport {
        robot_id: robot.into(),
        session: 1,
        control,
        ..RobotReport::default()
    }
}

#[test]
fn commands_are_measured_from_the_flag_that_led_to_them() {
    let mut observations = observations();
    observations.answer(&ordered("a", control(1, 1, true)), 10);
    observations.answer(&ordered("b", control(1, 1, true)), 11);
    assert!(observations.coordinated("passing", 10) && !observations.coordinated("passing", 9));
    assert!(!observations.coordinated("other", 10));
    observations.report(&answered("a", control(1, 2, false)), 20);
    // The last flag before the command led to it, whoever set it.
    observations.report(&answered("b", control(1, 2, false)), 30);
    observations.answer(&ordered("a", control(1, 3, true)), 33);
    assert_eq!(observations.latencies().commands_ns, [3]);
    // One flag, one measure; repeated levels are none.
    observations.answer(&ordered("b", control(1, 3, true)), 40);
    observations.answer(&ordered("a", control(1, 3, true)), 41);
    assert_eq!(observations.latencies().commands_ns, [3]);
    // The answer was heard before the robot's flag: when that was sent is not known.
    observations.answer(&ordered("a", control(1, 5, true)), 50);
    observations.report(&answered("a", control(1, 4, false)), 51);
    assert_eq!(observations.latencies().commands_ns, [3]);
    observations.report(&answered("a", control(1, 6, false)), 60);
    observations.answer(&ordered("b", None), 70);
    let ends: Vec<_> = observations
        .controlled()
        .iter()
        .map(|own| own.to_ns)
        .collect();
    assert_eq!(ends, [Some(60), Some(70)]);
    assert!(observations.coordinated("passing", 65) && !observations.coordinated("passing", 71));
}

#[test]
fn nets_that_let_robots_in_are_measured_by_their_areas() {
    let net = net("t-junction");
    let site = site("t-junction");
    let mut observations = Observations::new(&site, &[net]);
    observations.report(&says("a", "Cr", level(1, 0, 1), 0), 10);
    observations.answer(&hears("a", "Cr", level(1, 0, 2), 1, ""), 12);
    observations.report(&says("b", "Cr", level(1, 0, 1), 0), 20);
    observations.answer(&hears("b", "Cr", level(1, 0, 1), 0, "a"), 21);
    observations.report(&says("a", "Cr", level(1, 0, 4), 1), 30);
    observations.answer(&hears("b", "Cr", level(1, 0, 2), 2, ""), 34);
    assert_eq!(observations.latencies().commands_ns, [2, 4]);
    // The net has heard `a` and lets it wait, for something that is no flag: its grant answers none.
    observations.answer(&hears("b", "Cr", level(2, 0, 0), 2, ""), 35);
    observations.report(&says("a", "Cr", level(2, 0, 1), 0), 40);
    observations.answer(&hears("a", "Cr", level(2, 0, 1), 0, "the others"), 41);
    observations.answer(&hears("a", "Cr", level(2, 0, 2), 3, ""), 300);
    assert_eq!(observations.latencies().commands_ns, [2, 4]);
    assert_eq!(observations.latencies().grants_ns, [2]);
}

#[test]
fn steps_of_machines_are_written_down_once() {
    let mut observations = observations();
    let state = |sequence, fsm_state: &str| RobotState {
        robot_id: "a".into(),
        sequence,
        fsm_state: fsm_state.into(),
        ..RobotState::default()
    };
    observations.state(state(2, "drive"), 5);
    observations.state(state(1, "stop"), 6);
    observations.state(state(3, "drive"), 7);
    observations.state(state(4, "stop"), 8);
    let steps: Vec<_> = { observations.steps().iter() }
        .map(|step| (step.at_ns, step.state.as_str()))
        .collect();
    assert_eq!(steps, [(5, "drive"), (8, "stop")]);
    assert_eq!(observations.said("a").map(|said| said.at_ns), Some(8));
}

/// As a process of a mediator with this number, epoch and journal, with whom the robot has this session.
fn of(robot: RobotReport, instance: u64, epoch: u64, journal: u64, session: u64) -> RobotReport {
    RobotReport {
        mediator_instance: instance,
        mediator_epoch: epoch,
        mediator_journal: journal,
        session,
        ..robot
    }
}

fn by(
    answer: MediatorReport,
    instance: u64,
    epoch: u64,
    journal: u64,
    session: u64,
) -> MediatorReport {
    MediatorReport {
        instance,
        mediator_epoch: epoch,
        journal,
        session,
        ..answer
    }
}

#[test]
fn with_a_mediator_without_its_journal_all_counts_anew() {
    let mut observations = observations();
    let before = |answer| by(answer, 1, 1, 7, 3);
    let says_before = |report| of(report, 1, 1, 7, 3);
    observations.report(&says_before(says("a", "2", level(4, 0, 1), 0)), 10);
    observations.answer(&before(hears("a", "2", level(4, 0, 2), 9, "")), 12);
    observations.report(&says_before(says("a", "2", level(4, 0, 3), 9)), 13);
    observations.answer(&before(ordered("a", control(5, 3, true))), 14);
    // The robot is started anew, too; its first report says all that it has.
    let anew = |answer| by(answer, 2, 1, 8, 3);
    let says_anew = |report| of(report, 2, 1, 8, 2);
    observations.answer(&by(ordered("b", None), 2, 1, 8, 1), 19);
    observations.report(&says_anew(answered("a", None)), 20);
    assert_eq!(observations.ownings()[0].released_ns, Some(20));
    assert_eq!(observations.controlled()[0].to_ns, Some(19));
    // What was on its way.
    observations.report(&says_before(says("a", "2", level(4, 0, 4), 9)), 21);
    observations.answer(&before(ordered("a", control(5, 3, true))), 22);
    observations.report(&says_anew(says("a", "2", level(0, 0, 1), 0)), 30);
    let grant = |answer| MediatorReport {
        session: 2,
        ..anew(answer)
    };
    observations.answer(&grant(hears("a", "2", level(0, 0, 2), 1, "")), 32);
    observations.report(&says_anew(says("a", "2", level(0, 0, 4), 1)), 33);
    let had: Vec<_> = { observations.ownings().iter() }
        .map(|own| (own.fence, own.granted_ns, own.released_ns))
        .collect();
    assert_eq!(had, [(9, 12, Some(20)), (1, 32, Some(33))]);
    // A smaller number than before is news all the same.
    observations.answer(&grant(ordered("a", control(1, 1, true))), 40);
    let controlled: Vec<_> = { observations.controlled().iter() }
        .map(|own| (own.number, own.from_ns, own.to_ns))
        .collect();
    assert_eq!(controlled, [(5, 14, Some(19)), (1, 40, None)]);
}

#[test]
fn a_robot_that_keeps_what_it_has_with_another_mediator_goes_on() {
    let mut observations = observations();
    observations.answer(&by(hears("a", "2", level(4, 0, 2), 9, ""), 1, 1, 7, 3), 12);
    observations.report(&of(says("a", "2", level(4, 0, 3), 9), 1, 1, 7, 3), 13);
    // The other mediator knows nothing of it yet.
    observations.answer(&by(hears("a", "2", level(0, 0, 0), 0, ""), 2, 2, 8, 5), 19);
    observations.report(&of(says("a", "2", level(4, 0, 3), 9), 2, 2, 8, 5), 20);
    assert_eq!(observations.ownings().len(), 1);
    assert_eq!(observations.ownings()[0].released_ns, None);
    observations.report(&of(says("a", "2", level(4, 0, 4), 9), 2, 2, 8, 5), 21);
    assert_eq!(observations.ownings()[0].released_ns, Some(21));
}
