//! The process that spoke for a robot before a new one.

use super::tests::said;
use super::{Change, Judged, Known, PROCESSES, Said, Seconds, Speaker};
use crate::journal::Before;

/// Spoke for the robot until now.
const SPEAKER: Speaker = Speaker {
    process: 7,
    sequence: 40,
};

#[test]
fn one_before_is_the_robot_until_that_says_where_it_stands() {
    let next = Judged::Next(Vec::new());
    let another = Judged::Another {
        process: 7,
        areas: vec![3, 4],
    };
    for (stood, stands_in, judged) in [
        (Before::Inside, &[4, 9][..], &next),
        (Before::Outside, &[3][..], &next),
        (Before::Outside, &[][..], &next),
        (Before::Inside, &[][..], &another),
        (Before::Inside, &[9][..], &another),
        (Before::Outside, &[9][..], &another),
    ] {
        let mut own = Seconds::default();
        own.note_before(SPEAKER, stood, &[3, 4]);
        let nobody_knows = Speaker {
            process: 8,
            ..SPEAKER
        };
        own.note_before(nobody_knows, stood, &[5]);
        assert!(own.areas().is_empty() && !own.robot_leaves(3));
        let mut restored = Seconds::default();
        own.found().for_each(|found| restored.restore(found, 20));
        for own in [&mut own, &mut restored] {
            assert_eq!(own.judge_before(stands_in).as_ref(), Some(judged));
            assert_eq!(own.judge_before(stands_in), None);
            let blocked: &[usize] = if *judged == next { &[] } else { &[3, 4] };
            assert_eq!(own.areas(), blocked, "{stood:?} {stands_in:?}");
            assert!(own.fall_silent(1000).is_empty(), "people were told");
            assert_eq!(own.drop_silent(1000), Change::default());
            // It wakes up, and says that it stands elsewhere.
            own.take_in(&said(7, 40, &[], 1010));
            assert_eq!(own.areas(), blocked, "these are old words");
            own.take_in(&said(7, 41, &[], 1010));
            assert!(own.areas().is_empty());
        }
    }
}

#[test]
fn one_before_that_is_heard_beside_a_new_one_is_another_one_wherever_that_stands() {
    let mut seconds = Seconds::default();
    seconds.note_before(SPEAKER, Before::Inside, &[3, 4]);
    let lives = Said {
        lives: true,
        ..said(7, 41, &[3], 50)
    };
    assert!(seconds.take_in(&lives).found);
    assert_eq!(
        (seconds.judge_before(&[3]), seconds.areas()),
        (None, vec![3])
    );
    // What one that is lost gives back it may not have left.
    let mut seconds = Seconds::default();
    seconds.note_before(SPEAKER, Before::Inside, &[3, 4]);
    assert_eq!(seconds.keep_before(|area| area == 3), [4]);
    assert_eq!(seconds.areas(), [4]);
    assert_eq!(seconds.judge_before(&[3]), Some(Judged::Next(vec![4])));
    assert!(seconds.areas().is_empty());
}

#[test]
fn one_before_among_too_many_holds_as_well() {
    let mut seconds = Seconds::default();
    for process in 11..=10 + PROCESSES as u64 {
        let found = Known::Found;
        seconds.take_in(&Said {
            known: found,
            ..said(process, 1, &[9], 10)
        });
    }
    seconds.note_before(SPEAKER, Before::Inside, &[3]);
    assert!(seconds.judge_before(&[5]).is_some());
    assert_eq!(seconds.areas(), [3, 9]);
    assert!(seconds.leave_silent(3, 11) && !seconds.are_in(3));
}
