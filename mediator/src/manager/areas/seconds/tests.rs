use super::second::MOST_REPORTS;
use super::{Change, Found, Known, PROCESSES, Said, Seconds};

pub(super) fn said(process: u64, sequence: u64, areas: &[usize], until_ns: u64) -> Said<'_> {
    Said {
        process,
        sequence,
        known: Known::Nothing,
        lives: false,
        areas,
        with_robot: &[],
        until_ns,
    }
}

fn stood(process: u64, sequence: u64, areas: &[usize]) -> Found {
    Found {
        process,
        sequence,
        alone: false,
        areas: areas.to_vec(),
        ..Found::default()
    }
}

/// It is heard without a pose. Returns whether the journal must know.
fn hear(seconds: &mut Seconds, process: u64, sequence: u64, known: Known, until_ns: u64) -> bool {
    let said = Said {
        known,
        ..said(process, sequence, &[], until_ns)
    };
    seconds.hear(&said, known == Known::Found).found
}

/// It speaks for the robot. Returns the areas that it had beside it.
fn promote(seconds: &mut Seconds, process: u64, is_new: bool) -> Vec<usize> {
    seconds.promote(process, is_new).0
}

#[test]
fn what_one_process_says_ends_no_hold_of_another() {
    let mut seconds = Seconds::default();
    assert_eq!(seconds.take_in(&said(7, 1, &[3], 10)).areas, [3]);
    assert_eq!(seconds.take_in(&said(8, 1, &[3, 4], 20)).areas, [3, 4]);
    let again = seconds.take_in(&said(8, 2, &[3], 15));
    assert_eq!(again, Change::default(), "the same body");
    assert_eq!((seconds.bodies(3), seconds.bodies(4)), (2, 1));
    assert_eq!(seconds.drop_silent(10), Change::default());
    assert_eq!(seconds.drop_silent(16).areas, [3]);
    assert_eq!(seconds.areas(), [3, 4]);
    assert!(promote(&mut seconds, 9, true).is_empty());
    assert_eq!(promote(&mut seconds, 8, true), [3, 4]);
    assert!(seconds.areas().is_empty());
    seconds.take_in(&said(8, 3, &[3, 4], 20));
    seconds.leave(3);
    assert!(!seconds.are_in(3) && seconds.are_in(4));
}

#[test]
fn one_that_was_found_holds_where_it_was_heard_last() {
    let mut seconds = Seconds::default();
    seconds.take_in(&said(7, 1, &[3], 10));
    let found = |sequence, areas, until_ns| Said {
        known: Known::Found,
        ..said(7, sequence, areas, until_ns)
    };
    let change = |areas: &[usize]| Change {
        areas: areas.to_vec(),
        found: true,
    };
    assert_eq!(seconds.take_in(&found(2, &[3], 20)), change(&[]));
    assert_eq!(seconds.take_in(&found(3, &[3], 20)), Change::default());
    assert!(seconds.are_heard_in(3, 20) && !seconds.are_heard_in(3, 21));
    assert!(seconds.fall_silent(20).is_empty());
    assert_eq!(
        (seconds.fall_silent(21), seconds.fall_silent(22)),
        (vec![3], vec![])
    );
    assert!(seconds.drop_silent(1000).areas.is_empty() && seconds.are_in(3));
    assert_eq!(seconds.found().collect::<Vec<_>>(), [stood(7, 3, &[3])]);
    // A late report.
    assert_eq!(seconds.take_in(&found(2, &[5], 30)), Change::default());
    assert_eq!(seconds.take_in(&found(4, &[4], 30)), change(&[4, 3]));
    assert_eq!(seconds.take_in(&found(5, &[], 30)), change(&[4]));
    seconds.restore(stood(9, 0, &[6]), 0);
    assert!(seconds.are_in(6) && !seconds.are_heard_in(6, 1));
    assert_eq!(seconds.fall_silent(1), [6]);
    seconds.take_in(&found(6, &[6], 30));
    assert!(seconds.leave_silent(6, 30) && !seconds.leave_silent(6, 30));
    assert!(seconds.are_in(6), "one is heard there");
}

#[test]
fn invented_processes_are_one_body_more_in_each_area() {
    let mut seconds = Seconds::default();
    for process in 1..1000 {
        seconds.take_in(&said(process, 1, &[3], 10));
    }
    assert_eq!(seconds.bodies(3), PROCESSES + 1);
    assert_eq!(seconds.take_in(&said(2000, 1, &[4], 10)).areas, [4]);
    assert!((seconds.take_in(&said(2001, 1, &[4], 10)).areas).is_empty());
    // Who is gone makes room for others.
    seconds.drop_silent(11);
    assert!(seconds.areas().is_empty());
    assert_eq!(seconds.take_in(&said(2002, 1, &[3], 20)).areas, [3]);
    assert!(seconds.is_in(2002, 3));
}

#[test]
fn one_that_is_found_among_too_many_holds_as_well() {
    let mut seconds = Seconds::default();
    let found = |process, sequence, areas| Said {
        known: Known::Found,
        ..said(process, sequence, areas, 10)
    };
    for process in 1..=PROCESSES as u64 {
        seconds.take_in(&found(process, 1, &[3]));
    }
    let none = Change::default();
    assert!(!seconds.take_in(&said(20, 1, &[4], 10)).found);
    assert!(seconds.take_in(&found(21, 1, &[5])).found);
    // Of one that is not told from others nobody knows what it has left.
    assert_eq!(seconds.take_in(&found(22, 1, &[5])), none);
    assert_eq!(seconds.take_in(&found(21, 2, &[])), none);
    assert_eq!(seconds.drop_silent(11).areas, [4]);
    assert_eq!(
        (seconds.fall_silent(11), seconds.areas()),
        (vec![3, 5], vec![3, 5])
    );
    let mut restored = Seconds::default();
    seconds.found().for_each(|found| restored.restore(found, 0));
    assert!(restored.drop_silent(100).areas.is_empty());
    assert_eq!(restored.areas(), [3, 5]);
    assert!(restored.leave_silent(5, 100) && !restored.are_in(5));
}

#[test]
fn one_that_has_no_pose_when_it_is_found_is_where_it_was() {
    let mut seconds = Seconds::default();
    seconds.take_in(&said(7, 1, &[3], 10));
    assert!(!hear(&mut seconds, 7, 2, Known::Nothing, 20));
    assert!(seconds.drop_silent(15).areas.is_empty(), "it reports on");
    assert!(
        hear(&mut seconds, 7, 3, Known::Found, 20) && !hear(&mut seconds, 7, 4, Known::Found, 30)
    );
    assert!(seconds.drop_silent(1000).areas.is_empty());
    assert_eq!(seconds.found().collect::<Vec<_>>(), [stood(7, 4, &[3])]);
    // Nor one that is not told from others.
    for process in 11..10 + PROCESSES as u64 {
        seconds.take_in(&said(process, 1, &[4], 10));
    }
    assert!(
        !hear(&mut seconds, 30, 1, Known::Found, 20),
        "it was nowhere"
    );
    seconds.take_in(&said(30, 1, &[5], 10));
    assert!(hear(&mut seconds, 30, 2, Known::Found, 20) && seconds.are_heard_in(5, 20));
}

#[test]
fn a_late_report_after_a_start_moves_nobody() {
    let mut seconds = Seconds::default();
    seconds.restore(stood(7, 410, &[4]), 100);
    let late = Said {
        known: Known::Found,
        ..said(7, 400, &[3], 30)
    };
    assert_eq!(seconds.take_in(&late), Change::default());
    assert_eq!(seconds.areas(), [4]);
}

#[test]
fn one_that_reports_alone_is_where_it_is_until_another_one_is_taken_in() {
    let mut seconds = Seconds::default();
    let alone = |sequence, areas| Said {
        known: Known::Alone,
        ..said(8, sequence, areas, 10)
    };
    assert!(seconds.take_in(&alone(1, &[3])).found);
    assert!(seconds.drop_silent(1000).areas.is_empty());
    let here = Found {
        alone: true,
        ..stood(8, 1, &[3])
    };
    assert_eq!(seconds.found().next().as_ref(), Some(&here));
    let mut next = Seconds::default();
    next.restore(here, 10);
    for seconds in [&mut seconds, &mut next] {
        assert_eq!(seconds.take_in(&alone(2, &[4])).areas, [4, 3]);
        // The one that spoke for the robot before is back: it is another one.
        assert!(promote(seconds, 7, false).is_empty() && seconds.are_in(4));
        assert_eq!(seconds.drop_silent(11), Change::default());
        // It may be this one, and may be heard beside it.
        assert!(promote(seconds, 9, true).is_empty() && seconds.are_in(4));
        assert_eq!(seconds.drop_silent(10), Change::default());
        assert!(seconds.found().next().is_some());
        let gone = seconds.drop_silent(11);
        assert!(gone.areas == [4] && gone.found);
    }
    seconds.take_in(&alone(3, &[4]));
    let found = Said {
        known: Known::Found,
        ..alone(4, &[4])
    };
    seconds.take_in(&found);
    assert!(promote(&mut seconds, 9, true).is_empty());
    assert!(
        seconds.drop_silent(1000).areas.is_empty(),
        "it ran beside it"
    );
}

/// Somebody else has reported in its name.
#[test]
fn a_number_that_nobody_reaches_takes_nothing_out_of_an_area() {
    let mut seconds = Seconds::default();
    let found = |sequence, areas| Said {
        known: Known::Found,
        ..said(8, sequence, areas, 10)
    };
    seconds.take_in(&found(1, &[3]));
    seconds.take_in(&found(1 << 61, &[4]));
    assert_eq!(seconds.areas(), [3, 4]);
    seconds.take_in(&found(2, &[5]));
    assert_eq!(seconds.areas(), [5], "it is heard on");
    seconds.take_in(&found(2 + MOST_REPORTS, &[]));
    assert!(seconds.areas().is_empty());
    // Where one is that is nowhere, its late words do not say.
    let mut next = Seconds::default();
    seconds.found().for_each(|found| next.restore(found, 10));
    assert_eq!(next.take_in(&found(3, &[3])), Change::default());
}

/// The first report of one that is refused, and alone.
fn alone<'a>(areas: &'a [usize], with_robot: &'a [usize]) -> Said<'a> {
    Said {
        known: Known::Alone,
        with_robot,
        ..said(8, 1, areas, 10)
    }
}

#[test]
fn one_that_may_be_the_robot_is_a_body_more_when_the_robot_is_heard_elsewhere() {
    let mut seconds = Seconds::default();
    let alone = alone(&[3], &[4]);
    let change = seconds.take_in(&alone);
    assert!(change.areas == [3] && change.found);
    assert!(!seconds.are_in(4) && seconds.areas() == [3]);
    assert_eq!(seconds.fall_silent(11), [3]);
    let mut next = Seconds::default();
    next.restore(seconds.found().next().expect("it is known"), 20);
    for seconds in [&mut seconds, &mut next] {
        assert!(!seconds.robot_leaves(5) && !seconds.are_in(4));
        assert!(seconds.robot_leaves(4) && seconds.are_in(4));
        assert!(seconds.fall_silent(21).contains(&4));
    }
    // It says that it is elsewhere.
    let elsewhere = Said {
        with_robot: &[],
        sequence: 2,
        ..alone
    };
    assert_eq!(seconds.take_in(&elsewhere).areas, [4]);
    // Of one that is not refused nobody knows for longer than it is heard.
    let mut seconds = Seconds::default();
    seconds.take_in(&Said {
        with_robot: &[4],
        ..said(8, 1, &[], 10)
    });
    assert_eq!(seconds.drop_silent(11).areas, [4]);
    assert!(!seconds.robot_leaves(4));
}

#[test]
fn one_that_hears_what_is_said_after_a_new_one_was_taken_in_is_another_one() {
    let mut seconds = Seconds::default();
    let alone = alone(&[3], &[]);
    seconds.take_in(&alone);
    seconds.promote(9, true);
    seconds.take_in(&Said {
        lives: true,
        ..said(8, 2, &[3], 20)
    });
    assert!(seconds.drop_silent(1000).areas.is_empty() && seconds.are_found_in(3));
}

/// As long as nobody else is heard in its area it is one body with the robot, which people clear.
#[test]
fn who_clears_an_area_of_others_does_not_clear_it_of_who_may_be_the_robot() {
    let mut seconds = Seconds::default();
    seconds.take_in(&alone(&[], &[4]));
    assert!(!seconds.leave_silent(4, 11));
    assert!(seconds.robot_leaves(4) && seconds.are_in(4));
    assert!(seconds.leave_silent(4, 11) && !seconds.are_in(4));
}

/// The one that spoke for the robot before is heard again where it was: both are there.
#[test]
fn one_that_may_be_the_robot_is_another_one_when_that_is_heard_again() {
    for is_silent in [true, false] {
        let mut seconds = Seconds::default();
        seconds.take_in(&alone(&[], &[4]));
        if is_silent {
            assert_eq!(seconds.promote(7, false), (Vec::new(), vec![4]));
        } else {
            let lost = Said {
                known: Known::Found,
                ..said(8, 2, &[], 20)
            };
            let change = seconds.hear(&lost, true);
            assert!(change.areas == [4] && change.found);
        }
        assert_eq!(seconds.bodies(4), 1);
    }
}

/// The journal names it as one that is alone until it says otherwise.
#[test]
fn that_one_was_found_is_news() {
    let mut seconds = Seconds::default();
    let alone = alone(&[3], &[]);
    seconds.take_in(&alone);
    let found = Said {
        known: Known::Found,
        sequence: 2,
        ..alone
    };
    assert!(seconds.take_in(&found).found);
    let mut nowhere = Seconds::default();
    assert!(
        nowhere
            .take_in(&Said {
                areas: &[],
                ..found
            })
            .found
    );
}
