//! Process data from the drive (TxPDO): 172 bytes, packed, little-endian.

use super::INPUTS_BYTES;

/// The status word `status1`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Status(pub u16);

impl Status {
    /// Motor 1 powered.
    pub const ENABLED_1: u16 = 0x0001;
    /// Motor 2 powered.
    pub const ENABLED_2: u16 = 0x0002;
    /// Encoder of motor 1 valid.
    pub const VALID_1: u16 = 0x0004;
    /// Encoder of motor 2 valid.
    pub const VALID_2: u16 = 0x0008;
    /// Pivot encoder valid.
    pub const VALID_PIVOT: u16 = 0x0010;
    /// Undervoltage. Set on healthy drives too: judge the voltage, not this bit.
    pub const UNDERVOLTAGE: u16 = 0x0020;
    /// Overvoltage.
    pub const OVERVOLTAGE: u16 = 0x0040;
    /// Overcurrent of motor 1.
    pub const OVERCURRENT_1: u16 = 0x0080;
    /// Overcurrent of motor 2.
    pub const OVERCURRENT_2: u16 = 0x0100;
    /// Overtemperature of motor 1.
    pub const OVERTEMPERATURE_1: u16 = 0x0200;
    /// Overtemperature of motor 2.
    pub const OVERTEMPERATURE_2: u16 = 0x0400;
    /// The three gripper bits.
    pub const GRIPPER: u16 = 0x3800;
    /// Detect.
    pub const DETECT: u16 = 0x4000;

    /// All encoder bits.
    pub const VALID_ALL: u16 = Status::VALID_1 | Status::VALID_2 | Status::VALID_PIVOT;
    /// Both enable bits.
    pub const ENABLED_BOTH: u16 = Status::ENABLED_1 | Status::ENABLED_2;

    /// Whether any of these bits is set.
    #[must_use]
    pub const fn any(self, bits: u16) -> bool {
        self.0 & bits != 0
    }

    /// Whether all of these bits are set.
    #[must_use]
    pub const fn all(self, bits: u16) -> bool {
        self.0 & bits == bits
    }
}

/// One motor, in the drive's own sense of rotation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[expect(missing_docs, reason = "the names say it, and the units are in them")]
pub struct MotorInputs {
    pub encoder_rad: f32,
    pub velocity_rad_s: f32,
    pub current_d_a: f32,
    pub current_q_a: f32,
    pub current_u_a: f32,
    pub current_v_a: f32,
    pub current_w_a: f32,
    pub voltage_pwm_v: f32,
    pub voltage_u_v: f32,
    pub voltage_v_v: f32,
    pub voltage_w_v: f32,
    pub temperature_k: f32,
}

/// The inertial sensor and what is reported next to it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Imu {
    /// When the sample was taken, EtherCAT time.
    pub stamp_ns: u64,
    /// Acceleration along x, y, z.
    pub acceleration_m_s2: [f32; 3],
    /// Rate of turn about x, y, z.
    pub gyro_rad_s: [f32; 3],
    /// Temperature of the sensor.
    pub temperature_k: f32,
    /// Absolute pressure.
    pub pressure_pa: f32,
}

/// The process data from the drive.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Inputs {
    /// Enabled motors, valid encoders, faults.
    pub status1: Status,
    /// 2051 on a healthy drive; its bits are not published.
    pub status2: u16,
    /// When the sensors were read, EtherCAT time. Advances while the drive's firmware is alive.
    pub sensor_stamp_ns: u64,
    /// When the last setpoint was taken, EtherCAT time.
    pub setpoint_stamp_ns: u64,
    /// Motor 1: the right wheel, mirrored.
    pub motor1: MotorInputs,
    /// Motor 2: the left wheel.
    pub motor2: MotorInputs,
    /// Pivot angle, wraps at ±π.
    pub pivot_rad: f32,
    /// Pivot rate.
    pub pivot_rad_s: f32,
    /// Supply voltage.
    pub bus_voltage_v: f32,
    /// Inertial sensor.
    pub imu: Imu,
    /// Supply current.
    pub input_current_a: f32,
}

impl Inputs {
    /// Reads the process data. Every bit pattern is accepted; [`Faults`](super::Faults) judges whether it makes sense.
    #[must_use]
    pub fn from_bytes(bytes: &[u8; INPUTS_BYTES]) -> Inputs {
        let mut fields = Fields(bytes);
        // In the order of the wire.
        Inputs {
            status1: Status(fields.u16()),
            status2: fields.u16(),
            sensor_stamp_ns: fields.u64(),
            setpoint_stamp_ns: fields.u64(),
            motor1: motor(&mut fields),
            motor2: motor(&mut fields),
            pivot_rad: fields.f32(),
            pivot_rad_s: fields.f32(),
            bus_voltage_v: fields.f32(),
            imu: Imu {
                stamp_ns: fields.u64(),
                acceleration_m_s2: [fields.f32(), fields.f32(), fields.f32()],
                gyro_rad_s: [fields.f32(), fields.f32(), fields.f32()],
                temperature_k: fields.f32(),
                pressure_pa: fields.f32(),
            },
            input_current_a: fields.f32(),
        }
    }
}

fn motor(fields: &mut Fields<'_>) -> MotorInputs {
    MotorInputs {
        encoder_rad: fields.f32(),
        velocity_rad_s: fields.f32(),
        current_d_a: fields.f32(),
        current_q_a: fields.f32(),
        current_u_a: fields.f32(),
        current_v_a: fields.f32(),
        current_w_a: fields.f32(),
        voltage_pwm_v: fields.f32(),
        voltage_u_v: fields.f32(),
        voltage_v_v: fields.f32(),
        voltage_w_v: fields.f32(),
        temperature_k: fields.f32(),
    }
}

/// Takes fields off the front. Past the end, which the fixed sizes rule out, it returns zeros.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        match self.0.split_first_chunk() {
            Some((field, rest)) => {
                self.0 = rest;
                *field
            }
            None => [0; N],
        }
    }

    fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.take())
    }

    fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.take())
    }

    fn f32(&mut self) -> f32 {
        f32::from_le_bytes(self.take())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Field<T> = (usize, &'static str, fn(&Inputs) -> T);

    /// Offset of every float, from the vendor's description.
    const FLOATS: [Field<f32>; 36] = [
        (20, "motor 1 encoder", |i| i.motor1.encoder_rad),
        (24, "motor 1 velocity", |i| i.motor1.velocity_rad_s),
        (28, "motor 1 current d", |i| i.motor1.current_d_a),
        (32, "motor 1 current q", |i| i.motor1.current_q_a),
        (36, "motor 1 current u", |i| i.motor1.current_u_a),
        (40, "motor 1 current v", |i| i.motor1.current_v_a),
        (44, "motor 1 current w", |i| i.motor1.current_w_a),
        (48, "motor 1 voltage pwm", |i| i.motor1.voltage_pwm_v),
        (52, "motor 1 voltage u", |i| i.motor1.voltage_u_v),
        (56, "motor 1 voltage v", |i| i.motor1.voltage_v_v),
        (60, "motor 1 voltage w", |i| i.motor1.voltage_w_v),
        (64, "motor 1 temperature", |i| i.motor1.temperature_k),
        (68, "motor 2 encoder", |i| i.motor2.encoder_rad),
        (72, "motor 2 velocity", |i| i.motor2.velocity_rad_s),
        (76, "motor 2 current d", |i| i.motor2.current_d_a),
        (80, "motor 2 current q", |i| i.motor2.current_q_a),
        (84, "motor 2 current u", |i| i.motor2.current_u_a),
        (88, "motor 2 current v", |i| i.motor2.current_v_a),
        (92, "motor 2 current w", |i| i.motor2.current_w_a),
        (96, "motor 2 voltage pwm", |i| i.motor2.voltage_pwm_v),
        (100, "motor 2 voltage u", |i| i.motor2.voltage_u_v),
        (104, "motor 2 voltage v", |i| i.motor2.voltage_v_v),
        (108, "motor 2 voltage w", |i| i.motor2.voltage_w_v),
        (112, "motor 2 temperature", |i| i.motor2.temperature_k),
        (116, "pivot encoder", |i| i.pivot_rad),
        (120, "pivot velocity", |i| i.pivot_rad_s),
        (124, "bus voltage", |i| i.bus_voltage_v),
        (136, "accelerometer x", |i| i.imu.acceleration_m_s2[0]),
        (140, "accelerometer y", |i| i.imu.acceleration_m_s2[1]),
        (144, "accelerometer z", |i| i.imu.acceleration_m_s2[2]),
        (148, "gyro x", |i| i.imu.gyro_rad_s[0]),
        (152, "gyro y", |i| i.imu.gyro_rad_s[1]),
        (156, "gyro z", |i| i.imu.gyro_rad_s[2]),
        (160, "IMU temperature", |i| i.imu.temperature_k),
        (164, "pressure", |i| i.imu.pressure_pa),
        (168, "input current", |i| i.input_current_a),
    ];

    const STAMPS: [Field<u64>; 3] = [
        (4, "sensor stamp", |i| i.sensor_stamp_ns),
        (12, "setpoint stamp", |i| i.setpoint_stamp_ns),
        (128, "IMU stamp", |i| i.imu.stamp_ns),
    ];

    const WORDS: [Field<u16>; 2] = [
        (0, "status1", |i| i.status1.0),
        (2, "status2", |i| i.status2),
    ];

    /// Only the bytes of one field set: only that field may change.
    fn with(offset: usize, field: &[u8]) -> Inputs {
        let mut bytes = [0; INPUTS_BYTES];
        bytes[offset..offset + field.len()].copy_from_slice(field);
        Inputs::from_bytes(&bytes)
    }

    #[test]
    fn every_field_is_where_the_drive_puts_it() {
        let mut covered = [false; INPUTS_BYTES];
        let mut cover = |offset: usize, size: usize| {
            for byte in &mut covered[offset..offset + size] {
                assert!(!std::mem::replace(byte, true), "two fields at {offset}");
            }
        };
        for (offset, name, field) in FLOATS {
            let inputs = with(offset, &1.5f32.to_le_bytes());
            assert_eq!(field(&inputs), 1.5, "{name}");
            assert_eq!(
                FLOATS
                    .iter()
                    .filter(|(_, _, other)| other(&inputs) != 0.0)
                    .count(),
                1,
                "{name}"
            );
            cover(offset, 4);
        }
        for (offset, name, field) in STAMPS {
            assert_eq!(
                field(&with(offset, &0x0102_0304_0506_0708u64.to_le_bytes())),
                0x0102_0304_0506_0708,
                "{name}"
            );
            cover(offset, 8);
        }
        for (offset, name, field) in WORDS {
            assert_eq!(field(&with(offset, &[0x34, 0x12])), 0x1234, "{name}");
            cover(offset, 2);
        }
        assert!(
            covered.iter().all(|&byte| byte),
            "every byte belongs to a field"
        );
    }

    #[test]
    fn status_bits_do_not_overlap_and_leave_one() {
        let bits = [
            Status::ENABLED_1,
            Status::ENABLED_2,
            Status::VALID_1,
            Status::VALID_2,
            Status::VALID_PIVOT,
            Status::UNDERVOLTAGE,
            Status::OVERVOLTAGE,
            Status::OVERCURRENT_1,
            Status::OVERCURRENT_2,
            Status::OVERTEMPERATURE_1,
            Status::OVERTEMPERATURE_2,
            Status::GRIPPER,
            Status::DETECT,
        ];
        let sum: u32 = bits.iter().map(|&bit| u32::from(bit)).sum();
        assert_eq!(sum, 0x7FFF);
    }
}
