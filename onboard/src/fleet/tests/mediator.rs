//! A mediator that is silent, refuses, restarts, or takes the control.

use super::*;

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
            refusal: "site `corridor` is not ours".into(),
            ..said(1)
        },
        1200 * MS,
    );
    let troubles = member.troubles(1300 * MS);
    assert!(troubles.refused && !troubles.silent);
    assert!(member.refusal().contains("corridor"));
}

#[test]
fn people_hear_of_another_process_when_it_is_none_before_a_restart() {
    let mut member = Member::new(setup(), 0);
    let refused = |sequence| MediatorReport {
        refusal: "two processes report".into(),
        identity_taken: true,
        ..said(sequence)
    };
    for second in 1..=6 {
        member.receive(&refused(second), second * 1000 * MS);
        assert!(member.allowed().is_empty());
    }
    assert_eq!(member.troubles(6000 * MS), Troubles::default());
    assert!(member.troubles(6001 * MS).refused);
    let taken_in = MediatorReport {
        session: 1,
        refusal: String::new(),
        identity_taken: false,
        identity_doubled: true,
        ..refused(7)
    };
    member.receive(&taken_in, 6100 * MS);
    let troubles = member.troubles(6100 * MS);
    assert!(!troubles.refused && troubles.doubled);
}

#[test]
fn a_mediator_of_another_version_is_refused_in_words() {
    let mut member = Member::new(setup(), 0);
    let message = MediatorReport {
        version: Some(wire::Version { major: 9, minor: 0 }),
        session: 1,
        ..said(1)
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

/// The mediator knows a restarted robot at x = 6 m, in state `search-2`.
fn restarted(began: Began) -> Scene {
    let mut scene = Scene::new(&["1"]);
    scene.member = Member::new(Setup { began, ..setup() }, 0);
    scene.mediator.take_up = Some(TakeUp {
        pose: Some(wire::Pose {
            x_m: 6.0,
            y_m: -0.5,
            ..wire::Pose::default()
        }),
        fsm_state: "search-2".into(),
        ..TakeUp::default()
    });
    // It thinks that it is at its start.
    scene.be("drive-1", at(2.0, -0.5, 0.0, 0.1));
    scene
}

fn waits(scene: &mut Scene) -> bool {
    !scene.member.report(scene.now_ns).located && scene.allowed().is_empty()
}

/// A process before this one ended here, as it was asked to.
fn ended(x_m: f64, theta_rad: f64) -> Began {
    let stood = Stood {
        pose: Pose2::new(x_m, -0.5, theta_rad),
        state: "search-2".to_owned(),
        ..Stood::default()
    };
    Began::Afresh { ended: Some(stood) }
}

#[test]
fn a_restarted_robot_goes_on_where_it_ended_if_the_mediator_knows_it_there() {
    let mut scene = restarted(ended(6.1, 0.1));
    assert!(!waits(&mut scene) && scene.directives().is_empty());
    assert!(!scene.member.troubles(scene.now_ns).lost);
    scene.mediator.free.insert("2".into());
    scene.be("search-2", at(6.0, -0.5, 0.0, 0.1));
    assert_eq!(scene.allowed(), [1]);
}

#[test]
fn a_robot_that_ended_unheard_or_nobody_knows_where_waits_for_an_operator() {
    let unknown = Began::Afresh { ended: None };
    for began in [ended(6.5, 0.0), ended(6.0, 0.5), unknown, Began::Lost] {
        let text = format!("{began:?}");
        let supervised = began == Began::Lost;
        let mut scene = restarted(began);
        assert!(waits(&mut scene) && scene.directives().is_empty(), "{text}");
        let said = scene.member.troubles(scene.now_ns).lost;
        assert_eq!(said, !supervised, "the supervisor has");
        scene.member.relocated();
        scene.be("drive-1", at(2.0, -0.5, 0.0, 0.1));
        assert_eq!(scene.allowed(), [0]);
    }
}

/// It ended in this state.
fn in_state(began: Began, state: &str) -> Began {
    let Began::Afresh { ended: Some(ended) } = began else {
        return began;
    };
    let state = state.to_owned();
    Began::Afresh {
        ended: Some(Stood { state, ..ended }),
    }
}

/// What it has answered since, nobody has heard.
#[test]
fn a_robot_that_ended_in_a_later_state_than_the_mediator_has_heard_goes_back_to_that() {
    for state in ["drive-1", "search-99"] {
        let mut scene = restarted(in_state(ended(6.1, 0.1), state));
        assert!(waits(&mut scene));
        assert_eq!(scene.directives(), [Directive::Resume(StateId(1))]);
        scene.member.relocated();
        scene.be("search-2", at(6.0, -0.5, 0.0, 0.1));
        assert!(scene.member.report(scene.now_ns).located);
    }
}

/// A new journal: in which state the robot was, nobody remembers but itself.
#[test]
fn a_robot_that_ended_where_it_does_not_start_waits_if_nobody_knows_its_state() {
    let begins = [
        (in_state(ended(2.1, 0.0), "search-99"), true),
        (ended(6.0, 0.0), true),
        (in_state(ended(6.0, 0.0), "search-99"), false),
    ];
    for (began, knows) in begins {
        let text = format!("{began:?}");
        let mut scene = Scene::new(&["1"]);
        scene.member = Member::new(Setup { began, ..setup() }, 0);
        scene.be("drive-1", at(2.0, -0.5, 0.0, 0.1));
        assert_eq!(scene.allowed().is_empty(), !knows, "{text}");
        assert_eq!(scene.member.troubles(scene.now_ns).lost, !knows);
        assert!(scene.directives().is_empty());
    }
}

#[test]
fn a_lost_robot_that_the_mediator_does_not_know_either_is_not_at_its_start() {
    let mut scene = Scene::new(&["1"]);
    let lost = Setup {
        began: Began::Lost,
        ..setup()
    };
    scene.member = Member::new(lost, 0);
    scene.be("drive-1", at(2.0, -0.5, 0.0, 0.1));
    assert!(scene.allowed().is_empty());
    assert!(!scene.member.report(scene.now_ns).located);
    scene.member.relocated();
    scene.be("drive-1", at(2.0, -0.5, 0.0, 0.1));
    assert_eq!(scene.allowed(), [0]);
}

#[test]
fn a_robot_that_knows_where_it_was_goes_on_from_there() {
    let mut scene = Scene::new(&["1"]);
    let knows = Setup {
        began: Began::GoesOn,
        ..setup()
    };
    scene.member = Member::new(knows, 0);
    scene.mediator.take_up = Some(TakeUp {
        pose: None,
        fsm_state: "search-2".into(),
        ..TakeUp::default()
    });
    scene.be("drive-1", at(2.0, -0.5, 0.0, 0.1));
    assert!(scene.directives().is_empty() && !scene.member.troubles(scene.now_ns).lost);
    assert_eq!(scene.allowed(), [0]);
}

#[test]
fn a_robot_that_nobody_can_place_waits_for_an_operator() {
    let mut scene = Scene::new(&["1"]);
    scene.mediator.take_up = Some(TakeUp {
        pose: None,
        fsm_state: "search-2".into(),
        ..TakeUp::default()
    });
    scene.be("drive-1", at(2.0, -0.5, 0.0, 0.1));
    assert!(scene.member.troubles(scene.now_ns).lost && scene.allowed().is_empty());
    assert!(scene.directives().is_empty());
    // The operator tells navigation.
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
    assert_eq!(scene.state().mediator_epoch, 2);
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
    let standing = scene.state();
    assert!(standing.acquired == 1 && standing.coordination == 3);
    assert_eq!(scene.holds(), "1", "area 2 is near, and not ordered");
    scene.mediator.control = Some(control(3));
    scene.be("drive-1", at(4.6, -0.5, 0.0, 0.01));
    assert_eq!(scene.holds(), "1 5");
    let ordered = Directive::Instruct(Instruction {
        speed_limit_m_s: Some(0.2),
        ..Instruction::plain(number("aside"))
    });
    assert_eq!(scene.directives(), [ordered]);
    scene.member.answered(Instructed::Taken {
        from: StateId(0),
        to: StateId(5),
        hold: None,
    });
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
    assert_eq!(scene.state().acquired, 0);
    assert_eq!(scene.holds(), "5");
}
