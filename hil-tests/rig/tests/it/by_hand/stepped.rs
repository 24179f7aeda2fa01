//! Somebody drives the robot by hand: judged by where it truly is.

use description::geometry::Pose2;
use onboard::process::ctl::{FreeBehind, Place, Refusal, Request, Spot, Teleop};
use onboard::process::teleop::Over;
use onboard::symbols::faults::Fault;
use sim::world::{Pose, Shape};
use skills::tubes::Reason;

use crate::stepped::bench::Bench;

const LANE_Y_M: f64 = -0.5;
/// The robot's front is this far ahead of `base_link`.
const FRONT_M: f64 = 0.32;
/// Slower than this it stands.
const STANDING_M_S: f64 = 0.01;
/// From the last wish until it stands: deadline, a cycle of navigation, and braking from the speed of teleoperation.
const SILENT_STOP_S: f64 = 0.25 + 0.05 + 0.35;
/// The same, when somebody says that nothing is wanted, or the connection closes.
const TOLD_STOP_S: f64 = 0.05 + 0.35;

fn block(x_m: f64, y_m: f64) -> Shape {
    Shape::Box {
        pose: Pose::new(x_m, y_m, 0.0),
        length_m: 0.2,
        width_m: 0.3,
    }
}

/// Whoever has it in hands drives it, and leaves.
fn is_driven_and_left(bench: &mut Bench) {
    bench.desk().want(0.0, 0.0);
    bench.watch(0.2);
    bench.desk().want(0.1, 0.0);
    bench.until("it is driven", 3.0, |bench| {
        bench.truth().twist.v_m_s > 0.05
    });
    let now_ns = bench.now_ns;
    bench.desk().leave(now_ns);
    bench.until_standing(1.0);
}

/// Takes the robot into somebody's hands.
fn take(bench: &mut Bench) {
    bench.ask(Request::Teleop(Teleop::default()));
    bench.until("it is in hands", 1.0, |bench| bench.desk().is_taken());
}

fn limit(bench: &mut Bench) -> String {
    let status = bench.desk().status().expect("it was told");
    status.limit.clone()
}

/// Drives to a place as a person does who sees it: on the curve that leads there.
fn drive_to(bench: &mut Bench, [x_m, y_m]: [f64; 2], speed_m_s: f64, patience_s: f64) {
    let mut looks = 0u32;
    bench.until("it is there", patience_s, |bench| {
        let pose = bench.truth().pose;
        let (sin, cos) = pose.theta_rad.sin_cos();
        let (off_x_m, off_y_m) = (x_m - pose.x_m, y_m - pose.y_m);
        let (ahead_m, left_m) = (off_x_m * cos + off_y_m * sin, off_y_m * cos - off_x_m * sin);
        let way_m = ahead_m.hypot(left_m);
        if looks.is_multiple_of(100) {
            let curve_1_m = (2.0 * left_m / (way_m * way_m)).clamp(-2.5, 2.5);
            let forward_m_s = speed_m_s * ahead_m.signum();
            bench.desk().want(forward_m_s, forward_m_s * curve_1_m);
        }
        looks += 1;
        way_m < 0.1
    });
    bench.desk().want(0.0, 0.0);
}

/// It drives by hand, straight ahead.
fn driven() -> Bench {
    let mut bench = Bench::driving();
    take(&mut bench);
    bench.until_standing(2.0);
    bench.desk().want(0.2, 0.0);
    bench.until("it is driven", 3.0, |bench| {
        bench.truth().twist.v_m_s > 0.18
    });
    bench
}

/// How long it took to stand, and how far it went.
fn stopping(bench: &mut Bench) -> (f64, f64) {
    let (began_ns, before_m) = (bench.now_ns, bench.truth().distance_m);
    bench.until("it stands", 3.0, |bench| {
        bench.truth().twist.v_m_s.abs() < STANDING_M_S
    });
    let took_s = (bench.now_ns - began_ns) as f64 / 1e9;
    (took_s, bench.truth().distance_m - before_m)
}

#[test]
fn a_robot_that_is_stuck_before_a_thing_is_driven_around_it_and_goes_on_by_itself() {
    let start = Pose::new(2.0, LANE_Y_M, 0.0);
    let mut bench = Bench::new(start, 0.0, &[block(4.0, LANE_Y_M)], &[]);
    bench.until_raised(Fault::NoFreeTube, 30.0);
    bench.until_standing(3.0);
    bench.stands_for(5.0);
    take(&mut bench);
    bench.stands_for(1.0);
    let stuck = bench.truth().pose;
    drive_to(&mut bench, [stuck.x_m - 0.8, LANE_Y_M], 0.1, 20.0);
    for place in [[3.3, 0.1], [4.2, 0.15], [5.0, LANE_Y_M + 0.1]] {
        drive_to(&mut bench, place, 0.2, 30.0);
    }
    let now_ns = bench.now_ns;
    bench.desk().leave(now_ns);
    bench.until_standing(1.0);
    // It does not go on before somebody says so.
    bench.stands_for(3.0);
    assert_eq!(bench.belief().state, "drive-1");
    bench.ask(Request::Resume);
    bench.until_driving();
    let goes_on = bench.run(30, |_, world| {
        let pose = world.truth(0).expect("a robot").pose;
        pose.x_m > 6.5 && (pose.y_m - LANE_Y_M).abs() < 0.05
    });
    assert!(goes_on, "{:?}", bench.truth());
    assert_eq!(bench.refused(), [""; 0]);
    bench.finish();
}

#[test]
fn it_backs_up_over_floor_that_it_knows_or_that_somebody_sees() {
    // Switched on with its nose to a thing: it has seen nothing of what is behind it.
    let start = Pose::new(2.0, LANE_Y_M, 0.0);
    let thing = block(2.0 + FRONT_M + 0.2, LANE_Y_M);
    let mut bench = Bench::new(start, 0.0, &[thing], &[]);
    bench.watch(4.0);
    take(&mut bench);
    bench.desk().want(-0.1, 0.0);
    bench.stands_for(4.0);
    let why = limit(&mut bench);
    assert!(why.contains("free-behind"), "{why}");
    bench.desk().want(0.0, 0.0);
    bench.ask(Request::FreeBehind(FreeBehind { way_m: 1.0 }));
    bench.watch(0.3);
    bench.desk().want(-0.1, 0.0);
    bench.until("it backs up", 10.0, |bench| bench.truth().pose.x_m < 1.5);
    assert_eq!(bench.refused(), [""; 0]);
    bench.finish();
}

#[test]
fn it_stops_when_the_dead_man_is_let_go() {
    let mut bench = driven();
    bench.desk().want(0.0, 0.0);
    let (took_s, way_m) = stopping(&mut bench);
    assert!(
        took_s < TOLD_STOP_S && way_m < 0.06,
        "{took_s} s, {way_m} m"
    );
    bench.stands_for(2.0);
    // And is driven on when it is held again.
    bench.desk().want(0.2, 0.0);
    bench.until("it is driven", 3.0, |bench| {
        bench.truth().twist.v_m_s > 0.18
    });
    bench.finish();
}

#[test]
fn it_stops_when_the_connection_closes() {
    let mut bench = driven();
    let now_ns = bench.now_ns;
    bench.desk().leave(now_ns);
    let (took_s, way_m) = stopping(&mut bench);
    assert!(
        took_s < TOLD_STOP_S && way_m < 0.06,
        "{took_s} s, {way_m} m"
    );
    bench.stands_for(5.0);
    bench.finish();
}

#[test]
fn it_stops_when_no_wish_comes_any_more_and_takes_itself_back() {
    let mut bench = driven();
    bench.desk().fall_silent(true);
    let (took_s, way_m) = stopping(&mut bench);
    assert!(
        took_s < SILENT_STOP_S && way_m < 0.11,
        "{took_s} s, {way_m} m"
    );
    bench.stands_for(6.0);
    assert_eq!(bench.desk().over(), Some(&Over::Silent));
    // It waits for somebody to send it on.
    bench.ask(Request::Resume);
    bench.until_driving();
    bench.finish();
}

#[test]
fn it_stops_when_the_desk_or_the_supervisor_hangs() {
    for (hung, within_s) in [("teleop", SILENT_STOP_S), ("supervisor", 1.5)] {
        let mut bench = driven();
        bench.hang(&[hung]);
        let (took_s, _) = stopping(&mut bench);
        assert!(took_s < within_s, "{hung}: {took_s} s");
        bench.stands_for(3.0);
        bench.finish();
    }
}

#[test]
fn a_wall_or_a_person_stops_it_by_the_tubes() {
    let mut bench = driven();
    // A wall.
    let wall = bench.ahead(1.5);
    bench.add(Shape::Box {
        pose: Pose::new(wall.x_m, 0.0, 0.0),
        length_m: 0.1,
        width_m: 3.2,
    });
    bench.until_standing(15.0);
    bench.stands_for(6.0);
    let gap_m = wall.x_m - 0.05 - FRONT_M - bench.truth().pose.x_m;
    assert!((0.02..0.5).contains(&gap_m), "{gap_m} m left");
    let why = limit(&mut bench);
    assert!(why.starts_with("tube: "), "{why}");
    // Backward it may go at once: who drives has seen the wall.
    bench.desk().want(-0.1, 0.0);
    bench.until("it backs up", 1.0, |bench| {
        bench.truth().twist.v_m_s < -0.05
    });
    // A person right in front of it.
    let mut bench = driven();
    let person = bench.ahead(FRONT_M + 0.45);
    bench.add(Shape::Disc {
        centre_m: [person.x_m, person.y_m],
        radius_m: 0.15,
    });
    bench.until_standing(8.0);
    bench.stands_for(3.0);
    assert!(limit(&mut bench).starts_with("tube: "));
    bench.finish();
}

#[test]
fn it_stops_before_an_area_without_leave_and_goes_in_when_there_is_leave() {
    // Area 2 begins at 5.5 m.
    let mut bench = Bench::allowed(Pose::new(4.0, LANE_Y_M, 0.0), 1);
    bench.watch(4.0);
    take(&mut bench);
    for curve_1_m in [0.0, 0.1, -0.1] {
        bench.desk().want(0.2, 0.2 * curve_1_m);
        for truth in bench.watch(8.0) {
            assert!(truth.pose.x_m + FRONT_M < 5.5, "{truth:?}");
        }
    }
    bench.stands_for(1.0);
    let why = limit(&mut bench);
    assert!(why.starts_with("border: ") && why.contains("`2`"), "{why}");
    bench.allow(2);
    bench.desk().want(0.2, 0.0);
    bench.until("it is in", 10.0, |bench| bench.truth().pose.x_m > 5.6);
    bench.finish();
}

#[test]
fn without_leave_for_any_area_it_is_driven_only_by_who_sees_to_them_and_creeps() {
    let mut bench = Bench::allowed(Pose::new(4.0, LANE_Y_M, 0.0), 0);
    bench.watch(4.0);
    take(&mut bench);
    bench.desk().want(0.2, 0.0);
    bench.stands_for(2.0);
    let why = limit(&mut bench);
    assert!(
        why.starts_with("place: ") && why.contains("onboard ctl place"),
        "{why}"
    );
    let now_ns = bench.now_ns;
    bench.desk().leave(now_ns);
    bench.watch(0.5);
    bench.desk().ask(Teleop {
        without_borders: true,
    });
    take(&mut bench);
    bench.desk().want(0.2, 0.0);
    let fastest_m_s = { bench.watch(4.0).into_iter() }
        .map(|truth| truth.twist.v_m_s)
        .fold(0.0, f64::max);
    assert!((0.08..0.13).contains(&fastest_m_s), "{fastest_m_s} m/s");
    bench.finish();
}

#[test]
fn one_person_drives_and_an_operators_stop_wins() {
    let mut bench = driven();
    bench.ask(Request::Teleop(Teleop::default()));
    bench.watch(0.5);
    for request in [Request::Resume, Request::Reload] {
        bench.ask(request);
        bench.watch(0.2);
    }
    let refused = bench.refused();
    assert!(
        refused.len() == 3 && refused[0].contains("another teleoperator"),
        "{refused:?}"
    );
    assert!(bench.truth().twist.v_m_s > 0.18, "the first one drives on");
    bench.ask(Request::Stop);
    let (took_s, _) = stopping(&mut bench);
    assert!(took_s < 0.1 + 0.05 + 0.25, "{took_s} s");
    bench.watch(0.5);
    let over = bench.desk().over().cloned();
    assert!(over.is_some_and(|over| over.to_string().contains("an operator has stopped")),);
    // Neither who drives nor a reset alone moves it.
    bench.desk().want(0.2, 0.0);
    bench.stands_for(1.0);
    bench.ask(Request::Reset);
    bench.stands_for(2.0);
    bench.ask(Request::Resume);
    bench.until_driving();
    bench.finish();
}

#[test]
fn a_fault_stops_it_and_after_the_reset_the_dead_man_must_be_let_go_first() {
    let mut bench = driven();
    bench.devices.drive_faults().set_emergency_stop(true);
    bench.until_raised(Fault::MotorsOff, 2.0);
    bench.until_standing(2.0);
    let why = limit(&mut bench);
    assert!(why.starts_with("fault motors-off: "), "{why}");
    bench.devices.drive_faults().set_emergency_stop(false);
    bench.watch(0.5);
    bench.ask(Request::Reset);
    bench.stands_for(3.0);
    let status = bench.desk().status().expect("it was told").clone();
    assert!(
        status.release_first && status.faults.is_empty(),
        "{status:?}"
    );
    bench.desk().want(0.0, 0.0);
    bench.watch(0.2);
    bench.desk().want(0.2, 0.0);
    bench.until("it is driven", 3.0, |bench| {
        bench.truth().twist.v_m_s > 0.15
    });
    bench.finish();
}

#[test]
fn it_makes_no_detours_and_no_retreats_by_hand() {
    let set = ["tubes.detour_curvature_1_m=4"];
    let thing = block(4.0, LANE_Y_M);
    let mut bench = Bench::new(Pose::new(2.8, LANE_Y_M, 0.0), 0.0, &[thing], &set);
    bench.watch(1.0);
    bench.ask(Request::Pause);
    bench.watch(3.0);
    take(&mut bench);
    bench.desk().want(0.2, 0.0);
    bench.until_raised(Fault::NoFreeTube, 15.0);
    bench.until_standing(8.0);
    bench.stands_for(10.0);
    assert_eq!(bench.belief().reason, Reason::Blocked as u64);
    bench.finish();
}

/// Its computer was switched off while it drove: borders mean nothing, and whoever drives it sees to them.
#[test]
fn a_robot_that_nobody_has_told_where_it_is_can_be_driven_by_hand() {
    let mut bench = Bench::driving();
    bench.be_lost_in_hands();
    bench.watch(0.5);
    bench.desk().want(0.0, 0.0);
    bench.watch(0.2);
    bench.desk().want(0.2, 0.0);
    let before_m = bench.truth().distance_m;
    for _ in 0..30 {
        bench.watch(0.1);
        // It creeps: what it takes for its place may be none.
        assert!(bench.truth().twist.v_m_s < 0.13);
    }
    let way_m = bench.truth().distance_m - before_m;
    assert!(way_m > 0.05, "{way_m} m: {}", limit(&mut bench));
    // What stops it meanwhile is reset without a word on where it stands, which whoever drives it does not know yet.
    bench.devices.drive_faults().set_emergency_stop(true);
    bench.until_raised(Fault::MotorsOff, 2.0);
    bench.until_standing(2.0);
    bench.devices.drive_faults().set_emergency_stop(false);
    bench.watch(0.5);
    let (reply, _) = bench.answer_to(Request::Reset);
    let place_only = Err(Refusal::Remaining(vec![Fault::PlaceUnknown]));
    assert_eq!(reply, place_only);
    is_driven_and_left(&mut bench);
    for request in [Request::Resume, Request::Reset] {
        bench.ask(request);
        bench.stands_for(3.0);
    }
    assert!(bench.has(Fault::PlaceUnknown));
    bench.finish();
}

/// Where walls contradict what it was told of its place, it is driven to where others are seen; what stops it meanwhile is reset, which is
/// refused for its pose alone.
#[test]
fn a_robot_whose_pose_is_uncertain_can_be_driven_by_hand_after_a_reset() {
    let mut bench = Bench::driving();
    bench.ask(Request::Stop);
    bench.until_standing(3.0);
    let pose = bench.truth().pose;
    let at = Spot::Pose(Pose2::new(pose.x_m, pose.y_m + 1.0, pose.theta_rad));
    let (reply, _) = bench.answer_to(Request::Place(Place { at, state: None }));
    assert!(reply.is_ok(), "{reply:?}");
    bench.until_raised(Fault::PoseUncertain, 5.0);
    bench.ask(Request::Teleop(Teleop {
        without_borders: true,
    }));
    bench.until("it is in hands", 1.0, |bench| bench.desk().is_taken());
    for _ in 0..2 {
        let (reply, _) = bench.answer_to(Request::Reset);
        assert_eq!(reply, Err(Refusal::Remaining(vec![Fault::PoseUncertain])));
        bench.watch(0.5);
        assert!(!bench.has(Fault::OperatorStop));
    }
    is_driven_and_left(&mut bench);
    bench.stands_for(5.0);
    bench.finish();
}
