use super::demand::drive_command;
use super::pdo::{self, Outputs};
use super::*;
use crate::ethercat::al::AlState;
use crate::ethercat::{Application, Cycle};
use crate::plant::TestStand;

const MS: u64 = 1_000_000;

fn bytes(command1: u16, setpoints: [f32; 2], limits: [f32; 2]) -> [u8; pdo::OUTPUT_BYTES] {
    let mut bytes = [0; pdo::OUTPUT_BYTES];
    bytes[..2].copy_from_slice(&command1.to_le_bytes());
    let floats = [
        setpoints[0],
        setpoints[1],
        limits[0],
        -limits[0],
        limits[1],
        -limits[1],
    ];
    for (i, value) in floats.into_iter().enumerate() {
        bytes[4 + 4 * i..8 + 4 * i].copy_from_slice(&value.to_le_bytes());
    }
    bytes
}

struct Bench {
    kelo: Kelo,
    now_ns: u64,
    inputs: [u8; pdo::INPUT_BYTES],
}

impl Bench {
    fn new() -> Bench {
        let kelo = Kelo::new(Box::new(TestStand::new()), KeloOptions::default());
        Bench {
            kelo,
            now_ns: MS,
            inputs: [0; pdo::INPUT_BYTES],
        }
    }

    /// Cycles of 1 ms with these outputs.
    fn run(&mut self, milliseconds: u32, outputs: Option<&[u8]>) {
        for _ in 0..milliseconds {
            self.now_ns += MS;
            self.kelo.cycle(Cycle {
                now_ns: self.now_ns,
                system_time_ns: self.now_ns + 7,
                state: AlState::Op,
                outputs,
                outputs_are_new: outputs.is_some(),
                inputs: &mut self.inputs,
            });
        }
    }

    fn float(&self, at: usize) -> f32 {
        f32::from_le_bytes(self.inputs[at..at + 4].try_into().unwrap())
    }

    fn time(&self, at: usize) -> u64 {
        u64::from_le_bytes(self.inputs[at..at + 8].try_into().unwrap())
    }

    fn status(&self) -> (u16, u16) {
        let word = |at: usize| u16::from_le_bytes([self.inputs[at], self.inputs[at + 1]]);
        (word(0), word(2))
    }
}

/// Velocity mode, both motors enabled.
const DRIVE: u16 = 0x000B;

#[test]
fn driving_forward_motor_1_turns_negative() {
    let mut bench = Bench::new();
    bench.run(200, Some(&bytes(DRIVE, [-5.0, 5.0], [20.0, 20.0])));
    assert!(bench.float(20) < -0.8 && bench.float(68) > 0.8, "encoders");
    assert!(
        (bench.float(24) + 5.0).abs() < 0.05 && (bench.float(72) - 5.0).abs() < 0.05,
        "speeds"
    );
    assert_eq!(bench.status(), (63, 2051));
    assert_eq!(
        (bench.time(4), bench.time(12)),
        (bench.now_ns + 7, bench.now_ns + 7)
    );
    let statistics = bench.kelo.handle().statistics();
    assert_eq!(
        (statistics.left_rad_s.max, statistics.right_rad_s.max),
        (5.0, 5.0)
    );
    assert_eq!(
        (statistics.setpoints, statistics.max_current_a),
        (200, 20.0)
    );
}

#[test]
fn without_outputs_the_wheels_roll_out() {
    let mut bench = Bench::new();
    bench.run(200, Some(&bytes(DRIVE, [-5.0, 5.0], [20.0, 20.0])));
    let setpoint_ts = bench.time(12);
    bench.run(400, None);
    assert_eq!((bench.float(24).abs(), bench.float(72)), (0.0, 0.0));
    assert_eq!(bench.status(), (60, 2051));
    assert_eq!(
        bench.time(12),
        setpoint_ts,
        "no setpoint, no new time stamp"
    );
    assert_eq!(bench.time(4), bench.now_ns + 7, "sensors go on");
}

#[test]
fn limits_modes_and_signs() {
    let mut outputs = Outputs::decode(&bytes(DRIVE, [3.0, 4.0], [20.0, 10.0]));
    let velocity = drive_command(&outputs);
    assert_eq!((velocity.left_rad_s, velocity.right_rad_s), (4.0, -3.0));
    assert_eq!(
        (
            velocity.left_current_limit_a,
            velocity.right_current_limit_a
        ),
        (10.0, 20.0)
    );
    outputs.command1 = 0x000F;
    let differential = drive_command(&outputs);
    assert_eq!(
        (differential.left_rad_s, differential.right_rad_s),
        (-1.0, 7.0)
    );
    outputs.command1 = 0x0003;
    let torque = drive_command(&outputs);
    assert_eq!((torque.left_rad_s, torque.right_rad_s), (10.0, -20.0));
    assert_eq!(
        (torque.left_current_limit_a, torque.right_current_limit_a),
        (4.0, 3.0)
    );
    outputs.command1 = 0x0007;
    let differential = drive_command(&outputs);
    assert_eq!(
        (differential.left_rad_s, differential.right_rad_s),
        (-30.0, 30.0)
    );
    assert_eq!(differential.right_current_limit_a, 7.0);
    // A lower limit on the wrong side leaves no current.
    outputs.command1 = DRIVE;
    outputs.lower = [20.0, f32::NAN];
    assert_eq!(drive_command(&outputs).right_current_limit_a, 0.0);
}

#[test]
fn a_current_limit_holds_the_wheels_back() {
    let mut bench = Bench::new();
    bench.run(100, Some(&bytes(DRIVE, [-30.0, 30.0], [1.0, 1.0])));
    assert!(
        bench.float(72) > 4.0 && bench.float(72) < 5.5,
        "{}",
        bench.float(72)
    );
    assert!(bench.float(68 + 12) <= 1.0 + 1e-3, "torque current");
}

#[test]
fn violations_are_recorded_and_never_reach_a_motor() {
    let mut bench = Bench::new();
    bench.run(1, Some(&bytes(DRIVE, [-60.0, 40.0], [20.0, 20.0])));
    bench.run(1, Some(&bytes(DRIVE, [f32::NAN, 1.0], [20.0, 20.0])));
    bench.run(1, Some(&bytes(DRIVE, [1.0, 1.0], [f32::INFINITY, 20.0])));
    let s = bench.kelo.handle().statistics();
    assert_eq!((s.left_rad_s.max, s.right_rad_s.magnitude()), (40.0, 60.0));
    assert_eq!((s.over_speed, s.not_finite, s.setpoints), (1, 2, 3));
    assert!(bench.float(20).is_finite() && bench.float(24).is_finite());
    bench.run(500, Some(&bytes(DRIVE, [-60.0, 60.0], [20.0, 20.0])));
    assert!((bench.float(72) - 35.0).abs() < 0.1, "{}", bench.float(72));
    bench.kelo.handle().reset_statistics();
    assert_eq!(bench.kelo.handle().statistics(), DriveStatistics::default());
}

#[test]
fn emergency_bits_button_faults_and_supply_take_the_power() {
    let mut bench = Bench::new();
    let handle = bench.kelo.handle();
    let drive = bytes(DRIVE, [-5.0, 5.0], [20.0, 20.0]);
    bench.run(1, Some(&bytes(DRIVE | 0x10, [-5.0, 5.0], [20.0, 20.0])));
    assert_eq!(bench.status().0, 62, "motor 1 stopped");
    handle.set_emergency_stop(true);
    bench.run(1, Some(&drive));
    assert_eq!(bench.status().0, 60);
    handle.clear_faults();
    handle.set_status1_bits(0x0400, 0x0010);
    bench.run(1, Some(&drive));
    assert_eq!(bench.status().0, 63 & !2 & !0x10 | 0x400);
    handle.clear_faults();
    for (volts, status) in [(12.0, 60), (70.0, 124), (20.0, 63)] {
        handle.set_bus_voltage(Some(volts));
        bench.run(1, Some(&drive));
        assert_eq!((bench.float(124), bench.status().0), (volts as f32, status));
    }
    handle.set_status2(Some(7));
    bench.run(1, Some(&drive));
    assert_eq!(bench.status().1, 7);
    handle.clear_faults();
    bench.run(1, Some(&drive));
    assert_eq!((bench.float(124), bench.status()), (24.0, (63, 2051)));
}

#[test]
fn frozen_sensors_keep_their_time_stamp() {
    let mut bench = Bench::new();
    let drive = bytes(DRIVE, [-5.0, 5.0], [20.0, 20.0]);
    bench.run(10, Some(&drive));
    bench.kelo.handle().freeze_sensors(true);
    bench.run(1, Some(&drive));
    let (time, angle) = (bench.time(4), bench.float(68));
    bench.run(10, Some(&drive));
    assert_eq!((bench.time(4), bench.float(68)), (time, angle));
    bench.kelo.handle().freeze_sensors(false);
    bench.run(1, Some(&drive));
    assert!(bench.time(4) > time && bench.float(68) > angle);
}

#[test]
fn timed_setpoints_wait_for_their_time() {
    let mut bench = Bench::new();
    let mut timed = bytes(DRIVE | 0x8000, [-5.0, 5.0], [20.0, 20.0]);
    timed[28..].copy_from_slice(&(bench.now_ns + 5 * MS).to_le_bytes());
    bench.run(4, Some(&timed));
    assert_eq!(bench.status().0, 60);
    bench.run(2, Some(&timed));
    assert_eq!(bench.status().0, 63);
}

#[test]
fn after_power_on_wheel_encoders_start_at_zero() {
    let mut bench = Bench::new();
    bench.run(100, Some(&bytes(DRIVE, [-5.0, 5.0], [20.0, 20.0])));
    bench.kelo.power_on();
    bench.run(1, None);
    assert_eq!((bench.float(20).abs(), bench.float(68)), (0.0, 0.0));
}
