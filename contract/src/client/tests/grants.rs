//! Grants that are asked back, or that a robot gives back because it was elsewhere than was thought.

use super::*;
use crate::timing::LISTENS_FIRST_NS;

fn revocation(progress: u32, fence: u64) -> Access {
    Access {
        area: "2".into(),
        level: level(0, 0, progress),
        fence,
    }
}

/// In area 1, and granted area 2 with fence 5.
fn granted() -> Client {
    let mut client = registered();
    client.step(
        situation(&["1"], &["1", "2"], &[]),
        LISTENS_FIRST_NS,
        SECOND_NS,
    );
    let mut told = message(2);
    told.robot_sequence = client.report().sequence;
    told.access = vec![grant("1", 2, 1), grant("2", 2, 5)];
    client.receive(&told, LISTENS_FIRST_NS);
    client
}

/// Asked for and granted area 2, then asked back by `fence`.
fn revoked(fence: u64, now: Situation) -> (Client, RobotReport) {
    let mut client = granted();
    assert!(client.holds("2") && client.may_be_in("2", LISTENS_FIRST_NS));
    let mut told = message(3);
    told.revocations = vec![revocation(1, fence)];
    client.receive(&told, LISTENS_FIRST_NS);
    assert!(client.holds("2"), "until it answers");
    assert!(
        !client.may_be_in("2", LISTENS_FIRST_NS),
        "but it enters no more"
    );
    client.step(now, LISTENS_FIRST_NS, SECOND_NS);
    let report = client.report();
    (client, report)
}

#[test]
fn a_robot_that_can_stop_yields() {
    let (client, report) = revoked(5, situation(&["1"], &["1", "2"], &[]));
    assert!(!client.holds("2"));
    assert_eq!(client.counters().yielded, 1);
    let answer = report.revocations[0]
        .level
        .map(|level| (level.path, level.progress));
    assert_eq!(answer, Some((0, 2)), "yielded");
    let access = report.access.iter().find(|access| access.area == "2");
    let access = access.and_then(|access| access.level);
    assert_eq!(
        access.map(|level| (level.path, level.progress)),
        Some((1, 3)),
        "returned"
    );
}

#[test]
fn a_robot_that_cannot_stop_keeps_it() {
    for now in [
        situation(&["1"], &["1", "2"], &["2"]),
        situation(&["1", "2"], &["1", "2"], &[]),
    ] {
        let (client, report) = revoked(5, now);
        assert!(client.holds("2"));
        assert_eq!(client.counters().kept, 1);
        let answer = report.revocations[0]
            .level
            .map(|level| (level.path, level.progress));
        assert_eq!(answer, Some((1, 2)), "kept");
    }
}

/// Lost, it may be found elsewhere, and gives back with its next step what it does not stand in: till then it must not begin to enter.
#[test]
fn a_robot_that_is_lost_enters_nothing() {
    let mut client = granted();
    assert!(client.may_be_in("1", LISTENS_FIRST_NS) && client.may_be_in("2", LISTENS_FIRST_NS));
    let lost = Situation {
        located: false,
        ..situation(&["1"], &[], &[])
    };
    client.step(lost, LISTENS_FIRST_NS, SECOND_NS);
    assert!(client.may_be_in("1", LISTENS_FIRST_NS), "where it was");
    assert!(client.holds("2") && !client.may_be_in("2", LISTENS_FIRST_NS));
    client.step(
        situation(&["1"], &["1", "2"], &[]),
        LISTENS_FIRST_NS,
        SECOND_NS,
    );
    assert!(!client.holds("2"), "given back");
}

/// It has left the area, and keeps it since it is to come back.
#[test]
fn a_robot_that_has_left_releases_what_it_keeps() {
    let mut client = granted();
    client.step(
        situation(&["2"], &["1", "2"], &[]),
        LISTENS_FIRST_NS,
        SECOND_NS,
    );
    client.step(
        situation(&["1"], &["1", "2"], &[]),
        LISTENS_FIRST_NS,
        SECOND_NS,
    );
    assert!(client.holds("2") && client.may_be_in("2", LISTENS_FIRST_NS));
    let mut told = message(3);
    told.revocations = vec![revocation(1, 5)];
    client.receive(&told, LISTENS_FIRST_NS);
    assert!(
        !client.may_be_in("2", LISTENS_FIRST_NS),
        "it does not come back"
    );
    client.step(
        situation(&["1"], &["1", "2"], &[]),
        LISTENS_FIRST_NS,
        SECOND_NS,
    );
    assert!(!client.holds("2"));
    let report = client.report();
    let progress = |own: &Access| own.level.map(|level| (level.path, level.progress));
    assert_eq!(progress(&report.revocations[0]), Some((0, 2)), "yielded");
    let access = report.access.iter().find(|access| access.area == "2");
    assert_eq!(access.and_then(progress), Some((0, 4)), "released");
}

#[test]
fn a_revocation_of_an_older_grant_takes_nothing() {
    let (client, report) = revoked(4, situation(&["1"], &["1", "2"], &[]));
    assert!(client.holds("2"));
    let answer = report.revocations[0]
        .level
        .map(|level| (level.path, level.progress));
    assert_eq!(answer, Some((0, 2)), "that one was given back before");
}

#[test]
fn grants_from_before_a_restart_are_given_back_where_it_does_not_stand() {
    let mut client = Client::new("amr-1", "corridor", 7);
    let mut told = message(1);
    told.access = vec![grant("1", 3, 1), grant("2", 2, 5), grant("3", 3, 2)];
    client.receive(&told, LISTENS_FIRST_NS);
    assert!(!client.holds("1") && !client.holds("2") && !client.holds("3"));
    client.step(
        situation(&["1"], &["1", "2", "3"], &[]),
        LISTENS_FIRST_NS,
        SECOND_NS,
    );
    assert!(client.holds("1") && !client.holds("2") && !client.holds("3"));
}

/// Inside area 1, with area 2 granted and area 3 asked for; then the robot finds itself elsewhere, though still inside area 1.
#[test]
fn a_robot_that_was_thought_elsewhere_gives_back_what_it_does_not_stand_in() {
    for is_lost in [true, false] {
        let mut client = registered();
        let now = || situation(&["1"], &["1", "2", "3"], &[]);
        client.step(now(), LISTENS_FIRST_NS, SECOND_NS);
        let mut told = message(2);
        told.access = vec![grant("1", 2, 1), grant("2", 2, 5), grant("3", 1, 0)];
        client.receive(&told, LISTENS_FIRST_NS);
        client.step(now(), LISTENS_FIRST_NS, SECOND_NS);
        assert!(client.holds("1") && client.holds("2"));
        if is_lost {
            let lost = Situation {
                located: false,
                ..Situation::default()
            };
            client.step(lost, LISTENS_FIRST_NS, SECOND_NS);
            assert!(client.holds("2"), "it may be there");
        } else {
            client.placed_anew();
        }
        client.step(now(), LISTENS_FIRST_NS, SECOND_NS);
        assert!(client.holds("1") && !client.holds("2"));
        // What it had asked for it may be granted because it seemed to stand there.
        let mut told = message(3);
        told.access = vec![grant("3", 2, 7)];
        client.receive(&told, LISTENS_FIRST_NS);
        assert!(!client.holds("3"));
        client.step(now(), LISTENS_FIRST_NS, SECOND_NS);
        assert!(!client.holds("3"));
        let report = client.report();
        let returned = { report.access.iter() }.filter(|access| {
            { access.level }.is_some_and(|level| (level.path, level.progress) == (1, 3))
        });
        let returned: Vec<&str> = returned.map(|access| access.area.as_str()).collect();
        assert_eq!(returned, ["2", "3"]);
    }
}

/// The mediator has gone on with a process that was registered elsewhere meanwhile and has forgotten everything: what rests it leaves
/// out, since that process knew it.
#[test]
fn a_robot_asks_and_answers_on_from_where_the_mediator_is() {
    let now = || situation(&["1"], &["1", "2"], &[]);
    let mut client = registered();
    client.step(now(), LISTENS_FIRST_NS, SECOND_NS);
    let resting = |run| AccessGrant {
        level: level(run, 0, 0),
        ..grant("2", 0, 0)
    };
    let run_of = |client: &mut Client| {
        let said = client.report().access;
        let own = said.iter().find(|own| own.area == "2").unwrap();
        own.level.map(|own| (own.run, own.progress))
    };
    assert_eq!(run_of(&mut client), Some((0, 1)), "it has asked");
    let mut told = message(2);
    told.access = vec![resting(3)];
    client.receive(&told, LISTENS_FIRST_NS);
    client.step(now(), LISTENS_FIRST_NS, SECOND_NS);
    assert_eq!(run_of(&mut client), Some((3, 1)), "it asks again");

    let mut told = message(3);
    told.access = vec![AccessGrant {
        level: level(3, 0, 2),
        ..grant("2", 2, 5)
    }];
    client.receive(&told, LISTENS_FIRST_NS);
    assert!(client.holds("2"));
    assert_eq!(client.counters().bad_levels, 0);
    let mut told = message(4);
    told.access = vec![resting(5)];
    client.receive(&told, LISTENS_FIRST_NS);
    assert!(client.holds("2"), "what it has it does not forget for that");
    assert_eq!(client.counters().bad_levels, 1);

    let mut told = message(5);
    told.revocations = vec![Access {
        level: level(4, 0, 1),
        ..revocation(1, 5)
    }];
    client.receive(&told, LISTENS_FIRST_NS);
    client.step(situation(&["1"], &["1"], &[]), LISTENS_FIRST_NS, SECOND_NS);
    let answer = client.report().revocations.remove(0);
    assert_eq!(
        answer.level,
        level(4, 0, 2),
        "it gives back what is asked back"
    );
    assert_eq!(client.counters().bad_levels, 1);

    // That run is over, and another one that is granted is none of which this process knows what it was asked for.
    let mut told = message(6);
    told.access = vec![AccessGrant {
        level: level(7, 0, 2),
        ..grant("2", 2, 9)
    }];
    client.receive(&told, LISTENS_FIRST_NS);
    assert!(!client.holds("2"));
    client.step(now(), LISTENS_FIRST_NS, SECOND_NS);
    let said = client.report().access;
    let own = said.iter().find(|own| own.area == "2").unwrap();
    assert_eq!(
        (own.level, own.fence),
        (level(7, 1, 3), 9),
        "it gives it back"
    );
    assert_eq!(client.counters().bad_levels, 1);
}
