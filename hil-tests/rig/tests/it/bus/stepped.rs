//! Frames are lost, the drive leaves OP, loses its cable or its power.

use std::time::Duration;

use onboard::process::ctl::{Refusal, Request};
use onboard::symbols::faults::Fault;
use sim::world::Truth;

use crate::stepped::bench::Bench;

/// The drive's own watchdog, which ends a setpoint that nobody renews.
const WATCHDOG_S: f64 = 0.1;

#[test]
fn short_losses_are_borne_and_a_long_one_survived() {
    let mut bench = Bench::driving();
    let faults = bench.devices.bus_faults().clone();
    for lost_ms in [1, 10] {
        for _ in 0..5 {
            faults.lose_frames_for(Duration::from_millis(lost_ms));
            bench.drives_for(0.2);
        }
    }
    assert_eq!(bench.raised(Fault::BusLost), 0);
    let silent = bench.raised(Fault::ScanSilent);
    faults.lose_frames_for(Duration::from_millis(200));
    stops_and_drives_on(&mut bench);
    assert!(bench.raised(Fault::BusLost) > 0);
    assert_eq!(bench.raised(Fault::ScanSilent), silent);
    assert!(!bench.has(Fault::BusLost));
    bench.finish();
}

/// As with a queue of the interface that is full (`ENOBUFS`): the same deadlines as for frames that get lost.
#[test]
fn frames_that_the_interface_refuses_are_lost_frames_and_only_a_gone_one_is_a_lost_bus() {
    let mut bench = Bench::driving();
    for refused_s in [0.001, 0.01] {
        for _ in 0..5 {
            bench.devices.refuse_frames(1.0);
            bench.watch(refused_s);
            bench.devices.refuse_frames(0.0);
            bench.drives_for(0.2);
        }
    }
    assert_eq!(bench.raised(Fault::BusLost), 0);
    bench.is_stopped(WATCHDOG_S, |bench| bench.devices.refuse_frames(1.0));
    bench.until_raised(Fault::BusLost, 0.1);
    bench.devices.refuse_frames(0.0);
    bench.until("the bus is up", 5.0, |bench| !bench.has(Fault::BusLost));
    bench.until("it drives, or waits for a reset", 10.0, |bench| {
        if bench.has(Fault::DriveReturned) {
            bench.ask(Request::Reset);
        }
        bench.truth().twist.v_m_s > 0.1
    });
    let lost = bench.raised(Fault::BusLost);
    // Not even for a moment is one driven without an interface.
    bench.devices.lose_interface(true);
    bench.until_raised(Fault::BusLost, 0.15);
    assert_eq!(bench.raised(Fault::BusLost), lost + 1);
    bench.devices.lose_interface(false);
    stops_and_drives_on(&mut bench);
    bench.finish();
}

#[test]
fn a_drive_that_leaves_op_is_brought_up_again_until_it_is_too_often() {
    let mut bench = Bench::driving();
    let faults = bench.devices.bus_faults().clone();
    let times = bench.plan.robot.drive.bringups_per_minute;
    for time in 1..=times {
        faults.drop_to_safeop(0);
        stops_and_drives_on(&mut bench);
        assert!(!bench.has(Fault::BringUpLimit), "after {time} of {times}");
    }
    bench.is_stopped(WATCHDOG_S, |_| faults.drop_to_safeop(0));
    bench.until_raised(Fault::BringUpLimit, 1.0);
    bench.stands_for(70.0);

    bench.ask(Request::Reset);
    bench.until_driving();
    assert!(!bench.has(Fault::BringUpLimit) && !bench.has(Fault::BusLost));
    bench.finish();
}

#[test]
fn a_drive_that_was_gone_or_without_power_waits_for_an_operator_when_it_is_back() {
    // The emergency stop that cuts all, and one that is released at once.
    for (gone_s, powerless) in [(5.0, false), (5.0, true), (0.1, true)] {
        let mut bench = Bench::driving();
        let faults = bench.devices.bus_faults().clone();
        bench.is_stopped(WATCHDOG_S, |_| {
            if powerless {
                faults.power_off(0);
            } else {
                faults.disappear(0);
            }
        });
        bench.until_raised(Fault::BusLost, 1.0);
        bench.stands_for(gone_s);
        if gone_s > 1.0 {
            // The lidar streams all the time.
            assert!(bench.has(Fault::OdometrySilent) && !bench.has(Fault::ScanSilent));
        }
        faults.power_on(0);
        faults.reappear(0);
        bench.until_raised(Fault::DriveReturned, 5.0);
        assert!(!bench.has(Fault::BusLost));
        bench.stands_for(5.0);
        bench.ask(Request::Resume);
        bench.stands_for(5.0);
        bench.ask(Request::Reset);
        bench.until_driving();
        assert!(!bench.has(Fault::DriveReturned) && !bench.has(Fault::OdometrySilent));
        bench.finish();
    }
}

/// Who resets it before the drive is back has not seen it come back.
#[test]
fn a_reset_while_the_drive_is_gone_does_not_let_it_go_on() {
    let mut bench = Bench::driving();
    let faults = bench.devices.bus_faults().clone();
    faults.disappear(0);
    bench.until_raised(Fault::BusLost, 1.0);
    bench.until_standing(2.0);
    bench.stands_for(20.0);
    let (reply, _) = bench.answer_to(Request::Reset);
    let gone = vec![Fault::BusLost, Fault::BringUpLimit];
    assert_eq!(reply, Err(Refusal::Remaining(gone)));
    assert!(bench.has(Fault::OperatorStop));
    bench.watch(0.3);
    faults.reappear(0);
    bench.until_raised(Fault::DriveReturned, 5.0);
    bench.stands_for(5.0);
    bench.ask(Request::Reset);
    bench.until_driving();
    // The same where something did wait, and the drive went after that.
    bench.devices.drive_faults().set_emergency_stop(true);
    bench.until_raised(Fault::MotorsOff, 1.0);
    bench.until_standing(2.0);
    faults.disappear(0);
    bench.until_raised(Fault::BusLost, 1.0);
    bench.devices.drive_faults().clear_faults();
    let (reply, _) = bench.answer_to(Request::Reset);
    let Err(Refusal::Remaining(remaining)) = reply else {
        panic!("{reply:?}")
    };
    assert!(remaining.contains(&Fault::MotorsOff), "{remaining:?}");
    faults.reappear(0);
    bench.stands_for(5.0);
    bench.ask(Request::Reset);
    bench.until_driving();
    bench.finish();
}

/// A bus that is back within a second goes on by itself: no stop of before may be gone by then that nobody took back with success.
#[test]
fn a_reset_that_is_refused_while_the_bus_is_lost_for_a_moment_lets_nothing_go() {
    let mut bench = Bench::driving();
    bench.ask(Request::Stop);
    bench.until_standing(2.0);
    let faults = bench.devices.bus_faults().clone();
    faults.disappear(0);
    bench.until_raised(Fault::BusLost, 1.0);
    let (reply, _) = bench.answer_to(Request::Reset);
    assert_eq!(reply, Err(Refusal::Remaining(vec![Fault::BusLost])));
    assert!(bench.has(Fault::OperatorStop));
    faults.reappear(0);
    bench.stands_for(5.0);
    assert!(!bench.has(Fault::BusLost) && bench.raised(Fault::DriveReturned) == 0);
    bench.ask(Request::Reset);
    bench.until_driving();
    bench.finish();
}

/// Somebody may have held the emergency stop while the program was started.
#[test]
fn a_drive_that_comes_after_the_program_waits_for_an_operator_unless_its_file_has_it_awaited() {
    for (awaited_s, by_itself) in [("1.0", false), ("30.0", true)] {
        let mut bench = Bench::standing_with(&[&format!("drive.awaited_s={awaited_s}")]);
        let faults = bench.devices.bus_faults().clone();
        faults.disappear(0);
        bench.stands_for(5.0);
        faults.reappear(0);
        if !by_itself {
            bench.until_raised(Fault::DriveReturned, 5.0);
            bench.stands_for(5.0);
            bench.ask(Request::Reset);
        }
        bench.until_driving();
        assert_eq!(bench.raised(Fault::DriveReturned), u64::from(!by_itself));
        bench.finish();
    }
}

#[test]
fn a_cable_that_was_loose_for_a_moment_stops_it_for_a_moment() {
    let mut bench = Bench::driving();
    let faults = bench.devices.bus_faults().clone();
    faults.disappear(0);
    bench.watch(0.3);
    faults.reappear(0);
    bench.until_driving();
    assert_eq!(bench.raised(Fault::DriveReturned), 0);
    bench.finish();
}

/// The first bring-up gives the drive its address, which is how the next one would know that it never lost its power.
#[test]
fn a_loss_of_power_is_remembered_by_bring_ups_that_fail() {
    /// So long a frame is sent again and again until a bring-up gives up, and then some.
    const GIVES_UP: Duration = Duration::from_millis(250);
    let mut forgotten = Vec::new();
    for moment_ms in [1, 10, 20, 30, 40, 50, 60] {
        let mut bench = Bench::driving();
        let faults = bench.devices.bus_faults().clone();
        faults.power_off(0);
        faults.power_on(0);
        bench.watch(f64::from(moment_ms) * 1e-3);
        faults.lose_frames_for(GIVES_UP);
        bench.until_standing(2.0);
        bench.watch(2.0);
        if !bench.has(Fault::DriveReturned) {
            forgotten.push(moment_ms);
            continue;
        }
        bench.stands_for(3.0);
        bench.ask(Request::Reset);
        bench.until_driving();
        bench.drives_for(2.0);
        // Its encoders count from zero again, which is no motion.
        let (truth, believed) = (bench.truth().pose, bench.belief().pose);
        let off_m = (truth.x_m - believed.x_m).hypot(truth.y_m - believed.y_m);
        assert!(off_m < 0.05, "{moment_ms} ms: {off_m}");
        bench.finish();
    }
    assert!(forgotten.is_empty(), "after {forgotten:?} ms");
}

#[test]
fn bring_ups_that_fail_count_and_the_bus_is_up_when_an_operator_comes() {
    let mut bench = Bench::driving();
    let faults = bench.devices.bus_faults().clone();
    // Each time one attempt fails and the next one is good: three in a minute are allowed.
    for time in 1..=2 {
        faults.disappear(0);
        bench.watch(0.3);
        faults.reappear(0);
        if time == 1 {
            bench.until_driving();
            assert!(!bench.has(Fault::BringUpLimit));
        }
    }
    bench.until_raised(Fault::BringUpLimit, 2.0);
    bench.until("the bus is up", 2.0, |bench| !bench.has(Fault::BusLost));
    assert_eq!(bench.raised(Fault::DriveReturned), 0);
    bench.until_standing(1.0);
    bench.stands_for(70.0);
    bench.ask(Request::Reset);
    bench.until_driving();
    assert!(!bench.has(Fault::BringUpLimit));
    bench.finish();
}

/// Motors are off until the bus is up again, which may be sooner than wheels come to rest; then it speeds up from
/// standing, and never jumps to the speed it had.
fn stops_and_drives_on(bench: &mut Bench) {
    const ALL_BUT_STANDING_M_S: f64 = 0.08;
    let slow = |truth: &Truth| truth.twist.v_m_s < ALL_BUT_STANDING_M_S;
    bench.until("it has stopped", 1.5, |bench| slow(&bench.truth()));
    let start_ns = bench.now_ns;
    let limits = bench.plan.robot.drive.limits;
    bench.until("it drives", 10.0, |bench| {
        let truth = bench.truth();
        let after_s = truth.time_ns.saturating_sub(start_ns) as f64 / 1e9;
        let most_m_s = ALL_BUT_STANDING_M_S + 1.5 * limits.acceleration_m_s2 * after_s;
        assert!(
            truth.twist.v_m_s < most_m_s,
            "jumped, {after_s:.3} s after: {truth:?}"
        );
        truth.twist.v_m_s > 0.3
    });
}
