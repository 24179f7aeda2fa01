//! What an operator is answered who resets the robot: not that it was told, but what still stops it.

use description::geometry::Pose2;
use onboard::process::ctl::{Done, Place, Refusal, Request, Spot};
use onboard::symbols::faults::Fault;
use sim::lidar::Disturbance;
use sim::world::Mechanics;

use crate::stepped::bench::Bench;

/// The supervisor serves ten times a second, and answers three cycles later.
const ANSWERED_S: std::ops::RangeInclusive<f64> = 0.25..=0.45;

#[test]
fn a_reset_is_answered_with_the_faults_that_remain_and_what_to_do() {
    type Change = fn(&Bench);
    let rolls_away = |bench: &Bench| {
        // So steep and so heavy that no current holds it.
        let slope = Mechanics {
            slope_m_s2: [4.0, 0.0],
            load: 20.0,
            ..Mechanics::default()
        };
        bench.world.lock().wear(0, slope);
    };
    let is_mended = |bench: &Bench| bench.world.lock().wear(0, Mechanics::default());
    let is_released = |bench: &Bench| bench.devices.drive_faults().clear_faults();
    let cases: [(Fault, Change, Change); 3] = [
        (
            Fault::BusVoltage,
            |bench| bench.devices.drive_faults().set_bus_voltage(Some(18.0)),
            is_released,
        ),
        (
            Fault::MotorsOff,
            |bench| bench.devices.drive_faults().set_emergency_stop(true),
            is_released,
        ),
        (Fault::WheelsDisobey, rolls_away, is_mended),
    ];
    for (fault, comes, goes) in cases {
        let mut bench = Bench::driving();
        comes(&bench);
        bench.until_raised(fault, 2.0);
        for _ in 0..3 {
            let (reply, after_s) = bench.answer_to(Request::Reset);
            assert_eq!(reply, Err(Refusal::Remaining(vec![fault])));
            assert!(
                ANSWERED_S.contains(&after_s),
                "{}: {after_s} s",
                fault.name()
            );
            let why = reply.expect_err("just compared").to_string();
            let told = [fault.name(), fault.sentence()];
            assert!(told.iter().all(|word| why.contains(word)), "{why}");
        }
        goes(&bench);
        bench.until_standing(3.0);
        bench.stands_for(1.0);
        let (reply, after_s) = bench.answer_to(Request::Reset);
        assert_eq!(reply, Ok(Done::Reset(Vec::new())), "{}", fault.name());
        assert!(
            ANSWERED_S.contains(&after_s),
            "{}: {after_s} s",
            fault.name()
        );
        bench.until_driving();
        bench.finish();
    }
}

#[test]
fn other_requests_are_served_while_a_reset_waits_for_its_answer() {
    let mut bench = Bench::driving();
    bench.ask(Request::Stop);
    bench.until_standing(3.0);
    // One in each cycle: both resets wait when the stop comes.
    for request in [
        Request::Reset,
        Request::Reset,
        Request::Stop,
        Request::Resume,
    ] {
        bench.ask(request);
    }
    bench.watch(1.0);
    let stopped = || Err(Refusal::Remaining(vec![Fault::OperatorStop]));
    let expected = [
        ("stop", Ok(Done::Stopped)),
        ("stop", Ok(Done::Stopped)),
        ("resume", Err(Refusal::StoppedByFault)),
        ("reset", stopped()),
        ("reset", stopped()),
    ];
    assert_eq!(bench.replies(), expected);
    bench.stands_for(1.0);
    let (reply, _) = bench.answer_to(Request::Reset);
    assert_eq!(reply, Ok(Done::Reset(Vec::new())));
    bench.until_driving();
    bench.finish();
}

/// Walls that contradict a wrong word of where it stands end to do so by themselves when the right one is said: nobody has let it go on.
#[test]
fn a_reset_that_was_refused_for_an_uncertain_pose_lets_nothing_go_on_once_it_is_certain() {
    let mut bench = Bench::driving();
    bench.ask(Request::Stop);
    bench.until_standing(3.0);
    let place = |off_m: f64, bench: &mut Bench| {
        let pose = bench.truth().pose;
        let at = Spot::Pose(Pose2::new(pose.x_m, pose.y_m + off_m, pose.theta_rad));
        let (reply, _) = bench.answer_to(Request::Place(Place { at, state: None }));
        assert!(matches!(reply, Ok(Done::Placed(_))), "{reply:?}");
    };
    place(1.0, &mut bench);
    bench.until_raised(Fault::PoseUncertain, 5.0);
    let (reply, _) = bench.answer_to(Request::Reset);
    assert_eq!(reply, Err(Refusal::Remaining(vec![Fault::PoseUncertain])));
    place(0.0, &mut bench);
    bench.stands_for(10.0);
    assert!(!bench.has(Fault::PoseUncertain) && bench.has(Fault::OperatorStop));
    let (reply, _) = bench.answer_to(Request::Reset);
    assert_eq!(reply, Ok(Done::Reset(Vec::new())));
    bench.until_driving();
    bench.finish();
}

/// It hears of the reset when the attempt to connect it is over, long after that was refused.
#[test]
fn a_reset_that_was_refused_while_the_lidar_is_connected_lets_nothing_go_on_later() {
    let mut bench = Bench::driving();
    let disturb = |bench: &Bench, disturbance| {
        bench.devices.disturb_lidar(disturbance, bench.now_ns);
    };
    disturb(&bench, Disturbance::RepeatAgain { repeats: true });
    bench.until_raised(Fault::LidarFrozen, 10.0);
    disturb(&bench, Disturbance::RepeatAgain { repeats: false });
    disturb(&bench, Disturbance::Freeze { frozen: true });
    bench.until_standing(2.0);
    bench.watch(2.0);
    let (reply, _) = bench.answer_to(Request::Reset);
    let Err(Refusal::Remaining(remaining)) = &reply else {
        panic!("{reply:?}");
    };
    assert!(remaining.contains(&Fault::LidarFrozen), "{remaining:?}");
    disturb(&bench, Disturbance::Freeze { frozen: false });
    bench.stands_for(15.0);
    assert!(!bench.has(Fault::LidarFrozen), "what was carried out later");
    let (reply, _) = bench.answer_to(Request::Reset);
    assert_eq!(reply, Ok(Done::Reset(Vec::new())));
    bench.until_driving();
    bench.finish();
}

/// It is no use to forget that a thread hangs, only to find it again.
#[test]
fn a_reset_while_a_thread_hangs_is_answered_with_that() {
    for thread in ["motion", "navigation"] {
        let mut bench = Bench::driving();
        bench.hang(&[thread]);
        bench.until_raised(Fault::ThreadHung, 2.2);
        bench.until_standing(2.0);
        for _ in 0..5 {
            let (reply, after_s) = bench.answer_to(Request::Reset);
            let Err(Refusal::Remaining(remaining)) = &reply else {
                panic!("{thread}: {reply:?}");
            };
            assert!(remaining.contains(&Fault::ThreadHung), "{remaining:?}");
            assert!(ANSWERED_S.contains(&after_s), "{thread}: {after_s} s");
            bench.stands_for(0.3);
        }
        bench.hang(&[]);
        bench.watch(0.5);
        // What a thread that hung has left undone goes by itself.
        let (reply, _) = bench.answer_to(Request::Reset);
        let Ok(Done::Reset(lasting)) = &reply else {
            panic!("{thread}: {reply:?}");
        };
        let told = Done::Reset(lasting.clone()).to_string();
        assert!(
            lasting.iter().all(|fault| told.contains(fault.sentence())),
            "{told}"
        );
        bench.until_driving();
        assert!(!bench.has(Fault::ThreadHung));
        bench.finish();
    }
}
