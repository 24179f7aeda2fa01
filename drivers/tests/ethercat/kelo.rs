//! The drive's process data, end to end: what the robot asks is what the wheels do, and what they do is reported.

use crate::support::{SegmentLink, expectation};
use description::wheels::WheelSpeeds;
use drivers::ethercat::{BringUpOptions, Bus, Expectation};
use drivers::kelo::{
    Faults, Feedback, Inputs, Setpoint, SetpointLimits, StampWatch, VoltageLimits,
};
use sim::kelo::{DriveHandle, KeloOptions, SimulatedDrive};
use sim::plant::TestStand;
use std::time::Duration;

const LIMITS: VoltageLimits = VoltageLimits {
    min_v: 20.0,
    max_v: 32.0,
};

struct Stand {
    link: SegmentLink,
    bus: Bus,
    drive: DriveHandle,
}

impl Stand {
    fn new() -> Stand {
        let simulated = SimulatedDrive::new(Box::new(TestStand::new()), KeloOptions::default());
        let expected = Expectation {
            vendor_id: sim::kelo::VENDOR_ID,
            ..expectation()
        };
        let link = SegmentLink::new(simulated.segment);
        let bus = Bus::bring_up(link.boxed(), &expected, BringUpOptions::default()).unwrap();
        assert_eq!(bus.identity().name, "KELO Drive");
        Stand {
            link,
            bus,
            drive: simulated.drive,
        }
    }

    /// Holds a setpoint for a time and returns what was reported last.
    fn hold(&mut self, setpoint: Setpoint, time: Duration) -> Inputs {
        let outputs = setpoint.to_outputs(&SetpointLimits::default()).to_bytes();
        let mut inputs = [0; 172];
        let end_ns = self.link.now_ns() + time.as_nanos() as u64;
        while self.link.now_ns() < end_ns {
            let deadline_ns = self.link.in_us(20_000);
            self.bus
                .exchange(&outputs, &mut inputs, deadline_ns)
                .unwrap();
            self.link.pass(Duration::from_millis(1));
        }
        Inputs::from_bytes(&inputs)
    }
}

fn speeds(left_rad_s: f32, right_rad_s: f32) -> Setpoint {
    Setpoint::Speeds {
        speeds: WheelSpeeds::new(f64::from(left_rad_s), f64::from(right_rad_s)),
        current_a: 20.0,
    }
}

#[test]
fn each_wheel_turns_as_asked_and_says_so() {
    let mut stand = Stand::new();
    for (left, right) in [(4.0, 4.0), (3.0, -5.0), (0.0, 2.0), (-1.0, -1.5)] {
        let before = Feedback::from(&stand.hold(speeds(left, right), Duration::from_millis(200)));
        assert!((before.left_rad_s - left).abs() < 0.1, "{before:?}");
        assert!((before.right_rad_s - right).abs() < 0.1, "{before:?}");
        assert!(before.enabled);
        let asked = stand.drive.statistics();
        assert_eq!(asked.last_rad_s, (f64::from(left), f64::from(right)));
        assert_eq!(asked.max_current_a, 20.0);
        // Angles run the same way as speeds.
        let after = Feedback::from(&stand.hold(speeds(left, right), Duration::from_millis(50)));
        for (speed, from, to) in [
            (left, before.left_rad, after.left_rad),
            (right, before.right_rad, after.right_rad),
        ] {
            assert!(
                speed * (to - from) >= 0.0 && (speed == 0.0 || to != from),
                "{speed}: {from} to {to}"
            );
        }
    }
}

#[test]
fn the_drive_never_sees_what_it_must_not() {
    let mut stand = Stand::new();
    // Bring-up itself writes zeros.
    stand.drive.reset_statistics();
    for (left, right) in [(100.0, -100.0), (f32::NAN, f32::INFINITY), (0.009, -0.009)] {
        stand.hold(speeds(left, right), Duration::from_millis(5));
    }
    let seen = stand.drive.statistics();
    assert_eq!(
        (
            seen.over_speed,
            seen.not_finite,
            seen.torque,
            seen.emergency
        ),
        (0, 0, 0, 0)
    );
    assert_eq!((seen.left_rad_s.max, seen.right_rad_s.min), (35.0, -35.0));
    assert_eq!(seen.last_rad_s, (0.0, 0.0));
}

#[test]
fn off_and_emergency_take_the_power_from_the_wheels() {
    let mut stand = Stand::new();
    for stop in [Setpoint::Off, Setpoint::Emergency { current_a: 1.0 }] {
        let driving = Feedback::from(&stand.hold(speeds(2.0, 2.0), Duration::from_millis(100)));
        assert!(driving.enabled);
        let stopped = Feedback::from(&stand.hold(stop, Duration::from_millis(200)));
        assert!(!stopped.enabled);
        assert_eq!((stopped.left_rad_s, stopped.right_rad_s), (0.0, 0.0));
    }
    assert!(stand.drive.statistics().emergency > 0);
}

#[test]
fn health_is_judged_by_what_the_drive_reports() {
    let mut stand = Stand::new();
    let mut look = |prepare: &dyn Fn(&DriveHandle)| {
        prepare(&stand.drive);
        let inputs = stand.hold(speeds(1.0, 1.0), Duration::from_millis(20));
        stand.drive.clear_faults();
        Faults::of(&inputs, LIMITS)
    };
    assert_eq!(
        look(&|_| {}),
        Faults::NONE,
        "although the undervoltage bit is set"
    );
    assert_eq!(
        look(&|drive| drive.set_bus_voltage(Some(17.0))),
        Faults::UNDERVOLTAGE
    );
    assert_eq!(
        look(&|drive| drive.set_bus_voltage(Some(40.0))),
        Faults::OVERVOLTAGE
    );
    assert_eq!(
        look(&|drive| drive.set_status1_bits(0x0080, 0)),
        Faults::OVERCURRENT_1
    );
    assert_eq!(
        look(&|drive| drive.set_status1_bits(0x0400, 0)),
        Faults::OVERTEMPERATURE_2
    );
    assert_eq!(
        look(&|drive| drive.set_status1_bits(0, 0x0010)),
        Faults::ENCODER
    );
    assert_eq!(look(&|_| {}), Faults::NONE);
}

#[test]
fn sensors_that_freeze_are_noticed_by_their_stamp() {
    let mut stand = Stand::new();
    let mut watch = StampWatch::new();
    let mut stalled_ns = |stand: &mut Stand| {
        let inputs = stand.hold(speeds(1.0, 1.0), Duration::from_millis(20));
        watch.stalled_ns(inputs.sensor_stamp_ns, stand.link.now_ns())
    };
    assert_eq!(stalled_ns(&mut stand), 0);
    assert_eq!(stalled_ns(&mut stand), 0);
    stand.drive.freeze_sensors(true);
    stalled_ns(&mut stand);
    assert!(stalled_ns(&mut stand) >= 19_000_000);
    stand.drive.freeze_sensors(false);
    assert_eq!(stalled_ns(&mut stand), 0);
    // Distributed-clock time was set to our clock at bring-up.
    let sensor_ns = stand
        .hold(speeds(1.0, 1.0), Duration::from_millis(5))
        .sensor_stamp_ns;
    assert!(
        stand.link.now_ns().abs_diff(sensor_ns) < 1_000_000_000,
        "{sensor_ns}"
    );
}
