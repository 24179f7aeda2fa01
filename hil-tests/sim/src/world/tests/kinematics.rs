use std::f64::consts::FRAC_PI_2;

use super::*;

const RADIUS_M: f64 = 0.0525;
const TAU_S: f64 = 0.015;

/// How far a first-order lag has come after `time_s` on its way at `speed`.
fn lagged(speed: f64, time_s: f64) -> f64 {
    speed * (time_s - TAU_S * (1.0 - (-time_s / TAU_S).exp()))
}

#[test]
fn straight_ahead_is_a_first_order_lag() {
    let mut world = world(vec![], vec![exact_robot("a", Pose::default())]);
    drive(&mut world, 0, &wheels(8.0, 8.0), 400);
    let truth = world.truth(0).unwrap();
    let expected_m = lagged(8.0 * RADIUS_M, 0.4);
    assert!(
        (truth.pose.x_m - expected_m).abs() < 2e-4,
        "{truth:?} {expected_m}"
    );
    assert_eq!((truth.pose.y_m, truth.pose.theta_rad), (0.0, 0.0));
    assert!((truth.twist.v_m_s - 0.42).abs() < 1e-6);
    assert!((truth.distance_m - truth.pose.x_m).abs() < 1e-9);
}

#[test]
fn steady_steering_drives_a_circle() {
    let (pivot_rad, unit_m_s) = (0.6f64, 0.4);
    let mut robot = exact_robot("a", Pose::default());
    robot.start_pivot_rad = pivot_rad;
    let (l, s, d) = (0.25, 0.01, 0.0775);
    // The pivot stands still when the unit turns as fast as the platform.
    let omega = unit_m_s * pivot_rad.sin() / (l - s * pivot_rad.cos());
    let v = unit_m_s * pivot_rad.cos() - s * omega * pivot_rad.sin();
    let half = 0.5 * omega * d;
    let command = wheels((unit_m_s - half) / RADIUS_M, (unit_m_s + half) / RADIUS_M);
    let mut world = world(vec![], vec![robot]);
    drive(&mut world, 0, &command, 5000);
    let truth = world.truth(0).unwrap();
    let turned_rad = lagged(omega, 5.0);
    let radius_m = v / omega;
    let expected = Pose::new(
        radius_m * turned_rad.sin(),
        radius_m * (1.0 - turned_rad.cos()),
        turned_rad,
    );
    assert!((truth.pivot_rad - pivot_rad).abs() < 1e-6, "{truth:?}");
    assert!(
        (truth.pose.theta_rad - expected.theta_rad).abs() < 1e-3,
        "{truth:?} {expected:?}"
    );
    assert!(
        (truth.pose.x_m - expected.x_m).abs() < 1e-3,
        "{truth:?} {expected:?}"
    );
    assert!(
        (truth.pose.y_m - expected.y_m).abs() < 1e-3,
        "{truth:?} {expected:?}"
    );
}

#[test]
fn swinging_the_pivot_turns_the_platform_a_little() {
    let mut world = world(vec![], vec![exact_robot("a", Pose::default())]);
    let swing = wheels(-2.0, 2.0);
    while world.truth(0).unwrap().pivot_rad < FRAC_PI_2 {
        drive(&mut world, 0, &swing, 1);
    }
    let truth = world.truth(0).unwrap();
    // dθ/dδ = s·cos δ / (L − s·cos δ), summed up to the pivot angle reached.
    let (n, mut expected_rad) = (10_000, 0.0);
    for i in 0..n {
        let step_rad = truth.pivot_rad / f64::from(n);
        let cos = ((f64::from(i) + 0.5) * step_rad).cos();
        expected_rad += step_rad * 0.01 * cos / (0.25 - 0.01 * cos);
    }
    assert!(
        (truth.pose.theta_rad - expected_rad).abs() < 1e-5,
        "{truth:?} {expected_rad}"
    );
    assert!((2.0..4.0).contains(&truth.pose.theta_rad.to_degrees()));
}

#[test]
fn without_power_friction_stops_it() {
    let mut world = world(vec![], vec![exact_robot("a", Pose::default())]);
    drive(&mut world, 0, &wheels(8.0, 8.0), 400);
    let before = world.truth(0).unwrap();
    drive(&mut world, 0, &DriveCommand::OFF, 1000);
    let after = world.truth(0).unwrap();
    let braking_m = before.twist.v_m_s.powi(2) / (2.0 * 1.5);
    assert_eq!(after.twist.v_m_s, 0.0);
    assert!((after.pose.x_m - before.pose.x_m - braking_m).abs() < 1e-3);
}

#[test]
fn a_drive_that_is_silent_loses_power() {
    let mut world = world(vec![], vec![exact_robot("a", Pose::default())]);
    drive(&mut world, 0, &wheels(8.0, 8.0), 100);
    let from_ns = world.now_ns();
    world.advance_to(from_ns + 490 * MS);
    assert!(world.truth(0).unwrap().twist.v_m_s > 0.4);
    world.advance_to(from_ns + 1000 * MS);
    assert_eq!(world.truth(0).unwrap().twist.v_m_s, 0.0);
}

#[test]
fn current_bounds_acceleration_and_speed_is_clipped() {
    let mut world = world(vec![], vec![exact_robot("a", Pose::default())]);
    let mut command = wheels(1000.0, 1000.0);
    command.left_current_limit_a = 1.0;
    command.right_current_limit_a = 1.0;
    drive(&mut world, 0, &command, 100);
    let feedback = world.exchange(0, world.now_ns(), &command);
    assert!((feedback.left_rad_s - 5.0).abs() < 1e-9, "{feedback:?}");
    assert!((feedback.left_current_a - 1.0).abs() < 1e-9, "{feedback:?}");
    drive(&mut world, 0, &wheels(1000.0, 1000.0), 1000);
    let feedback = world.exchange(0, world.now_ns(), &command);
    assert!((feedback.left_rad_s - 35.0).abs() < 1e-6, "{feedback:?}");
}

#[test]
fn commands_that_are_no_numbers_do_no_harm() {
    let mut world = world(vec![], vec![exact_robot("a", Pose::default())]);
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut command = wheels(value, value);
        command.left_current_limit_a = value;
        drive(&mut world, 0, &command, 50);
    }
    assert!(world.truth(0).unwrap().pose.is_finite());
}

#[test]
fn wheels_err_by_up_to_a_percent_and_encoders_do_not_know() {
    let mut errs = vec![];
    for seed in 0..50 {
        let mut world = World::new(WorldConfig {
            seed,
            robots: vec![RobotModel::new("a", Pose::default())],
            ..WorldConfig::default()
        })
        .unwrap();
        let [left_m, right_m] = world.wheel_radii_m(0).unwrap();
        errs.extend([left_m / RADIUS_M - 1.0, right_m / RADIUS_M - 1.0]);
        assert_ne!(left_m, right_m);
        world.advance_to(START_NS);
        let command = wheels(8.0 * RADIUS_M / left_m, 8.0 * RADIUS_M / right_m);
        drive(&mut world, 0, &command, 500);
        let truth = world.truth(0).unwrap();
        let feedback = world.exchange(0, world.now_ns(), &command);
        assert!((feedback.left_rad * left_m - truth.pose.x_m).abs() < 1e-9);
        assert!((feedback.right_rad * right_m - truth.pose.x_m).abs() < 1e-9);
    }
    assert!(errs.iter().all(|err| err.abs() <= 0.01));
    assert!(errs.iter().any(|err| *err > 0.005) && errs.iter().any(|err| *err < -0.005));
}
