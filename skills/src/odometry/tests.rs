use description::geometry::Pose2;

use super::*;
use std::f64::consts::PI;

const STEP_NS: u64 = 5_000_000;

/// Encoders of a unit that moves as told, exact.
struct Encoders {
    geometry: TricycleGeometry,
    sample: EncoderSample,
    pose: Pose2,
    driven_m: f64,
}

impl Encoders {
    fn new() -> Self {
        Self {
            geometry: TricycleGeometry::default(),
            sample: EncoderSample {
                stamp_ns: 1,
                ..EncoderSample::default()
            },
            pose: Pose2::IDENTITY,
            driven_m: 0.0,
        }
    }

    fn step(&mut self, unit_m_s: f64, pivot_rate_rad_s: f64) -> EncoderSample {
        let substeps = 50;
        let dt_s = STEP_NS as f64 * 1e-9 / f64::from(substeps);
        let radius_m = self.geometry.wheel_radius_m();
        for _ in 0..substeps {
            let middle_rad = self.sample.angles.pivot_rad + pivot_rate_rad_s * dt_s / 2.0;
            let twist = self.geometry.twist(unit_m_s, middle_rad, pivot_rate_rad_s);
            let spread_m_s =
                (twist.omega_rad_s + pivot_rate_rad_s) * self.geometry.wheel_separation_m / 2.0;
            self.pose = self.pose.advance(twist, dt_s);
            self.driven_m += twist.v_m_s.abs() * dt_s;
            self.sample.angles.left_rad += (unit_m_s - spread_m_s) / radius_m * dt_s;
            self.sample.angles.right_rad += (unit_m_s + spread_m_s) / radius_m * dt_s;
            self.sample.angles.pivot_rad += pivot_rate_rad_s * dt_s;
        }
        self.sample.stamp_ns += STEP_NS;
        self.sample
    }
}

fn started() -> (Encoders, DeadReckoning) {
    let encoders = Encoders::new();
    let mut dead_reckoning = DeadReckoning::new(encoders.geometry, 35.0).unwrap();
    dead_reckoning.update(&encoders.sample).unwrap();
    (encoders, dead_reckoning)
}

fn error_m(encoders: &Encoders, dead_reckoning: &DeadReckoning) -> f64 {
    let pose = dead_reckoning.odometry().pose;
    pose.position().distance_m(encoders.pose.position())
}

#[test]
fn follows_a_path_with_a_swinging_pivot() {
    let (mut encoders, mut dead_reckoning) = started();
    for step in 0..4000 {
        let rate = 1.5 * (f64::from(step) * 0.01).sin();
        let sample = encoders.step(0.4, rate);
        dead_reckoning.update(&sample).unwrap();
    }
    assert!(error_m(&encoders, &dead_reckoning) < 1e-3);
    let heading = dead_reckoning.odometry().pose.theta_rad - encoders.pose.theta_rad;
    assert!(wrap_angle(heading).abs() < 1e-3);
    assert!((dead_reckoning.odometry().distance_m - encoders.driven_m).abs() < 0.01);
}

#[test]
fn a_pivot_swung_at_standstill_turns_the_platform_by_a_few_degrees() {
    let (mut encoders, mut dead_reckoning) = started();
    for _ in 0..100 {
        let sample = encoders.step(0.0, PI);
        dead_reckoning.update(&sample).unwrap();
    }
    let turned = dead_reckoning.odometry().pose.theta_rad.to_degrees();
    assert!((2.0..4.0).contains(&turned), "{turned}");
}

#[test]
fn wrapping_encoders_make_no_difference() {
    let (mut encoders, mut dead_reckoning) = started();
    for _ in 0..2000 {
        let mut sample = encoders.step(0.3, 0.6);
        sample.angles.left_rad = wrap_angle(sample.angles.left_rad);
        sample.angles.right_rad = wrap_angle(sample.angles.right_rad);
        sample.angles.pivot_rad = wrap_angle(sample.angles.pivot_rad);
        dead_reckoning.update(&sample).unwrap();
    }
    assert!(error_m(&encoders, &dead_reckoning) < 1e-3);
    assert_eq!(dead_reckoning.counters().rejected(), 0);
}

#[test]
fn one_per_cent_between_the_wheels_barely_bends_the_path() {
    let (mut encoders, mut dead_reckoning) = started();
    for _ in 0..3000 {
        let mut sample = encoders.step(0.4, 0.0);
        sample.angles.left_rad *= 1.01;
        sample.angles.right_rad *= 0.99;
        dead_reckoning.update(&sample).unwrap();
    }
    assert!(dead_reckoning.odometry().pose.theta_rad.abs() < 1e-6);
    assert!(error_m(&encoders, &dead_reckoning) < 1e-6);
}

#[test]
fn a_jumping_wheel_is_rejected_once_and_bridged() {
    let (mut encoders, mut dead_reckoning) = started();
    let mut offset_rad = 0.0;
    for step in 0..400 {
        let mut sample = encoders.step(0.4, 0.0);
        if step == 200 {
            offset_rad = -2.0;
        }
        sample.angles.left_rad += offset_rad;
        let result = dead_reckoning.update(&sample);
        assert_eq!(result.is_err(), step == 200, "{result:?}");
    }
    assert_eq!(dead_reckoning.counters().jumps, 1);
    assert!(error_m(&encoders, &dead_reckoning) < 1e-3);
}

#[test]
fn a_jumping_pivot_is_told_from_a_turning_one() {
    let (mut encoders, mut dead_reckoning) = started();
    for step in 0..400 {
        let mut sample = encoders.step(0.4, 0.0);
        if step == 200 {
            sample.angles.pivot_rad += 0.3;
        }
        let _ = dead_reckoning.update(&sample);
    }
    assert_eq!(dead_reckoning.counters().jumps, 2);
    assert!(error_m(&encoders, &dead_reckoning) < 1e-3);
}

#[test]
fn time_that_runs_backwards_moves_nothing_until_it_stays_so() {
    let (mut encoders, mut dead_reckoning) = started();
    let first = encoders.step(0.4, 0.0);
    let second = encoders.step(0.4, 0.0);
    dead_reckoning.update(&second).unwrap();
    let before = *dead_reckoning.odometry();
    assert_eq!(
        dead_reckoning.update(&first),
        Err(OdometryFault::TimeBackwards { by_ns: STEP_NS })
    );
    assert_eq!(*dead_reckoning.odometry(), before);
    assert_eq!(dead_reckoning.update(&second), Ok(before));
    for _ in 0..BACKWARD_RUN {
        let _ = dead_reckoning.update(&first);
    }
    assert_eq!(dead_reckoning.odometry().stamp_ns, first.stamp_ns);
    assert_eq!(dead_reckoning.odometry().pose, before.pose);
}

#[test]
fn what_is_not_finite_or_too_late_is_counted() {
    let (mut encoders, mut dead_reckoning) = started();
    let mut sample = encoders.step(0.4, 0.0);
    sample.angles.pivot_rad = f64::NAN;
    assert!(dead_reckoning.update(&sample).is_err());
    sample.angles.pivot_rad = 0.0;
    sample.stamp_ns += 60_000_000_000;
    sample.angles.left_rad = 1e9;
    assert!(matches!(
        dead_reckoning.update(&sample),
        Err(OdometryFault::Gap { .. })
    ));
    assert_eq!(dead_reckoning.odometry().pose, Pose2::IDENTITY);
    assert_eq!(dead_reckoning.counters().rejected(), 2);
}

#[test]
fn what_the_wheels_did_while_nobody_listened_is_motion() {
    for gap_ns in [1_200_000_000, 20_000_000_000] {
        let (mut encoders, mut dead_reckoning) = started();
        let mut sample = encoders.step(0.4, 0.0);
        for _ in 0..40 {
            sample = encoders.step(0.4, 0.5);
        }
        // It rolled on, came to rest, and stood.
        sample.stamp_ns += gap_ns;
        dead_reckoning.update(&sample).expect("possible");
        let off_m = error_m(&encoders, &dead_reckoning);
        assert!(off_m < 2e-3, "{off_m} m");
        assert_eq!(dead_reckoning.counters().rejected(), 0);
    }
}

#[test]
fn impossible_geometry_is_refused() {
    let good = TricycleGeometry::default();
    let flat = TricycleGeometry {
        wheel_diameter_m: 0.0,
        ..good
    };
    assert!(DeadReckoning::new(flat, 35.0).is_err());
    let trailing = TricycleGeometry {
        caster_offset_m: 0.3,
        ..good
    };
    let message = trailing.validate().unwrap_err().to_string();
    assert!(
        message.starts_with("drive.caster_offset_m: found 0.3, expected below half"),
        "{message}"
    );
    assert!(DeadReckoning::new(good, f64::NAN).is_err());
}

#[test]
fn another_one_goes_on_from_what_was_reckoned_while_the_wheels_turned_on() {
    let (mut encoders, mut first) = started();
    for _ in 0..200 {
        first.update(&encoders.step(0.4, 0.3)).unwrap();
    }
    let left = *first.odometry();
    // The robot rolls out before the next process looks.
    let mut sample = encoders.sample;
    for _ in 0..100 {
        sample = encoders.step(0.1, 0.0);
    }
    let mut second = DeadReckoning::new(encoders.geometry, 35.0).unwrap();
    second.resume(&left);
    second.update(&sample).unwrap();
    for _ in 0..200 {
        second.update(&encoders.step(0.4, -0.3)).unwrap();
    }
    assert!(error_m(&encoders, &second) < 0.01);
    assert_eq!((left.breaks, second.odometry().breaks), (0, 0));
    assert!(second.odometry().distance_m > left.distance_m);
}

/// Pushed while no process ran: straight on, with a pivot that swung round, and farther than a drive rolls by itself.
#[test]
fn a_push_that_nobody_saw_is_told_by_its_length() {
    for (wheels_rad, pivot_rad, unmeasured_m) in [
        (20.0, 0.0, 0.0..0.001),
        (20.0, 1.5, 1.0..1.1),
        (60.0, 0.0, 3.0..3.3),
        (1e300, 0.0, 100.0..100.1),
    ] {
        for gap_ns in [3_000_000_000, 40_000_000_000] {
            let (mut encoders, mut first) = started();
            first.update(&encoders.step(0.4, 0.0)).expect("possible");
            let mut second = DeadReckoning::new(encoders.geometry, 35.0).expect("a vehicle");
            second.resume(first.odometry());
            let mut sample = encoders.sample;
            sample.stamp_ns += gap_ns;
            sample.angles.left_rad += wheels_rad;
            sample.angles.right_rad += wheels_rad;
            sample.angles.pivot_rad += pivot_rad;
            let _ = second.update(&sample);
            let found = second.odometry();
            assert!(unmeasured_m.contains(&found.unmeasured_m), "{found:?}");
            assert_eq!(found.breaks, u64::from(unmeasured_m.start > 0.0));
        }
    }
}

#[test]
fn a_way_that_was_not_measured_is_a_break() {
    let (mut encoders, mut dead_reckoning) = started();
    // A moment without power, on a short way; a longer way; a longer time.
    for (speed_m_s, steps, breaks) in [(0.2, 40, 0), (0.4, 40, 1), (0.0, 101, 2)] {
        for _ in 0..20 {
            dead_reckoning
                .update(&encoders.step(speed_m_s, 0.0))
                .unwrap();
        }
        let before = *dead_reckoning.odometry();
        dead_reckoning.rebase();
        for _ in 0..steps {
            encoders.step(speed_m_s, 0.0);
        }
        dead_reckoning.update(&encoders.sample).unwrap();
        let after = dead_reckoning.odometry();
        assert_eq!(after.breaks, breaks, "{speed_m_s} m/s");
        let reckoned_m = before.pose.between(after.pose).position().norm_m();
        let doubted_m = after.unmeasured_m - before.unmeasured_m;
        if breaks == 0 {
            let half_m = 0.5 * speed_m_s * f64::from(steps) * (STEP_NS as f64 * 1e-9);
            assert!((reckoned_m - half_m).abs() < 1e-4, "{reckoned_m} m");
            assert!((doubted_m - half_m).abs() < 1e-4, "{doubted_m} m");
        } else {
            assert_eq!((reckoned_m, doubted_m), (0.0, 0.0), "nothing is known");
        }
    }
    // Encoders that counted from zero again, and nobody said so.
    encoders.sample.stamp_ns += 10_000_000_000;
    encoders.sample.angles.left_rad += 1e4;
    assert!(dead_reckoning.update(&encoders.sample).is_err());
    assert_eq!(dead_reckoning.odometry().breaks, 3);
    // A jump within a cycle is bridged.
    encoders.sample.angles.left_rad += 10.0;
    assert!(dead_reckoning.update(&encoders.step(0.4, 0.0)).is_err());
    assert_eq!(dead_reckoning.odometry().breaks, 3);
    // Before the first sample nothing can break.
    let mut fresh = DeadReckoning::new(encoders.geometry, 35.0).unwrap();
    fresh.rebase();
    assert_eq!(fresh.odometry().breaks, 0);
}

/// Of a turn on a short way the angle counts.
#[test]
fn a_turn_without_power_for_a_moment_is_half_reckoned_and_half_doubted() {
    let (mut encoders, mut dead_reckoning) = started();
    for _ in 0..600 {
        dead_reckoning.update(&encoders.step(0.05, 0.0)).unwrap();
        dead_reckoning.update(&encoders.step(0.05, 0.8)).unwrap();
    }
    let before = *dead_reckoning.odometry();
    assert!(before.twist.omega_rad_s.abs() > 0.1, "{before:?}");
    dead_reckoning.rebase();
    encoders.sample.stamp_ns += 100_000_000;
    dead_reckoning.update(&encoders.sample).unwrap();
    let after = dead_reckoning.odometry();
    let turned_rad = before.pose.between(after.pose).theta_rad;
    let half_rad = 0.5 * 0.1 * before.twist.omega_rad_s;
    assert!((turned_rad - half_rad).abs() < 1e-3, "{turned_rad} rad");
    let doubted_rad = after.unmeasured_m - before.unmeasured_m;
    assert!(
        (doubted_rad - half_rad.abs()).abs() < 1e-3,
        "{doubted_rad} rad"
    );
    assert_eq!(after.breaks, before.breaks);
}

/// Drives a swinging path with wheels whose encoders say more than they roll, from `begin_m` on; returns the way after which
/// slip was seen.
fn seen_after_m(dead_reckoning: &mut DeadReckoning, shares: [f64; 2], begin_m: f64) -> Option<f64> {
    let mut encoders = Encoders::new();
    let mut said = encoders.sample;
    for step in 0..4000 {
        let before = encoders.sample.angles;
        let rate = 1.5 * (f64::from(step) * 0.01).sin();
        let sample = encoders.step(0.4, rate);
        let slips = encoders.driven_m >= begin_m;
        let [left, right] = shares.map(|share| if slips { 1.0 / (1.0 - share) } else { 1.0 });
        said.stamp_ns = sample.stamp_ns;
        said.angles.left_rad += left * (sample.angles.left_rad - before.left_rad);
        said.angles.right_rad += right * (sample.angles.right_rad - before.right_rad);
        said.angles.pivot_rad = sample.angles.pivot_rad;
        dead_reckoning.update(&said).unwrap();
        if dead_reckoning.slips() {
            return Some(encoders.driven_m - begin_m);
        }
    }
    None
}

#[test]
fn wheels_that_slip_are_seen_soon_and_worn_ones_are_not_taken_for_it() {
    let fresh = || DeadReckoning::new(TricycleGeometry::default(), 35.0).unwrap();
    for worn in [[0.01, -0.01], [-0.01, 0.01], [0.01, 0.0]] {
        assert_eq!(seen_after_m(&mut fresh(), worn, 0.0), None, "{worn:?}");
    }
    for (shares, within_m) in [
        ([0.30, 0.15], 0.10),
        ([0.15, 0.30], 0.10),
        ([0.0, 0.2], 0.10),
        ([0.10, 0.0], 0.20),
    ] {
        let mut dead_reckoning = fresh();
        let seen_m = seen_after_m(&mut dead_reckoning, shares, 1.0);
        assert!(
            seen_m.is_some_and(|way_m| way_m < within_m),
            "{shares:?}: {seen_m:?}"
        );
        // What may not have been driven is about what was not.
        let off_m = dead_reckoning.odometry().distance_m - 1.0 - seen_m.unwrap_or(0.0);
        let slipped_m = dead_reckoning.odometry().slipped_m;
        assert!(
            slipped_m > 0.5 * off_m,
            "{shares:?}: {slipped_m} of {off_m}"
        );
        // The one that slips more, and what it has turned beyond the other.
        let slip = dead_reckoning.slip().expect("it was just seen");
        assert_eq!(slip.right, shares[1] > shares[0], "{shares:?}: {slip}");
        let beyond = slip.found_m / slip.expected_m;
        assert!((1.02..1.3).contains(&beyond), "{shares:?}: {slip}");
        dead_reckoning.forget_slip();
        assert!(!dead_reckoning.slips() && dead_reckoning.slip().is_none());
    }
}
