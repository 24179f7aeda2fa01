//! Wheels that do not do what they are told, or are pulled elsewhere.

use onboard::process::ctl::{Done, Refusal, Request};
use onboard::symbols::faults::Fault;
use sim::kelo::DriveHandle;
use sim::world::Mechanics;

use crate::stepped::bench::Bench;

/// So far a wheel may move beyond what it was told, by the robot file's default, and then the robot brakes.
const NOTICED_M: f64 = 0.02;

fn wear(bench: &Bench, mechanics: Mechanics) {
    bench.world.lock().wear(0, mechanics);
}

/// The robot goes on, once an operator has agreed.
fn goes_on_after_a_reset(mut bench: Bench) {
    bench.stands_for(3.0);
    assert!(bench.has(Fault::WheelsDisobey));
    wear(&bench, Mechanics::default());
    // That the wheels are all right is not enough.
    bench.stands_for(3.0);
    bench.ask(Request::Reset);
    bench.until_driving();
    assert!(!bench.has(Fault::WheelsDisobey));
    bench.finish();
}

#[test]
fn a_wheel_that_turns_the_wrong_way_stops_the_robot_before_it_gets_far() {
    for reversed in [[true, false], [false, true], [true, true]] {
        let mut bench = Bench::driving();
        bench.ask(Request::Pause);
        bench.until_standing(2.0);
        wear(
            &bench,
            Mechanics {
                reversed,
                ..Mechanics::default()
            },
        );
        let before = bench.truth();
        bench.ask(Request::Resume);
        bench.until_raised(Fault::WheelsDisobey, 3.0);
        bench.until_standing(1.0);
        let way_m = bench.truth().distance_m - before.distance_m;
        assert!(way_m < 0.05, "{reversed:?}: {way_m}");
        goes_on_after_a_reset(bench);
    }
}

#[test]
fn a_pivot_that_is_jammed_stops_the_robot_when_it_steers() {
    let mut bench = Bench::driving();
    wear(
        &bench,
        Mechanics {
            pivot_jammed: true,
            ..Mechanics::default()
        },
    );
    // Straight ahead it need not turn.
    bench.until_raised(Fault::WheelsDisobey, 60.0);
    bench.until_standing(1.0);
    goes_on_after_a_reset(bench);
}

#[test]
fn brakes_that_are_weaker_than_the_robot_file_says_are_noticed_at_the_first_stop() {
    let mut bench = Bench::driving();
    bench.drives_for(2.0);
    let configured_m_s2 = bench.plan.robot.drive.limits.stop_deceleration_m_s2;
    wear(
        &bench,
        Mechanics {
            braking_m_s2: 0.4 * configured_m_s2,
            ..Mechanics::default()
        },
    );
    let before = bench.truth();
    bench.ask(Request::Stop);
    bench.until_raised(Fault::WheelsDisobey, 1.0);
    bench.until_standing(1.0);
    // As fast as it can.
    let speed_m_s = before.twist.v_m_s;
    let stop_m = speed_m_s * (0.1 + 0.05) + speed_m_s.powi(2) / (0.8 * configured_m_s2);
    let way_m = bench.truth().distance_m - before.distance_m;
    assert!(way_m < stop_m * 1.1, "{way_m} {stop_m}");
    goes_on_after_a_reset(bench);
}

#[test]
fn a_heavy_robot_holds_on_a_slope() {
    let mut bench = Bench::driving();
    // A ramp of one in ten, with three times the mass: what is left while standing does not hold it.
    let slope = Mechanics {
        slope_m_s2: [1.0, 0.0],
        load: 3.0,
        ..Mechanics::default()
    };
    wear(&bench, slope);
    bench.drives_for(1.0);
    bench.ask(Request::Stop);
    bench.until_standing(1.0);
    let rolled_m = {
        let before = bench.truth().distance_m;
        bench.watch(20.0);
        bench.truth().distance_m - before
    };
    assert!(rolled_m < 0.002, "{rolled_m}");
    assert_eq!(bench.raised(Fault::WheelsDisobey), 0);
    bench.ask(Request::Reset);
    bench.until_driving();
    bench.finish();
}

#[test]
fn a_robot_that_cannot_be_held_says_so() {
    let mut bench = Bench::driving();
    bench.ask(Request::Stop);
    bench.until_standing(1.0);
    bench.stands_for(1.0);
    // So steep and so heavy that no current holds it.
    let slope = Mechanics {
        slope_m_s2: [4.0, 0.0],
        load: 20.0,
        ..Mechanics::default()
    };
    wear(&bench, slope);
    let before = bench.truth().distance_m;
    bench.until_raised(Fault::WheelsDisobey, 2.0);
    let rolled_m = bench.truth().distance_m - before;
    assert!(rolled_m < NOTICED_M + 0.02, "{rolled_m}");
}

#[test]
fn a_robot_that_obeys_is_believed() {
    // Uphill, downhill, and with the mass of two.
    for slope in [-0.5, 0.5] {
        let mut bench = Bench::driving();
        wear(
            &bench,
            Mechanics {
                slope_m_s2: [slope, 0.0],
                load: 2.0,
                ..Mechanics::default()
            },
        );
        bench.watch(60.0);
        assert_eq!(bench.raised(Fault::WheelsDisobey), 0);
        bench.finish();
    }
}

#[test]
fn an_encoder_that_sticks_stops_the_robot() {
    for stick in [
        DriveHandle::stick_left_encoder,
        DriveHandle::stick_right_encoder,
    ] {
        let mut bench = Bench::driving();
        stick(bench.devices.drive_faults(), true);
        bench.until_raised(Fault::EncoderBroken, 2.0);
        bench.until_standing(1.0);
        stick(bench.devices.drive_faults(), false);
        bench.stands_for(3.0);
        bench.ask(Request::Reset);
        bench.until_driving();
        bench.finish();
    }
}

/// It steers by that angle: what does not seem to turn, it turns farther.
#[test]
fn a_pivot_encoder_that_sticks_stops_the_robot_as_soon_as_it_steers() {
    let mut bench = Bench::driving();
    bench.devices.drive_faults().stick_pivot_encoder(true);
    let before = bench.truth();
    bench.until_raised(Fault::EncoderBroken, 60.0);
    bench.until_standing(1.0);
    let clear_m = bench.truth().clearance_m;
    assert!(clear_m > 0.1, "{clear_m} m, from {before:?}");
    bench.devices.drive_faults().stick_pivot_encoder(false);
    bench.stands_for(3.0);
    bench.ask(Request::Reset);
    bench.until_driving();
    bench.finish();
}

#[test]
fn a_wheel_that_slips_stops_the_robot_until_a_reset() {
    for slip in [[0.3, 0.0], [0.0, 0.3]] {
        let mut bench = Bench::driving();
        bench.drives_for(1.0);
        wear(
            &bench,
            Mechanics {
                slip,
                ..Mechanics::default()
            },
        );
        let before = bench.truth();
        bench.until_raised(Fault::WheelSlip, 3.0);
        bench.until_standing(1.0);
        let way_m = bench.truth().distance_m - before.distance_m;
        assert!(way_m < 0.4, "{slip:?}: {way_m} m");
        wear(&bench, Mechanics::default());
        bench.stands_for(5.0);
        bench.ask(Request::Reset);
        bench.until_driving();
        bench.finish();
    }
}

/// What it was told is faster than it is: a ramp that began there would have it speed up before it slows down.
#[test]
fn a_hard_stop_begins_at_the_speed_that_the_wheels_have() {
    // So heavy that it follows slowly, which is not to be taken for wheels that do not obey.
    let mut bench = Bench::standing_with(&[
        "drive.following_error_m=0.1",
        "tubes.augment_m=0.2",
        "tubes.by_hand_augment_m=0.2",
    ]);
    let heavy = Mechanics {
        load: 300.0,
        ..Mechanics::default()
    };
    wear(&bench, heavy);
    let slow_m_s = 0.1;
    bench.until("it moves", 10.0, |bench| {
        bench.truth().twist.v_m_s > slow_m_s
    });
    let (told_rad_s, _) = bench.devices.drive_faults().statistics().last_rad_s;
    let told_m_s = told_rad_s * bench.plan.robot.drive.geometry.wheel_radius_m();
    assert!(told_m_s > 1.5 * slow_m_s, "it lags: {told_m_s} m/s");
    bench.ask(Request::Stop);
    // The supervisor is asked ten times a second, and navigation and control pass it on.
    bench.until("it slows down", 0.5, |bench| {
        let (now_rad_s, _) = bench.devices.drive_faults().statistics().last_rad_s;
        now_rad_s < 0.9 * told_rad_s
    });
    let before = bench.truth();
    let (first_rad_s, _) = bench.devices.drive_faults().statistics().last_rad_s;
    let first_m_s = first_rad_s * bench.plan.robot.drive.geometry.wheel_radius_m();
    assert!(
        first_m_s < 1.05 * before.twist.v_m_s + 0.01,
        "told {first_m_s} m/s at {} m/s",
        before.twist.v_m_s
    );
    let seen = bench.watch(1.0);
    let speeds = seen.iter().map(|truth| truth.twist.v_m_s);
    let fastest_m_s = speeds.fold(0.0, f64::max);
    assert!(
        fastest_m_s < before.twist.v_m_s + 0.01,
        "sped up from {} to {fastest_m_s} m/s",
        before.twist.v_m_s
    );
    bench.until_standing(3.0);
    bench.finish();
}

/// Encoders are 32-bit floats: after a day their steps are 3 mm.
#[test]
fn a_drive_that_has_been_on_for_days_is_driven_as_well_as_a_new_one() {
    const DAY_S: f64 = 86_400.0;
    let mut off_m = [0.0, 0.0];
    for (days, off_m) in [0.0, 3.0].into_iter().zip(&mut off_m) {
        let mut bench = Bench::standing();
        let handle = bench.devices.drive_faults();
        handle.set_encoders_ahead(7.6 * DAY_S * days);
        bench.until_driving();
        bench.run(120, |belief, world| {
            let truth = world.truth(0).expect("a robot").pose;
            if belief.stamp_ns > 0 {
                let apart_m = (belief.pose.x_m - truth.x_m).hypot(belief.pose.y_m - truth.y_m);
                *off_m = f64::max(*off_m, apart_m);
            }
            false
        });
        for fault in [
            Fault::EncoderImplausible,
            Fault::WheelSlip,
            Fault::WheelsDisobey,
            Fault::EncoderBroken,
        ] {
            assert_eq!(bench.raised(fault), 0, "{}", fault.name());
        }
        bench.finish();
    }
    let [new_m, old_m] = off_m;
    assert!(old_m < new_m + 0.01, "{new_m} {old_m}");
}

/// Emergency bits take the motors' power, which is no emergency stop that somebody has pressed.
#[test]
fn a_drive_that_stops_by_itself_is_reset_like_any_other() {
    let reversed = Mechanics {
        reversed: [true, true],
        ..Mechanics::default()
    };
    let weak = Mechanics {
        braking_m_s2: 0.5,
        ..Mechanics::default()
    };
    for (mechanics, comes) in [(reversed, Request::Resume), (weak, Request::Stop)] {
        let mut bench =
            Bench::driving_with(&["drive.emergency_bits=true", "drive.following_error_m=0.015"]);
        if comes == Request::Resume {
            bench.ask(Request::Pause);
            bench.until_standing(2.0);
        } else {
            bench.drives_for(2.0);
        }
        wear(&bench, mechanics);
        let before = bench.truth();
        bench.ask(comes);
        bench.until_raised(Fault::WheelsDisobey, 3.0);
        assert!(bench.devices.drive_faults().statistics().emergency > 0);
        bench.until_standing(1.0);
        // It coasts: the simulated drive gives its motors no power while these bits are set.
        let (v_m_s, coasts_m_s2) = (
            before.twist.v_m_s.max(0.1),
            bench.plan.robot.drive.unpowered_deceleration_m_s2,
        );
        let most_m = v_m_s * 0.3 + v_m_s.powi(2) / (2.0 * coasts_m_s2);
        let way_m = bench.truth().distance_m - before.distance_m;
        assert!(way_m < most_m, "{way_m} m, expected at most {most_m}");
        bench.stands_for(3.0);
        assert_eq!(bench.raised(Fault::MotorsOff), 0);
        wear(&bench, Mechanics::default());
        // A button that is pressed is still found, once the drive is told to power its motors again.
        bench.devices.drive_faults().set_emergency_stop(true);
        let (reply, _) = bench.answer_to(Request::Reset);
        let pressed = Refusal::Remaining(vec![Fault::MotorsOff]);
        assert_eq!(reply, Err(pressed));
        bench.devices.drive_faults().set_emergency_stop(false);
        bench.stands_for(1.0);
        assert_eq!(
            bench.answer_to(Request::Reset).0,
            Ok(Done::Reset(Vec::new()))
        );
        bench.until_driving();
        assert!(!bench.has(Fault::WheelsDisobey));
        bench.finish();
    }
}
