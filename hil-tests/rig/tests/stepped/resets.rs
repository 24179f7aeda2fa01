//! What an operator is answered who resets the robot: not that it was told, but what still stops it.

use onboard::process::ctl::{Done, Refusal, Request};
use onboard::symbols::faults::Fault;
use sim::world::Mechanics;

use crate::bench::Bench;

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
