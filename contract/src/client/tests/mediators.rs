//! A robot that hears two mediators.

use super::*;

/// Of another process than the one that registered the robot.
fn other(instance: u64, mediator_epoch: u64, sequence: u64) -> MediatorReport {
    MediatorReport {
        instance,
        journal: instance,
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
    let mut client = owner();
    let mut told = other(70, 2, 3);
    told.stands_by = true;
    assert_eq!(client.receive(&told, 0), Received::News);
    assert!(!client.report().mediator_heard);
    assert_eq!(client.receive(&standing_by, 0), Received::Other);
    assert_eq!(
        client.receive(&other(50, 1, 1), 0),
        Received::Other,
        "it knew less"
    );
    // It need not know this robot, which tells it what it has.
    let knows_little = MediatorReport {
        session: 5,
        ..other(60, 2, 1)
    };
    assert_eq!(client.receive(&knows_little, 0), Received::News);
    let report = client.report();
    assert_eq!((report.mediator_instance, report.session), (60, 5));
    assert!(client.holds("1") && report.access[0].fence == 3);
}

/// A client that has area 1 from mediator 70, epoch 2, journal 6.
fn owner() -> Client {
    let mut client = Client::new("amr-1", "corridor", 7);
    let with = |sequence: u64, access: Vec<AccessGrant>| MediatorReport {
        journal: 6,
        access,
        ..other(70, 2, sequence)
    };
    client.receive(&with(1, Vec::new()), 0);
    client.step(situation(&[], &["1"], &[]), 0, SECOND_NS);
    client.receive(&with(2, vec![grant("1", 2, 3)]), 0);
    assert!(client.holds("1") && client.report().mediator_journal == 6);
    client
}

#[test]
fn a_mediator_that_has_restarted_with_its_journal_is_followed_at_once() {
    let of = |journal: u64, mediator_epoch: u64| MediatorReport {
        journal,
        ..other(80, mediator_epoch, 1)
    };
    for (message, received) in [
        (of(6, 3), Received::News),
        (of(6, 2), Received::Other),
        (of(9, 3), Received::Other),
        (of(0, 3), Received::Nonsense),
    ] {
        let mut client = owner();
        assert_eq!(client.receive(&message, 1), received, "{message:?}");
        assert!(client.holds("1"));
    }
}

#[test]
fn a_mediator_that_knows_a_process_before_only_is_told_what_that_one_had() {
    let elsewhere = || situation(&[], &["2"], &[]);
    // The second one counts sessions as the first does, or has come to another number.
    for session in [1, 4] {
        let mut client = Client::new("amr-1", "corridor", 7);
        // It has just started, and a spare mediator takes it in.
        client.receive(&other(70, 1, 1), 0);
        client.step(elsewhere(), 0, SECOND_NS);
        let silent_ns = 2 * SECOND_NS;
        let knows_the_one_before = MediatorReport {
            session,
            access: vec![grant("1", 3, 5), grant("2", 0, 0)],
            ..other(90, 2, 1)
        };
        let received = client.receive(&knows_the_one_before, silent_ns);
        assert_eq!(received, Received::News);
        // It does not stand there, so that it gives back what the process before has entered.
        client.step(elsewhere(), silent_ns, SECOND_NS);
        let report = client.report();
        let said = { report.access.iter() }.find(|own| own.area == "1");
        let level = said.and_then(|own| own.level.as_ref());
        assert_eq!(level.map(|level| level.progress), Some(4), "{session}");
        assert_eq!(report.session, session);
        assert_eq!(client.counters().bad_levels, 0, "{session}");
    }
    // Only whom it follows anew may know more of it than it does itself.
    let mut client = owner();
    let claims = MediatorReport {
        access: vec![grant("3", 3, 5)],
        ..other(70, 2, 30)
    };
    client.receive(&claims, 0);
    assert!(client.holds("1") && !client.holds("3"));
    assert_eq!(client.counters().bad_levels, 1);
}

#[test]
fn a_robot_that_was_refused_takes_whichever_mediator_registers_it_and_is_not_torn_between_refusals()
{
    let refusal = |instance: u64, sequence: u64| MediatorReport {
        session: 0,
        refusal: "another site".into(),
        ..other(instance, 9, sequence)
    };
    let mut client = Client::new("amr-1", "corridor", 7);
    assert_eq!(client.receive(&refusal(80, 1), 0), Received::Refused);
    assert_eq!(client.receive(&refusal(90, 1), 1), Received::Other);
    assert_eq!(client.receive(&refusal(80, 2), 2), Received::Refused);
    let silent_ns = 2 * SECOND_NS;
    let refused = client.receive(&refusal(90, 2), silent_ns);
    assert_eq!(refused, Received::Refused);
    // Started less often than those.
    let registered = client.receive(&other(70, 2, 1), silent_ns);
    assert_eq!(registered, Received::Registered);
    assert_eq!(client.report().mediator_instance, 70);
    let refused = client.receive(&refusal(90, 3), silent_ns);
    assert_eq!(refused, Received::Other);
}

/// That mediator leaves out what this process has told it before, and has forgotten when it was refused.
#[test]
fn a_robot_that_was_refused_is_not_taken_in_by_a_late_message_of_the_mediator_before() {
    let of = |instance: u64, mediator_epoch: u64, sequence: u64| MediatorReport {
        journal: 6,
        ..other(instance, mediator_epoch, sequence)
    };
    let mut client = owner();
    let refusal = MediatorReport {
        session: 0,
        identity_taken: true,
        ..of(80, 3, 1)
    };
    assert_eq!(client.receive(&refusal, 0), Received::Refused);
    assert_eq!(client.receive(&of(70, 2, 3), 0), Received::Other);
    assert_eq!(client.receive(&of(80, 3, 2), 0), Received::Registered);
}

#[test]
fn one_that_goes_on_with_its_journal_does_not_leap_away_either() {
    let of = |instance: u64, mediator_epoch: u64| MediatorReport {
        journal: 6,
        ..other(instance, mediator_epoch, 1)
    };
    let mut client = Client::new("amr-1", "corridor", 7);
    client.receive(&of(70, 2), 0);
    let leap = client.receive(&of(80, 3 + EPOCH_STEP), 1);
    assert_eq!(leap, Received::Nonsense);
    assert_eq!(client.report().mediator_instance, 70);
    assert_eq!(client.receive(&of(80, 2 + EPOCH_STEP), 2), Received::News);
    // Of one that is gone nobody knows how often it has started meanwhile.
    let silent_ns = 2 * SECOND_NS;
    client.step(situation(&[], &[], &[]), silent_ns, SECOND_NS);
    let after = of(90, 9 * EPOCH_STEP);
    assert_eq!(client.receive(&after, silent_ns), Received::News);
}

/// Somebody has sent reports in its name, which made its own ones old.
#[test]
fn a_robot_goes_on_from_the_number_that_its_mediator_has_heard() {
    let echo = |sequence: u64, robot_sequence: u64| MediatorReport {
        robot_sequence,
        ..message(sequence)
    };
    let mut client = Client::new("amr-1", "corridor", 7);
    client.receive(&echo(1, 0), 0);
    let own = client.report().sequence;
    client.receive(&echo(2, own + 500), 1);
    assert!(!client.has_lease(1));
    assert_eq!(client.report().sequence, own + 501);
    client.receive(&echo(3, own + 501), 2);
    assert!(client.has_lease(SECOND_NS));
    // A larger lie leaves room for those that follow,
    client.receive(&echo(4, LAST_NUMBER / 2), 3);
    assert_eq!(client.report().sequence, LAST_NUMBER / 2 + 1);
    // and one that does not is none that it has sent.
    client.receive(&echo(5, LAST_NUMBER / 2 + 2 + SEQUENCE_STEP), 4);
    assert_eq!(client.report().sequence, LAST_NUMBER / 2 + 2);
}

#[test]
fn several_other_mediators_that_take_turns_are_noticed_too() {
    let mut client = owner();
    for step in 0..20 {
        let now_ns = step * SECOND_NS / 5;
        client.receive(&other(80 + step % 2, 1, step), now_ns);
    }
    assert!(client.has_second_mediator(19 * SECOND_NS / 5));
}

#[test]
fn a_made_up_epoch_does_not_mute_the_mediator() {
    let mut client = Client::new("amr-1", "corridor", 7);
    client.receive(&other(70, 3, 1), 0);
    for (instance, epoch) in [(70, u64::MAX), (70, 1 << 40), (80, u64::MAX)] {
        let forged = other(instance, epoch, 9);
        assert_ne!(client.receive(&forged, 1), Received::News);
    }
    let forged = other(70, 3, u64::MAX);
    assert_eq!(client.receive(&forged, 1), Received::Nonsense);
    assert_eq!(client.counters().nonsense, 4);
    assert_eq!(client.receive(&other(70, 3, 2), 2), Received::News);
    // A small lie is believed, and said: a mediator that hears of it takes a larger one.
    assert_eq!(client.receive(&other(70, 900, 9), 3), Received::News);
    assert_eq!(client.report().mediator_epoch, 900);
    assert_eq!(client.receive(&other(70, 3, 10), 4), Received::Stale);
    assert_eq!(client.receive(&other(70, 901, 11), 5), Received::News);
}

/// Whoever follows it would take every other mediator for the same one.
#[test]
fn a_mediator_without_a_number_of_its_own_is_none() {
    let nameless = other(0, 1, 1);
    let without_journal = MediatorReport {
        journal: 0,
        ..other(70, 1, 1)
    };
    let mut client = Client::new("amr-1", "corridor", 7);
    for message in [&nameless, &without_journal] {
        assert_eq!(client.receive(message, 0), Received::Nonsense);
        assert!(!client.is_registered());
    }
    assert_eq!(client.counters().nonsense, 2);
    assert_eq!(client.receive(&other(70, 1, 2), 0), Received::Registered);
}

/// Its mediator would not know that it has forgotten what was left out of messages.
#[test]
fn a_registered_robot_takes_no_refusal_of_a_mediator_that_has_another_journal() {
    let mut client = owner();
    let silent_ns = 2 * SECOND_NS;
    let refusal = |journal: u64| MediatorReport {
        session: 0,
        identity_taken: true,
        journal,
        ..other(80, 3, 1)
    };
    assert_eq!(client.receive(&refusal(9), silent_ns), Received::Other);
    assert!(client.holds("1") && client.report().session != 0);
    // It is followed once it offers a session; one with the journal of its mediator speaks for that.
    let offer = MediatorReport {
        journal: 9,
        ..other(80, 3, 2)
    };
    assert_eq!(client.receive(&offer, silent_ns), Received::News);
    let mut client = owner();
    assert_eq!(client.receive(&refusal(6), silent_ns), Received::Refused);
    assert!(!client.holds("1"));
}

/// A robot that was refused by the one after it would begin anew with words of before, one after the other.
#[test]
fn late_messages_of_a_mediator_that_was_followed_before_are_ignored() {
    let mut client = Client::new("amr-1", "corridor", 7);
    let now = || situation(&["1"], &["1", "2"], &[]);
    let said = |sequence| MediatorReport {
        access: vec![grant("1", 3, 4)],
        ..other(70, 1, sequence)
    };
    for sequence in [1, 20] {
        client.receive(&said(sequence), 0);
    }
    client.step(now(), 0, SECOND_NS);
    let silent_ns = 2 * SECOND_NS;
    let followed = client.receive(&other(80, 2, 1), silent_ns);
    assert_eq!(followed, Received::News);
    let refuses = MediatorReport {
        session: 0,
        refusal: "not now".into(),
        ..other(80, 2, 2)
    };
    assert_eq!(client.receive(&refuses, silent_ns), Received::Refused);
    for sequence in [5, 19, 20] {
        assert_eq!(
            client.receive(&said(sequence), silent_ns),
            Received::Stale,
            "{sequence}"
        );
    }
    assert_eq!(client.receive(&said(21), silent_ns), Received::Registered);
}
