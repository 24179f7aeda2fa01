//! A robot that hears two mediators.

use super::*;

/// Of another process than the one that registered the robot.
fn other(instance: u64, mediator_epoch: u64, sequence: u64) -> MediatorReport {
    MediatorReport {
        instance,
        mediator_epoch,
        ..message(sequence)
    }
}

#[test]
fn a_robot_stays_with_its_mediator_while_it_hears_it_and_says_whom_it_follows() {
    let mut client = Client::new("amr-1", "corridor", 7);
    let now = || situation(&["1"], &["1"], &[]);
    client.receive(&other(70, 1, 1), 0);
    client.step(now(), 0, SECOND_NS);
    let mut granting = other(80, 1, 100);
    granting.access = vec![grant("1", 2, 1)];
    for sequence in 2..25 {
        let now_ns = sequence * SECOND_NS / 5;
        client.receive(&other(70, 1, sequence), now_ns);
        assert_eq!(client.receive(&granting, now_ns), Received::Other);
        client.step(now(), now_ns, SECOND_NS);
        // For so long it may be one that has restarted.
        assert_eq!(
            client.has_second_mediator(now_ns),
            sequence > 17,
            "{sequence}"
        );
    }
    let report = client.report();
    assert!(!client.holds("1") && report.mediator_instance == 70 && report.mediator_heard);
    // Silent: only a mediator that has started later is followed.
    let silent_ns = 7 * SECOND_NS;
    assert!(client.step(now(), silent_ns, SECOND_NS), "news for others");
    assert!(!client.report().mediator_heard);
    assert_eq!(
        client.receive(&other(80, 1, 200), silent_ns),
        Received::Other
    );
    assert_eq!(client.receive(&other(90, 2, 1), silent_ns), Received::News);
    let report = client.report();
    assert_eq!((report.mediator_instance, report.mediator_epoch), (90, 2));
    assert!(!client.has_second_mediator(silent_ns));
    assert_eq!(
        client.receive(&other(70, 1, 300), silent_ns),
        Received::Other
    );
}

#[test]
fn a_mediator_that_stands_by_is_not_followed_and_lets_its_robots_go() {
    let mut client = Client::new("amr-1", "corridor", 7);
    let standing_by = MediatorReport {
        stands_by: true,
        session: 0,
        refusal: "it stands by".into(),
        ..other(80, 9, 9)
    };
    assert_eq!(client.receive(&standing_by, 0), Received::Refused);
    assert_eq!(client.receive(&other(70, 2, 1), 0), Received::Registered);
    assert_eq!(client.receive(&standing_by, 0), Received::Other);
    let mut told = other(70, 2, 2);
    told.stands_by = true;
    assert_eq!(client.receive(&told, 0), Received::News);
    assert!(!client.report().mediator_heard);
    assert_eq!(client.receive(&standing_by, 0), Received::Other);
    assert_eq!(
        client.receive(&other(50, 1, 1), 0),
        Received::Other,
        "it knew less"
    );
    assert_eq!(client.receive(&other(60, 2, 1), 0), Received::Registered);
    assert_eq!(client.report().mediator_instance, 60);
}
