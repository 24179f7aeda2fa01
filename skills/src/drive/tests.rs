use super::*;
use description::geometry::Pose2;
use proptest::prelude::*;

const DT_S: f64 = 0.005;

/// Ideal unit: wheels do at once what they are told.
struct Unit {
    geometry: TricycleGeometry,
    controller: WheelController,
    wheels: WheelSpeeds,
    pivot_rad: f64,
    pose: Pose2,
    v_m_s: f64,
}

impl Unit {
    fn new() -> Self {
        let geometry = TricycleGeometry::default();
        Self {
            geometry,
            controller: WheelController::new(geometry, DriveLimits::default(), Control::default())
                .unwrap(),
            wheels: WheelSpeeds::default(),
            pivot_rad: 0.0,
            pose: Pose2::IDENTITY,
            v_m_s: 0.0,
        }
    }

    fn step(&mut self, command: MotionCommand, stop: StopKind) {
        self.wheels = self
            .controller
            .step(command, stop, self.pivot_rad, self.wheels, DT_S);
        let radius_m = self.geometry.wheel_radius_m();
        let unit_m_s = radius_m * (self.wheels.left_rad_s + self.wheels.right_rad_s) / 2.0;
        let turn_rad_s = radius_m * (self.wheels.right_rad_s - self.wheels.left_rad_s)
            / self.geometry.wheel_separation_m;
        let (sin, cos) = self.pivot_rad.sin_cos();
        let caster_m = self.geometry.caster_offset_m;
        let omega_rad_s =
            (unit_m_s * sin + caster_m * turn_rad_s * cos) / self.geometry.wheelbase_m;
        let twist = description::geometry::Twist2::new(
            unit_m_s * cos - caster_m * turn_rad_s * sin,
            omega_rad_s,
        );
        self.v_m_s = twist.v_m_s;
        self.pose = self.pose.advance(twist, DT_S);
        self.pivot_rad = wrap_angle(self.pivot_rad + (turn_rad_s - omega_rad_s) * DT_S);
    }
}

#[test]
fn drives_the_circle_that_was_asked_for() {
    let mut unit = Unit::new();
    let command = MotionCommand::new(0.3, 2.0);
    for _ in 0..400 {
        unit.step(command, StopKind::None);
    }
    let start = unit.pose;
    assert!((unit.v_m_s - 0.3).abs() < 0.005, "{}", unit.v_m_s);
    let centre = start.transform(description::geometry::Point2::new(0.0, 0.5));
    for _ in 0..1000 {
        unit.step(command, StopKind::None);
        let radius_m = unit.pose.position().distance_m(centre);
        assert!((radius_m - 0.5).abs() < 0.01, "{radius_m}");
    }
}

#[test]
fn keeps_to_acceleration_and_both_decelerations() {
    for (stop, slope_m_s2) in [(StopKind::Gentle, 0.8), (StopKind::Hard, 2.0)] {
        let mut unit = Unit::new();
        let mut before = 0.0;
        for _ in 0..400 {
            unit.step(MotionCommand::new(0.4, 0.0), StopKind::None);
            assert!(unit.v_m_s - before <= 0.5 * DT_S + 1e-9);
            before = unit.v_m_s;
        }
        assert!((unit.v_m_s - 0.4).abs() < 1e-9);
        let mut steps = 0;
        while unit.v_m_s > 0.0 {
            unit.step(MotionCommand::new(0.4, 0.0), stop);
            assert!(before - unit.v_m_s <= slope_m_s2 * DT_S + 1e-9);
            before = unit.v_m_s;
            steps += 1;
        }
        let expected = 0.4 / slope_m_s2 / DT_S;
        assert!(
            (f64::from(steps) - expected).abs() < 3.0,
            "{steps} {expected}"
        );
    }
}

#[test]
fn turns_the_pivot_before_it_drives_off() {
    let mut unit = Unit::new();
    unit.pivot_rad = 2.5;
    for _ in 0..600 {
        let before = unit.pivot_rad;
        unit.step(MotionCommand::new(0.4, 0.0), StopKind::None);
        if before.abs() > 1.6 {
            assert!(unit.controller.unit_speed_m_s() == 0.0);
        }
    }
    assert!(unit.pivot_rad.abs() < 0.01 && (unit.v_m_s - 0.4).abs() < 0.01);
}

#[test]
fn stopping_in_a_curve_holds_the_pivot() {
    let mut unit = Unit::new();
    for _ in 0..400 {
        unit.step(MotionCommand::new(0.4, 2.0), StopKind::None);
    }
    let pivot_rad = unit.pivot_rad;
    assert!(pivot_rad > 0.4);
    for _ in 0..100 {
        unit.step(MotionCommand::STOP, StopKind::Hard);
    }
    assert!((unit.pivot_rad - pivot_rad).abs() < 0.01);
    assert_eq!(unit.wheels, WheelSpeeds::default());
}

#[test]
fn standing_still_turns_no_pivot() {
    let mut unit = Unit::new();
    unit.pivot_rad = 1.0;
    for _ in 0..100 {
        unit.step(MotionCommand::new(0.0, -2.0), StopKind::None);
    }
    assert_eq!((unit.pivot_rad, unit.wheels), (1.0, WheelSpeeds::default()));
}

#[test]
fn goes_backwards_too_and_through_standstill() {
    let mut unit = Unit::new();
    for _ in 0..300 {
        unit.step(MotionCommand::new(0.3, 0.0), StopKind::None);
    }
    for _ in 0..600 {
        unit.step(MotionCommand::new(-0.3, 0.5), StopKind::None);
    }
    assert!((unit.v_m_s + 0.3).abs() < 0.005, "{}", unit.v_m_s);
    assert!((unit.pivot_rad - unit.controller.steering_for(0.5)).abs() < 0.02);
}

#[test]
fn the_ramp_waits_for_wheels_that_do_not_follow() {
    let mut unit = Unit::new();
    for _ in 0..400 {
        unit.step(MotionCommand::new(0.4, 0.0), StopKind::None);
        unit.wheels = WheelSpeeds::default();
    }
    assert!(unit.controller.unit_speed_m_s() <= RAMP_AHEAD_M_S + 0.5 * DT_S + 1e-9);
}

#[test]
fn impossible_limits_are_refused() {
    let limits = DriveLimits {
        max_steering_rad: 1.6,
        ..DriveLimits::default()
    };
    assert!(WheelController::new(TricycleGeometry::default(), limits, Control::default()).is_err());
    let limits = DriveLimits {
        acceleration_m_s2: f64::NAN,
        ..DriveLimits::default()
    };
    assert!(limits.validate().is_err());
}

proptest! {
    #[test]
    fn no_wheel_is_ever_asked_for_more_than_its_limit(
        steps in prop::collection::vec((any::<f64>(), any::<f64>(), any::<f64>(), any::<f64>(), 0u8..4, any::<f64>()), 1..60),
        limit in 1.0..35.0f64,
    ) {
        let limits = DriveLimits { max_wheel_speed_rad_s: limit, max_speed_m_s: 3.0, ..DriveLimits::default() };
        let mut controller = WheelController::new(TricycleGeometry::default(), limits, Control::default()).unwrap();
        for (speed, curvature, pivot, measured, stop, dt) in steps {
            let stop = [StopKind::None, StopKind::None, StopKind::Gentle, StopKind::Hard][usize::from(stop)];
            let wheels = WheelSpeeds { left_rad_s: measured, right_rad_s: -measured * 0.5 };
            let out = controller.step(MotionCommand::new(speed, curvature), stop, pivot, wheels, dt);
            prop_assert!(out.left_rad_s.abs() <= limit && out.right_rad_s.abs() <= limit, "{out:?}");
        }
    }
}
