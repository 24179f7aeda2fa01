//! Which scans are used, and what is remembered of them.

use super::stand::with_detours;
use super::stand::{AHEAD, Stand, with_disc, without_detours};
use super::world::{MS, Random, Robot, Thing, corridor, urg};
use crate::scan::{AlignedScan, ScanGeometry};
use crate::tubes::{FloorCheckpoint, MotionTubes, ObserveError, Reason, Verdict};
use description::geometry::{MotionCommand, Pose2, Twist2};

#[test]
fn scans_of_no_use_are_refused_and_counted() {
    let mut stand = Stand::ready();
    let again = stand.tubes.observe(&stand.robot.scan, stand.robot.now_ns);
    assert!(matches!(again, Err(ObserveError::NotAfter { .. })));
    let empty = AlignedScan::new(urg()).unwrap();
    assert_eq!(
        stand.tubes.observe(&empty, stand.robot.now_ns),
        Err(ObserveError::Empty)
    );
    stand.robot.drive(Twist2::default(), 0.1);
    stand.robot.measure(&corridor());
    let late = stand
        .tubes
        .observe(&stand.robot.scan, stand.robot.now_ns + 400 * MS);
    assert!(matches!(late, Err(ObserveError::NotOfNow { .. })));
    let other = ScanGeometry {
        turn_s: 0.05,
        ..urg()
    };
    let mut stranger = Robot::new(Pose2::IDENTITY, other);
    stranger.measure(&corridor());
    assert_eq!(
        stand.tubes.observe(&stranger.scan, stranger.now_ns),
        Err(ObserveError::Geometry)
    );
    assert_eq!(stand.tubes.counters().refused, 4);
    // A source that repeats itself keeps nothing alive.
    assert_eq!(stand.ask(AHEAD, 300).reason, Reason::NoScan);
}

#[test]
fn what_stood_beside_it_is_remembered_while_it_waits() {
    let turn = MotionCommand::new(0.3, 2.0);
    let arrive_and_wait = |things: &[Thing]| {
        let mut stand = Stand::new(without_detours());
        stand.robot = Robot::new(Pose2::new(2.2, -0.5, 0.0), urg());
        stand.twist = Twist2::new(0.4, 0.0);
        stand.look(things, AHEAD, 2.0);
        stand.twist = Twist2::default();
        *stand.look(things, turn, 60.0).last().unwrap()
    };
    // A post that comes to stand beside the left wheel, out of view.
    let post = arrive_and_wait(&with_disc(3.08, -0.5 + 0.15 + 0.05, 0.03));
    assert_eq!(
        (post.verdict, post.reason),
        (Verdict::Stopped, Reason::Blocked)
    );
    assert_eq!(arrive_and_wait(&corridor()).verdict, Verdict::Free);
}

#[test]
fn what_it_left_two_seconds_behind_is_forgotten() {
    let mut stand = Stand::ready();
    stand.look(&with_disc(3.6, -0.1, 0.1), AHEAD, 0.5);
    let remembered = stand.tubes.memory().len();
    stand.twist = Twist2::new(0.4, 0.0);
    stand.look(&[], AHEAD, 1.5);
    assert!(stand.tubes.memory().len() >= remembered);
    stand.look(&[], AHEAD, 1.0);
    assert!(stand.tubes.memory().is_empty());
}

#[test]
fn what_a_new_scan_looks_through_is_forgotten() {
    let mut stand = Stand::ready();
    // Someone beside the front, in view, who then leaves.
    stand.look(&with_disc(3.35, -0.5 + 0.22, 0.05), AHEAD, 0.5);
    let with_them = stand
        .tubes
        .memory()
        .occupied()
        .iter()
        .map(|w| w.count_ones())
        .sum::<u32>();
    stand.look(&corridor(), AHEAD, 0.2);
    let without = stand
        .tubes
        .memory()
        .occupied()
        .iter()
        .map(|w| w.count_ones())
        .sum::<u32>();
    assert!(with_them > 0 && without == 0, "{with_them} {without}");
}

#[test]
fn memory_is_bounded() {
    let mut stand = Stand::new(with_detours());
    let random = &mut Random(2);
    stand.twist = Twist2::new(0.01, 0.0);
    for _ in 0..200 {
        stand.robot.drive(Twist2::new(0.06, 0.0), 0.1);
        // Ranges all over the place, so that nothing thins them out.
        let raw: Vec<u16> = (0..682)
            .map(|_| random.between(200.0, 1400.0) as u16)
            .collect();
        let stamp_ns = stand.robot.now_ns - urg().duration_ns();
        stand
            .robot
            .scan
            .align(&raw, stamp_ns, &stand.robot.history)
            .unwrap();
        stand
            .tubes
            .observe(&stand.robot.scan, stand.robot.now_ns)
            .unwrap();
        assert!(stand.tubes.memory().len() <= crate::tubes::memory::seen::CAPACITY);
    }
    assert!(stand.tubes.memory().overwritten() > 0);
}

/// Drives in beside a post, out of view at the end, and waits.
fn beside_a_post() -> Stand {
    let mut stand = Stand::new(without_detours());
    stand.robot = Robot::new(Pose2::new(2.2, -0.5, 0.0), urg());
    stand.twist = Twist2::new(0.4, 0.0);
    stand.look(&post(), AHEAD, 2.0);
    stand.twist = Twist2::default();
    stand
}

fn post() -> Vec<Thing> {
    with_disc(3.08, -0.5 + 0.15 + 0.05, 0.03)
}

#[test]
fn other_tubes_go_on_with_what_stood_beside_it_and_with_the_floor_behind_it() {
    let (turn, back) = (MotionCommand::new(0.3, 2.0), MotionCommand::new(-0.1, 0.0));
    let before = beside_a_post();
    let mut left = FloorCheckpoint::default();
    before.tubes.save(&mut left);
    assert!(left.cell_m > 0.0);
    type Begins = fn(&mut MotionTubes, &FloorCheckpoint);
    let begins: [(Begins, Verdict, Verdict); 3] = [
        (
            |tubes, left| assert!(tubes.resume(left)),
            Verdict::Stopped,
            Verdict::Free,
        ),
        // Who put it down there has looked beside it, not behind it.
        (|_, _| (), Verdict::Free, Verdict::Stopped),
        // Nobody has.
        (
            |tubes, _| tubes.assume_nothing(),
            Verdict::Stopped,
            Verdict::Stopped,
        ),
    ];
    for (begins, beside, behind) in begins {
        let mut after = beside_a_post();
        after.tubes = Stand::new(without_detours()).tubes;
        begins(&mut after.tubes, &left);
        let last = *after.look(&post(), turn, 3.0).last().unwrap();
        assert_eq!(last.verdict, beside, "{last:?}");
        let last = *after.look(&post(), back, 3.0).last().unwrap();
        assert_eq!(last.verdict, behind, "{last:?}");
    }
}

#[test]
fn the_floor_of_another_kind_of_robot_is_not_used() {
    let mut left = FloorCheckpoint::default();
    let mut tubes = Stand::new(without_detours()).tubes;
    tubes.save(&mut left);
    assert!(!tubes.resume(&left), "nothing was seen");
    beside_a_post().tubes.save(&mut left);
    let (mut odd, mut nowhere) = (left, left);
    odd.cell_m = 0.04;
    nowhere.pose.x_m = f64::NAN;
    assert!(!tubes.resume(&odd) && !tubes.resume(&nowhere));
    assert!(tubes.resume(&left));
}

/// Tubes that know nothing, beside these things; whether it may back out, before and after somebody has said so.
fn backs_out(things: &[Thing], way_m: f64) -> [bool; 2] {
    let back = MotionCommand::new(-0.1, 0.0);
    let mut stand = Stand::new(without_detours());
    let mut may = |trusted_m: f64| {
        stand.tubes.trust_behind(trusted_m);
        let last = *stand.look(things, back, 3.0).last().unwrap();
        last.verdict != Verdict::Stopped
    };
    [may(0.0), may(way_m)]
}

#[test]
fn the_floor_behind_is_free_when_somebody_says_so() {
    assert_eq!(backs_out(&corridor(), 1.0), [false, true]);
    for way_m in [0.0, -1.0, 0.05, f64::NAN] {
        assert_eq!(backs_out(&corridor(), way_m), [false, false], "{way_m}");
    }
}

#[test]
fn what_somebody_said_is_void_when_the_robot_is_put_elsewhere_or_has_driven_on() {
    let back = MotionCommand::new(-0.1, 0.0);
    let mut stand = Stand::ready();
    stand.tubes.trust_behind(1.0);
    stand.tubes.reset();
    let last = *stand.look(&corridor(), back, 3.0).last().unwrap();
    assert_eq!(last.verdict, Verdict::Stopped);
    stand.tubes.trust_behind(0.5);
    stand.look(&corridor(), back, 3.0);
    stand.twist = Twist2::new(-0.1, 0.0);
    let backed = stand.look(&corridor(), back, 10.0);
    let free = backed
        .iter()
        .take_while(|one| one.verdict != Verdict::Stopped);
    let way_m = free.count() as f64 * 0.1 * 0.1;
    assert!(way_m > 0.1 && way_m < 0.5, "{way_m} m");
}

#[test]
fn other_tubes_know_the_floor_behind_as_far_as_the_first_did() {
    let back = MotionCommand::new(-0.1, 0.0);
    let drive_back = |resumes: bool| {
        let mut stand = Stand::new(without_detours());
        stand.robot = Robot::new(Pose2::new(2.2, -0.5, 0.003), urg());
        stand.twist = Twist2::new(0.15, 0.0);
        stand.look(&corridor(), AHEAD, 10.0);
        stand.twist = Twist2::default();
        if resumes {
            let mut left = FloorCheckpoint::default();
            stand.tubes.save(&mut left);
            stand.tubes = Stand::new(without_detours()).tubes;
            assert!(stand.tubes.resume(&left));
        }
        stand.look(&corridor(), back, 4.0);
        stand.twist = Twist2::new(-0.1, 0.0);
        let backed = stand.look(&corridor(), back, 20.0);
        let free = backed
            .iter()
            .take_while(|one| one.verdict != Verdict::Stopped);
        free.count()
    };
    let (before, after) = (drive_back(false), drive_back(true));
    assert!(before > 60, "{before}");
    assert!(after.abs_diff(before) <= 1, "{before}, then {after}");
}

#[test]
fn after_thousands_of_kilometres_floor_is_still_forgotten_and_known_again() {
    let mut stand = Stand::ready();
    for ahead in [true, false, true, false, true, false] {
        let speed_m_s = if ahead { 9e5 } else { -9e5 };
        // As long a time as such a way takes, so that it is no jump.
        stand.robot.now_ns += 2_000_000_000 * MS;
        stand.robot.drive(Twist2::new(speed_m_s, 0.0), 1.0);
        stand.robot.measure(&corridor());
        let seen = stand.tubes.observe(&stand.robot.scan, stand.robot.now_ns);
        assert!(seen.is_ok(), "{seen:?}");
    }
    assert_eq!(stand.tubes.counters().jumps, 0);
    for _ in 0..30 {
        stand.robot.drive(Twist2::default(), 0.1);
        stand.robot.measure(&corridor());
        let seen = stand.tubes.observe(&stand.robot.scan, stand.robot.now_ns);
        assert!(seen.is_ok(), "{seen:?}");
    }
    assert_eq!(stand.ask(AHEAD, 10).verdict, Verdict::Free);
}
