//! How long a robot may newly enter what it was granted.

use super::*;
use crate::timing::LEASE_NS;

/// It has said since when it was stepped that it wants to go there, and has not been answered.
fn asking(at_ns: u64) -> (Client, u64) {
    let mut client = registered();
    client.step(situation(&["1"], &["1", "2"], &[]), at_ns, SECOND_NS);
    let sequence = client.report().sequence;
    (client, sequence)
}

fn granting(sequence: u64, robot_sequence: u64) -> MediatorReport {
    MediatorReport {
        access: vec![grant("1", 2, 1), grant("2", 2, 1)],
        robot_sequence,
        ..message(sequence)
    }
}

#[test]
fn a_lease_runs_from_when_the_echoed_report_was_sent() {
    let (mut client, sequence) = asking(SECOND_NS);
    let late_ns = SECOND_NS + LEASE_NS - 1;
    client.receive(&granting(2, sequence), late_ns);
    assert!(client.holds("2") && client.may_be_in("2", late_ns + 1));
    assert!(client.holds("2") && !client.may_be_in("2", late_ns + 2));
    assert!(client.may_be_in("1", u64::MAX), "it stands there");
}

#[test]
fn without_an_echo_nothing_is_entered() {
    for echoed in [0, u64::MAX] {
        let (mut client, _) = asking(0);
        client.receive(&granting(2, echoed), 1);
        assert!(client.holds("2") && !client.may_be_in("2", 1), "{echoed}");
    }
}

#[test]
fn an_earlier_echo_shortens_nothing_and_a_later_one_prolongs() {
    let (mut client, first) = asking(0);
    client.step(situation(&["1"], &["1", "2"], &[]), LEASE_NS / 2, SECOND_NS);
    let second = client.report().sequence;
    client.receive(&granting(2, second), LEASE_NS / 2);
    client.receive(&granting(3, first), LEASE_NS / 2);
    assert!(client.may_be_in("2", LEASE_NS + LEASE_NS / 2));
    assert!(!client.may_be_in("2", LEASE_NS + LEASE_NS / 2 + 1));
}

#[test]
fn another_mediator_has_to_hear_the_robot_first() {
    let mut client = Client::new("amr-1", "corridor", 7);
    let of = |instance, epoch, sequence, echoed| MediatorReport {
        instance,
        mediator_epoch: epoch,
        journal: 5,
        ..granting(sequence, echoed)
    };
    let registers = MediatorReport {
        access: Vec::new(),
        ..of(70, 1, 1, 0)
    };
    client.receive(&registers, 0);
    client.step(situation(&["1"], &["1", "2"], &[]), 0, SECOND_NS);
    let sequence = client.report().sequence;
    client.receive(&of(70, 1, 2, sequence), 0);
    assert!(client.may_be_in("2", 0));
    // The same journal: the one before is gone.
    client.receive(&of(71, 2, 1, 0), 0);
    assert!(client.holds("2") && !client.may_be_in("2", 0));
}

#[test]
fn however_often_it_reports_it_remembers_a_bounded_number() {
    let (mut client, first) = asking(0);
    let last = (0..10_000).map(|_| client.report().sequence).max();
    let (mut other, last) = (client.clone(), last.expect("reports"));
    client.receive(&granting(2, first), 0);
    assert!(!client.may_be_in("2", 0), "too long ago");
    other.receive(&granting(2, last), 0);
    assert!(other.may_be_in("2", 0));
}
