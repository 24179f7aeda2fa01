//! Process data of a KELO drive, byte for byte. Little-endian, packed.

use crate::ethercat::sii::EntryType;

/// Bytes that the MainDevice writes.
pub const OUTPUT_BYTES: usize = 36;
/// Bytes that the MainDevice reads.
pub const INPUT_BYTES: usize = 172;

/// Bits of `command1`.
pub mod command {
    /// Enable motor 1.
    pub const ENABLE_1: u16 = 0x0001;
    /// Enable motor 2.
    pub const ENABLE_2: u16 = 0x0002;
    /// Where the mode's two bits begin.
    pub const MODE_SHIFT: u16 = 2;
    /// Emergency stop of motor 1.
    pub const EMERGENCY_1: u16 = 0x0010;
    /// Emergency stop of motor 2.
    pub const EMERGENCY_2: u16 = 0x0020;
    /// The setpoints apply at the time stamp, not at once.
    pub const USE_TIMESTAMP: u16 = 0x8000;
}

/// Bits of `status1`.
pub mod status {
    /// Motor 1 is enabled.
    pub const ENABLED_1: u16 = 0x0001;
    /// Motor 2 is enabled.
    pub const ENABLED_2: u16 = 0x0002;
    /// The encoders of both wheels and of the pivot are valid.
    pub const ENCODERS_VALID: u16 = 0x001C;
    /// Undervoltage; set on healthy drives too.
    pub const UNDERVOLTAGE: u16 = 0x0020;
    /// Overvoltage.
    pub const OVERVOLTAGE: u16 = 0x0040;
    /// Overcurrent or overtemperature of motor 1.
    pub const FAULTS_1: u16 = 0x0080 | 0x0200;
    /// Overcurrent or overtemperature of motor 2.
    pub const FAULTS_2: u16 = 0x0100 | 0x0400;
    /// `status2` of a healthy drive.
    pub const STATUS2_HEALTHY: u16 = 2051;
}

/// What the setpoints mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Currents of the motors, A.
    Torque,
    /// Common and differential current, A.
    DifferentialTorque,
    /// Speeds of the motors, rad/s.
    Velocity,
    /// Common and differential speed, rad/s.
    DifferentialVelocity,
}

/// What the MainDevice writes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Outputs {
    /// Bits of [`command`].
    pub command1: u16,
    /// Setpoints, by mode.
    pub setpoint: [f32; 2],
    /// Upper limits, by mode.
    pub upper: [f32; 2],
    /// Lower limits, by mode.
    pub lower: [f32; 2],
    /// EtherCAT time at which the setpoints apply.
    pub timestamp_ns: u64,
}

impl Outputs {
    /// Reads the process data; missing bytes count as 0.
    #[must_use]
    pub fn decode(bytes: &[u8]) -> Outputs {
        let mut full = [0; OUTPUT_BYTES];
        let length = bytes.len().min(OUTPUT_BYTES);
        full[..length].copy_from_slice(&bytes[..length]);
        let float =
            |at: usize| f32::from_le_bytes([full[at], full[at + 1], full[at + 2], full[at + 3]]);
        let mut timestamp = [0; 8];
        timestamp.copy_from_slice(&full[28..36]);
        Outputs {
            command1: u16::from_le_bytes([full[0], full[1]]),
            setpoint: [float(4), float(8)],
            upper: [float(12), float(20)],
            lower: [float(16), float(24)],
            timestamp_ns: u64::from_le_bytes(timestamp),
        }
    }

    /// The mode.
    #[must_use]
    pub fn mode(&self) -> Mode {
        match self.command1 >> command::MODE_SHIFT & 3 {
            0 => Mode::Torque,
            1 => Mode::DifferentialTorque,
            2 => Mode::Velocity,
            _ => Mode::DifferentialVelocity,
        }
    }
}

/// One motor's part of what the MainDevice reads.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotorInputs {
    /// Angle of the wheel, in the motor's frame.
    pub encoder_rad: f32,
    /// Speed of the wheel, in the motor's frame.
    pub velocity_rad_s: f32,
    /// Currents d, q, u, v, w.
    pub current_a: [f32; 5],
    /// Voltages pwm, u, v, w.
    pub voltage_v: [f32; 4],
    /// Temperature.
    pub temperature_k: f32,
}

/// What the MainDevice reads.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Inputs {
    /// Bits of [`status`].
    pub status1: u16,
    /// 2051 on a healthy drive.
    pub status2: u16,
    /// EtherCAT time of the sensors.
    pub sensor_ts_ns: u64,
    /// EtherCAT time of the last setpoints.
    pub setpoint_ts_ns: u64,
    /// Motors 1 and 2.
    pub motor: [MotorInputs; 2],
    /// Angle of the pivot, from -π to π.
    pub pivot_rad: f32,
    /// Speed of the pivot.
    pub pivot_rad_s: f32,
    /// Supply voltage.
    pub bus_voltage_v: f32,
    /// EtherCAT time of the inertial sensor.
    pub imu_ts_ns: u64,
    /// Acceleration x, y, z.
    pub acceleration_m_s2: [f32; 3],
    /// Angular rate x, y, z.
    pub gyro_rad_s: [f32; 3],
    /// Temperature of the inertial sensor.
    pub imu_temperature_k: f32,
    /// Air pressure.
    pub pressure_pa: f32,
    /// Current from the supply.
    pub input_current_a: f32,
}

impl Inputs {
    /// Writes the process data; bytes that do not fit are left out.
    pub fn encode(&self, bytes: &mut [u8]) {
        let mut full = [0; INPUT_BYTES];
        let mut writer = Writer {
            bytes: &mut full,
            at: 0,
        };
        writer.put(self.status1.to_le_bytes());
        writer.put(self.status2.to_le_bytes());
        writer.put(self.sensor_ts_ns.to_le_bytes());
        writer.put(self.setpoint_ts_ns.to_le_bytes());
        for motor in &self.motor {
            writer.floats(&[motor.encoder_rad, motor.velocity_rad_s]);
            writer.floats(&motor.current_a);
            writer.floats(&motor.voltage_v);
            writer.floats(&[motor.temperature_k]);
        }
        writer.floats(&[self.pivot_rad, self.pivot_rad_s, self.bus_voltage_v]);
        writer.put(self.imu_ts_ns.to_le_bytes());
        writer.floats(&self.acceleration_m_s2);
        writer.floats(&self.gyro_rad_s);
        writer.floats(&[
            self.imu_temperature_k,
            self.pressure_pa,
            self.input_current_a,
        ]);
        let length = bytes.len().min(INPUT_BYTES);
        bytes[..length].copy_from_slice(&full[..length]);
    }
}

struct Writer<'b> {
    bytes: &'b mut [u8; INPUT_BYTES],
    at: usize,
}

impl Writer<'_> {
    fn put<const N: usize>(&mut self, value: [u8; N]) {
        self.bytes[self.at..self.at + N].copy_from_slice(&value);
        self.at += N;
    }

    fn floats(&mut self, values: &[f32]) {
        for value in values {
            self.put(value.to_le_bytes());
        }
    }
}

/// The fields of the outputs, in order, as the EEPROM lists them.
#[must_use]
pub fn output_entries() -> Vec<EntryType> {
    use EntryType::{F32, U16, U64};
    [vec![U16; 2], vec![F32; 6], vec![U64]].concat()
}

/// The fields of the inputs, in order, as the EEPROM lists them.
#[must_use]
pub fn input_entries() -> Vec<EntryType> {
    use EntryType::{F32, U16, U64};
    [
        vec![U16; 2],
        vec![U64; 2],
        vec![F32; 27],
        vec![U64],
        vec![F32; 9],
    ]
    .concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn size(entries: &[EntryType]) -> usize {
        entries.iter().map(|entry| entry.bytes()).sum()
    }

    #[test]
    fn entries_add_up_to_the_sizes() {
        assert_eq!(size(&output_entries()), OUTPUT_BYTES);
        assert_eq!(size(&input_entries()), INPUT_BYTES);
    }

    #[test]
    fn outputs_lie_where_the_drive_reads_them() {
        let mut bytes = [0; OUTPUT_BYTES];
        bytes[0..2].copy_from_slice(&0x800Bu16.to_le_bytes());
        for (i, at) in [4, 8, 12, 16, 20, 24].into_iter().enumerate() {
            bytes[at..at + 4].copy_from_slice(&(i as f32 + 0.5).to_le_bytes());
        }
        bytes[28..36].copy_from_slice(&0x0102_0304_0506_0708u64.to_le_bytes());
        let outputs = Outputs::decode(&bytes);
        assert_eq!((outputs.command1, outputs.mode()), (0x800B, Mode::Velocity));
        assert_eq!(outputs.setpoint, [0.5, 1.5]);
        assert_eq!((outputs.upper, outputs.lower), ([2.5, 4.5], [3.5, 5.5]));
        assert_eq!(outputs.timestamp_ns, 0x0102_0304_0506_0708);
        assert_eq!(Outputs::decode(&[]), Outputs::default());
    }

    #[test]
    fn inputs_lie_where_the_drive_writes_them() {
        let motor = MotorInputs {
            encoder_rad: 1.0,
            temperature_k: 2.0,
            ..MotorInputs::default()
        };
        let inputs = Inputs {
            status1: 63,
            status2: 2051,
            sensor_ts_ns: 3,
            setpoint_ts_ns: 4,
            motor: [motor, motor],
            pivot_rad: 5.0,
            bus_voltage_v: 6.0,
            imu_ts_ns: 7,
            acceleration_m_s2: [8.0, 0.0, 0.0],
            gyro_rad_s: [0.0, 0.0, 9.0],
            input_current_a: 10.0,
            ..Inputs::default()
        };
        let mut bytes = [0; INPUT_BYTES];
        inputs.encode(&mut bytes);
        let float = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        assert_eq!(bytes[..4], [63, 0, 3, 8]);
        assert_eq!((bytes[4], bytes[12], bytes[128]), (3, 4, 7));
        assert_eq!([20, 64, 68, 112].map(float), [1.0, 2.0, 1.0, 2.0]);
        assert_eq!(
            [116, 124, 136, 156, 168].map(float),
            [5.0, 6.0, 8.0, 9.0, 10.0]
        );
        inputs.encode(&mut bytes[..3]);
    }
}
