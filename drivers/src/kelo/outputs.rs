//! Process data to the drive (RxPDO): 36 bytes, packed, little-endian.

use super::OUTPUTS_BYTES;

/// The command word `command1`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CommandWord(pub u16);

impl CommandWord {
    /// Motor 1 powered.
    pub const ENABLE_1: u16 = 0x0001;
    /// Motor 2 powered.
    pub const ENABLE_2: u16 = 0x0002;
    /// Emergency stop of motor 1.
    pub const EMERGENCY_1: u16 = 0x0010;
    /// Emergency stop of motor 2.
    pub const EMERGENCY_2: u16 = 0x0020;
    /// Servo (gripper) powered.
    pub const ENABLE_SERVO: u16 = 0x0400;
    /// Servo (gripper) closes.
    pub const SERVO_CLOSE: u16 = 0x0800;
    /// The setpoint applies at `timestamp_ns`, not at once.
    pub const USE_TIMESTAMP: u16 = 0x8000;

    const MODE_SHIFT: u16 = 2;
    const MODE_MASK: u16 = 0b11 << CommandWord::MODE_SHIFT;

    /// Both motors off, nothing asked.
    #[must_use]
    pub const fn off() -> CommandWord {
        CommandWord(0)
    }

    /// With these bits set.
    #[must_use]
    pub const fn with(self, bits: u16) -> CommandWord {
        CommandWord(self.0 | bits)
    }

    /// In this mode.
    #[must_use]
    pub const fn in_mode(self, mode: Mode) -> CommandWord {
        CommandWord(self.0 & !CommandWord::MODE_MASK | (mode as u16) << CommandWord::MODE_SHIFT)
    }

    /// The mode asked for.
    #[must_use]
    pub const fn mode(self) -> Mode {
        match (self.0 & CommandWord::MODE_MASK) >> CommandWord::MODE_SHIFT {
            0 => Mode::Torque,
            1 => Mode::DifferentialTorque,
            2 => Mode::Velocity,
            _ => Mode::DifferentialVelocity,
        }
    }

    /// Whether any of these bits is set.
    #[must_use]
    pub const fn has(self, bits: u16) -> bool {
        self.0 & bits != 0
    }
}

/// What the setpoints and limits of [`Outputs`] mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u16)]
pub enum Mode {
    /// Setpoints: currents of motor 1 and 2, A. Limits: speeds of wheel 1 and 2, rad/s.
    Torque = 0,
    /// Setpoints: common and differential current, A. Limits: linear and pivot speed, rad/s.
    DifferentialTorque = 1,
    /// Setpoints: speeds of motor 1 and 2, rad/s. Limits: currents of motor 1 and 2, A.
    Velocity = 2,
    /// Setpoints: common and differential speed, rad/s. Limits: linear and pivot current, A.
    DifferentialVelocity = 3,
}

/// The process data to the drive. Units of setpoints and limits depend on the [`Mode`]; the default is all motors off.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Outputs {
    /// Enable bits and mode.
    pub command1: CommandWord,
    /// Unused, 0.
    pub command2: u16,
    /// For motor 1, or common.
    pub setpoint1: f32,
    /// For motor 2, or differential.
    pub setpoint2: f32,
    /// Upper limit 1.
    pub limit1_p: f32,
    /// Lower limit 1.
    pub limit1_n: f32,
    /// Upper limit 2.
    pub limit2_p: f32,
    /// Lower limit 2.
    pub limit2_n: f32,
    /// EtherCAT time at which the setpoint applies, ns; counts only with [`CommandWord::USE_TIMESTAMP`].
    pub timestamp_ns: u64,
}

impl Outputs {
    /// The process data on the wire.
    #[must_use]
    pub fn to_bytes(&self) -> [u8; OUTPUTS_BYTES] {
        let mut bytes = [0; OUTPUTS_BYTES];
        bytes[0..2].copy_from_slice(&self.command1.0.to_le_bytes());
        bytes[2..4].copy_from_slice(&self.command2.to_le_bytes());
        let floats = [
            self.setpoint1,
            self.setpoint2,
            self.limit1_p,
            self.limit1_n,
            self.limit2_p,
            self.limit2_n,
        ];
        for (to, float) in bytes[4..28].chunks_exact_mut(4).zip(floats) {
            to.copy_from_slice(&float.to_le_bytes());
        }
        bytes[28..36].copy_from_slice(&self.timestamp_ns.to_le_bytes());
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Offset and size of every field, from the vendor's description.
    #[test]
    fn every_field_is_where_the_drive_expects_it() {
        let off = Outputs::default();
        let one = 1.0f32.to_le_bytes();
        let float = |at: usize, outputs: Outputs| (at, one.to_vec(), outputs);
        let fields = [
            (
                0,
                vec![0x34, 0x12],
                Outputs {
                    command1: CommandWord(0x1234),
                    ..off
                },
            ),
            (
                2,
                vec![0x78, 0x56],
                Outputs {
                    command2: 0x5678,
                    ..off
                },
            ),
            float(
                4,
                Outputs {
                    setpoint1: 1.0,
                    ..off
                },
            ),
            float(
                8,
                Outputs {
                    setpoint2: 1.0,
                    ..off
                },
            ),
            float(
                12,
                Outputs {
                    limit1_p: 1.0,
                    ..off
                },
            ),
            float(
                16,
                Outputs {
                    limit1_n: 1.0,
                    ..off
                },
            ),
            float(
                20,
                Outputs {
                    limit2_p: 1.0,
                    ..off
                },
            ),
            float(
                24,
                Outputs {
                    limit2_n: 1.0,
                    ..off
                },
            ),
            (
                28,
                vec![8, 7, 6, 5, 4, 3, 2, 1],
                Outputs {
                    timestamp_ns: 0x0102_0304_0506_0708,
                    ..off
                },
            ),
        ];
        assert_eq!(off.to_bytes(), [0; OUTPUTS_BYTES]);
        let mut end = 0;
        for (offset, expected, outputs) in fields {
            assert_eq!(offset, end, "fields are packed");
            end = offset + expected.len();
            let mut bytes = [0; OUTPUTS_BYTES];
            bytes[offset..end].copy_from_slice(&expected);
            assert_eq!(outputs.to_bytes(), bytes, "field at {offset}");
        }
        assert_eq!(end, OUTPUTS_BYTES);
    }

    #[test]
    fn command_bits_and_modes() {
        assert_eq!(CommandWord::off().in_mode(Mode::Torque).0, 0x0000);
        assert_eq!(
            CommandWord::off().in_mode(Mode::DifferentialTorque).0,
            0x0004
        );
        assert_eq!(CommandWord::off().in_mode(Mode::Velocity).0, 0x0008);
        assert_eq!(
            CommandWord::off().in_mode(Mode::DifferentialVelocity).0,
            0x000C
        );
        for mode in [
            Mode::Torque,
            Mode::DifferentialTorque,
            Mode::Velocity,
            Mode::DifferentialVelocity,
        ] {
            let command = CommandWord(0xFFFF).in_mode(mode);
            assert_eq!(command.mode(), mode);
            assert_eq!(command.0 | 0x000C, 0xFFFF);
        }
        let driving = CommandWord::off()
            .in_mode(Mode::Velocity)
            .with(CommandWord::ENABLE_1 | CommandWord::ENABLE_2);
        assert_eq!(driving.0, 0x000B);
        assert!(driving.has(CommandWord::ENABLE_1) && !driving.has(CommandWord::EMERGENCY_1));
    }
}
