//! Whom robots follow, and who of two mediators goes on.

use super::*;

const SILENT_NS: u64 = 1_000_000_000;

fn report(instance: u64, mediator_epoch: u64, sequence: u64) -> RobotReport {
    RobotReport {
        mediator_instance: instance,
        mediator_epoch,
        mediator_heard: true,
        boot_epoch: 5,
        sequence,
        ..RobotReport::default()
    }
}

/// Two mediators hear the same robots; whether each stands by.
fn judged(follow: &[(u64, u64)], own: [(u64, u64); 2]) -> [bool; 2] {
    own.map(|(instance, epoch)| {
        let mut peers = Peers::new(instance, 6, epoch, follow.len(), SILENT_NS);
        for (robot, &(instance, epoch)) in follow.iter().enumerate() {
            peers.hear(robot, &report(instance, epoch, 1), false, 0);
        }
        peers.decide(0);
        peers.stands_by
    })
}

#[test]
fn one_of_two_stands_by_whomever_robots_follow() {
    let (one, two, later) = ((7, 1), (8, 1), (9, 2));
    assert_eq!(judged(&[one, one], [one, two]), [false, true]);
    assert_eq!(judged(&[two, two, one], [one, two]), [true, false]);
    assert_eq!(judged(&[one, two], [one, two]), [false, true]);
    assert_eq!(judged(&[one, later], [one, later]), [true, false]);
    assert_eq!(judged(&[], [one, two]), [false, false]);
}

#[test]
fn the_process_before_is_gone_but_not_that_of_a_copied_journal() {
    for (journal, epoch, stands_by) in [(6, 1, false), (9, 1, true), (0, 1, true), (6, 2, true)] {
        let mut peers = Peers::new(8, 6, 2, 1, SILENT_NS);
        let follows = RobotReport {
            mediator_journal: journal,
            ..report(7, epoch, 1)
        };
        peers.hear(0, &follows, false, 0);
        peers.decide(0);
        assert_eq!(peers.stands_by, stands_by, "{journal} {epoch}");
    }
}

#[test]
fn robots_of_the_process_before_count_for_this_one() {
    let mut peers = Peers::new(8, 3, 5, 3, SILENT_NS);
    for robot in 0..2 {
        let of_before = RobotReport {
            mediator_journal: 3,
            // One has noticed already that it is gone.
            mediator_heard: robot == 0,
            ..report(7, 4, 1)
        };
        peers.hear(robot, &of_before, false, 0);
    }
    peers.hear(2, &report(9, 1 << 40, 1), false, 0);
    peers.decide(0);
    assert!(!peers.stands_by);
    // With one of them it says otherwise.
    peers.hear(1, &report(9, 1 << 40, 2), false, 0);
    peers.decide(0);
    assert!(peers.stands_by);
}

#[test]
fn a_robot_that_another_mediator_has_refused_needs_no_larger_epoch() {
    let peers = Peers::new(8, 6, 2, 1, SILENT_NS);
    let follows = |session, mediator_journal| RobotReport {
        session,
        mediator_journal,
        mediator_heard: false,
        ..report(7, 4, 1)
    };
    assert_eq!(peers.larger_epoch(&follows(0, 9), 0), None);
    assert_eq!(peers.larger_epoch(&follows(5, 9), 0), Some(5));
    // It takes nothing older from the journal that it heard of last.
    assert_eq!(peers.larger_epoch(&follows(0, 6), 0), Some(5));
}

#[test]
fn for_one_robot_all_are_asked_once_in_a_while() {
    let mut peers = Peers::new(8, 3, 5, 2, SILENT_NS);
    assert!(peers.ask(0, 0) && peers.ask(1, 0));
    assert!(!peers.ask(0, ASK_PAUSE_NS - 1) && peers.asks(0) && !peers.asks(1));
    peers.hear(0, &report(8, 5, 1), false, ASK_PAUSE_NS - 1);
    assert!(peers.asks(0) && peers.ask(0, ASK_PAUSE_NS) && !peers.asks(0));
}

#[test]
fn it_goes_on_when_robots_hear_the_other_no_more_and_tells_once() {
    let mut peers = Peers::new(8, 6, 2, 1, SILENT_NS);
    let mut told = 0;
    for sequence in 1..=20 {
        let now_ns = sequence * SILENT_NS / 5;
        peers.hear(0, &report(7, 1, sequence), false, now_ns);
        told += u64::from(peers.decide(now_ns));
        assert!(peers.stands_by);
        assert_eq!(told, u64::from(sequence > 16));
    }
    let now_ns = 4 * SILENT_NS;
    let lost = RobotReport {
        mediator_heard: false,
        ..report(7, 1, 21)
    };
    peers.hear(0, &lost, false, now_ns);
    // Late.
    peers.hear(0, &report(7, 1, 20), false, now_ns);
    assert!(!peers.decide(now_ns) && !peers.stands_by && !peers.is_ours(&lost));
    peers.hear(0, &report(7, 1, 22), false, now_ns);
    peers.decide(now_ns);
    assert!(peers.stands_by);
    peers.decide(now_ns + SILENT_NS + 1);
    assert!(!peers.stands_by, "the robot itself is silent");
}

/// Each makes way for the robots of the other, which have not heard yet that theirs does the same: both stand by from now on.
#[test]
fn two_that_stand_by_for_each_other_do_not_go_on_together() {
    const STEP_NS: u64 = 200_000_000;
    let mut both = [1, 2].map(|instance| Peers::new(instance, instance, 7, 3, SILENT_NS));
    for peers in &mut both {
        peers.note_asked(7, 0);
    }
    let mut went_on = [None; 2];
    for sequence in 1..=40 {
        let now_ns = sequence * STEP_NS;
        for (number, peers) in both.iter_mut().enumerate() {
            for robot in 0..3 {
                // Two robots name the first one.
                let named = if robot < 2 { 1 } else { 2 };
                let report = RobotReport {
                    mediator_heard: sequence == 1,
                    ..report(named, 7, sequence)
                };
                peers.hear(robot, &report, false, now_ns);
                peers.decide(now_ns);
                if sequence == 1 {
                    peers.stands_by = true;
                }
            }
            if !peers.stands_by {
                went_on[number].get_or_insert(now_ns);
            }
        }
    }
    let [first, second] = went_on.map(|at_ns| at_ns.expect("each goes on where nobody else does"));
    assert_eq!(first, ASK_PAUSE_NS);
    assert_eq!(second, ASK_PAUSE_NS + YIELD_NS);
}
