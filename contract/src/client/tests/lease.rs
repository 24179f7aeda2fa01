//! How long a robot may newly enter what it was granted.

use super::*;
use crate::timing::{LEASE_NS, LISTENS_FIRST_NS};

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
    let now_ns = LISTENS_FIRST_NS;
    client.receive(&registers, 0);
    client.step(situation(&["1"], &["1", "2"], &[]), now_ns, SECOND_NS);
    let sequence = client.report().sequence;
    client.receive(&of(70, 1, 2, sequence), now_ns);
    assert!(client.may_be_in("2", now_ns));
    // The same journal: the one before is gone.
    client.receive(&of(71, 2, 1, 0), now_ns);
    assert!(client.holds("2") && !client.may_be_in("2", now_ns));
}

#[test]
fn however_often_it_reports_it_remembers_a_bounded_number() {
    let now_ns = LISTENS_FIRST_NS;
    let (mut client, first) = asking(now_ns);
    let last = (0..10_000).map(|_| client.report().sequence).max();
    let (mut other, last) = (client.clone(), last.expect("reports"));
    client.receive(&granting(2, first), now_ns);
    assert!(!client.may_be_in("2", now_ns), "too long ago");
    other.receive(&granting(2, last), now_ns);
    assert!(other.may_be_in("2", now_ns));
}

/// A process that was registered just now may not have heard yet that another mediator speaks to it.
#[test]
fn whoever_was_just_registered_listens_first() {
    let (mut client, sequence) = asking(LISTENS_FIRST_NS / 2);
    client.receive(&granting(2, sequence), LISTENS_FIRST_NS / 2);
    assert!(client.holds("2") && !client.may_be_in("2", LISTENS_FIRST_NS - 1));
    assert!(client.may_be_in("2", LISTENS_FIRST_NS));
}

/// Each of the two may have granted it to somebody else.
#[test]
fn who_hears_two_mediators_that_grant_enters_nothing() {
    let now_ns = LISTENS_FIRST_NS;
    let leased = || {
        let (mut client, sequence) = asking(now_ns);
        client.receive(&granting(2, sequence), now_ns);
        assert!(client.may_be_in("2", now_ns));
        client
    };
    let other = MediatorReport {
        instance: 80,
        journal: 80,
        ..message(1)
    };
    let mut client = leased();
    assert_eq!(client.receive(&other, now_ns), Received::Other);
    assert!(client.holds("2") && !client.may_be_in("2", now_ns));
    assert!(client.may_be_in("1", now_ns), "it stands there");
    // One that stands by grants nothing, nor does one that has ended, of which messages are late.
    let stands_by = MediatorReport {
        stands_by: true,
        ..other.clone()
    };
    let ended = MediatorReport {
        journal: 60,
        mediator_epoch: 0,
        ..other.clone()
    };
    for harmless in [stands_by, ended] {
        let mut client = leased();
        assert_eq!(client.receive(&harmless, now_ns), Received::Other);
        assert!(client.may_be_in("2", now_ns));
    }
    // And not heard for so long it may be gone.
    let later_ns = now_ns + SECOND_NS;
    client.step(situation(&["1"], &["1", "2"], &[]), later_ns, SECOND_NS);
    let sequence = client.report().sequence;
    client.receive(&granting(3, sequence), later_ns);
    assert!(!client.may_be_in("2", later_ns));
    assert!(client.may_be_in("2", later_ns + 1));
}
