//! Faults, judged from what the drive reports.

use super::inputs::{Inputs, Status};
use std::fmt;

/// The range in which the supply voltage is good.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VoltageLimits {
    /// Below this is undervoltage.
    pub min_v: f32,
    /// Above this is overvoltage.
    pub max_v: f32,
}

/// A set of faults; empty when the drive is healthy.
///
/// Undervoltage is judged from the voltage, because healthy drives set the undervoltage bit. Encoder bits count only
/// when some are set and some are not, because some healthy drives set none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Faults(u16);

impl Faults {
    /// No fault.
    pub const NONE: Faults = Faults(0);
    /// The supply is below its limit.
    pub const UNDERVOLTAGE: Faults = Faults(1 << 0);
    /// The supply is above its limit, or the drive says so.
    pub const OVERVOLTAGE: Faults = Faults(1 << 1);
    /// Motor 1 (right) draws too much.
    pub const OVERCURRENT_1: Faults = Faults(1 << 2);
    /// Motor 2 (left) draws too much.
    pub const OVERCURRENT_2: Faults = Faults(1 << 3);
    /// Motor 1 (right) is too hot.
    pub const OVERTEMPERATURE_1: Faults = Faults(1 << 4);
    /// Motor 2 (left) is too hot.
    pub const OVERTEMPERATURE_2: Faults = Faults(1 << 5);
    /// One encoder is valid and another is not.
    pub const ENCODER: Faults = Faults(1 << 6);
    /// A wheel, the pivot or the voltage is reported as something that is not a finite number.
    pub const NOT_FINITE: Faults = Faults(1 << 7);

    const NAMED: [(Faults, &'static str); 8] = [
        (Faults::UNDERVOLTAGE, "undervoltage"),
        (Faults::OVERVOLTAGE, "overvoltage"),
        (Faults::OVERCURRENT_1, "overcurrent of motor 1"),
        (Faults::OVERCURRENT_2, "overcurrent of motor 2"),
        (Faults::OVERTEMPERATURE_1, "overtemperature of motor 1"),
        (Faults::OVERTEMPERATURE_2, "overtemperature of motor 2"),
        (Faults::ENCODER, "invalid encoder"),
        (Faults::NOT_FINITE, "value that is not finite"),
    ];

    /// The faults in what the drive reports.
    #[must_use]
    pub fn of(inputs: &Inputs, limits: VoltageLimits) -> Faults {
        let status = inputs.status1;
        let voltage_v = inputs.bus_voltage_v;
        let measured = [
            inputs.motor1.encoder_rad,
            inputs.motor1.velocity_rad_s,
            inputs.motor2.encoder_rad,
            inputs.motor2.velocity_rad_s,
            inputs.pivot_rad,
            inputs.pivot_rad_s,
            voltage_v,
        ];
        let partly_valid = status.any(Status::VALID_ALL) && !status.all(Status::VALID_ALL);
        [
            (voltage_v < limits.min_v, Faults::UNDERVOLTAGE),
            (
                voltage_v > limits.max_v || status.any(Status::OVERVOLTAGE),
                Faults::OVERVOLTAGE,
            ),
            (status.any(Status::OVERCURRENT_1), Faults::OVERCURRENT_1),
            (status.any(Status::OVERCURRENT_2), Faults::OVERCURRENT_2),
            (
                status.any(Status::OVERTEMPERATURE_1),
                Faults::OVERTEMPERATURE_1,
            ),
            (
                status.any(Status::OVERTEMPERATURE_2),
                Faults::OVERTEMPERATURE_2,
            ),
            (partly_valid, Faults::ENCODER),
            (
                !measured.iter().all(|value| value.is_finite()),
                Faults::NOT_FINITE,
            ),
        ]
        .into_iter()
        .filter(|(present, _)| *present)
        .fold(Faults::NONE, |faults, (_, fault)| faults.with(fault))
    }

    /// The union of both sets.
    #[must_use]
    pub const fn with(self, other: Faults) -> Faults {
        Faults(self.0 | other.0)
    }

    /// Whether all of `other` are among these.
    #[must_use]
    pub const fn contains(self, other: Faults) -> bool {
        self.0 & other.0 == other.0
    }

    /// Whether there is no fault.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// As a number, to put it into a message.
    #[must_use]
    pub const fn bits(self) -> u16 {
        self.0
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_empty() {
            return f.write_str("no fault");
        }
        let mut separator = "";
        for (fault, name) in Faults::NAMED {
            if self.contains(fault) {
                write!(f, "{separator}{name}")?;
                separator = ", ";
            }
        }
        Ok(())
    }
}

/// Watches a time stamp of the drive: when it stops advancing, the firmware hangs although the bus works.
#[derive(Debug, Clone, Copy, Default)]
pub struct StampWatch {
    last_stamp_ns: u64,
    advanced_ns: u64,
    advances: bool,
}

impl StampWatch {
    /// A watch that starts at the first stamp it sees.
    #[must_use]
    pub const fn new() -> StampWatch {
        StampWatch {
            last_stamp_ns: 0,
            advanced_ns: 0,
            advances: false,
        }
    }

    /// Whether the stamp has changed since the first one: until then, nothing says that what comes with it is news.
    #[must_use]
    pub const fn advances(&self) -> bool {
        self.advances
    }

    /// Takes the stamp of the latest answer (drive's clock) at `now_ns` (host's clock) and returns how long the stamp
    /// has not changed, by the host's clock. Any change counts as advancing, so that a restart does not look like a
    /// hang.
    pub fn stalled_ns(&mut self, stamp_ns: u64, now_ns: u64) -> u64 {
        if stamp_ns != self.last_stamp_ns || self.advanced_ns == 0 {
            self.advances |= self.advanced_ns != 0;
            self.last_stamp_ns = stamp_ns;
            self.advanced_ns = now_ns;
        }
        now_ns.saturating_sub(self.advanced_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: VoltageLimits = VoltageLimits {
        min_v: 20.0,
        max_v: 32.0,
    };

    fn faults(status: u16, bus_voltage_v: f32) -> Faults {
        Faults::of(
            &Inputs {
                status1: Status(status),
                bus_voltage_v,
                ..Inputs::default()
            },
            LIMITS,
        )
    }

    #[test]
    fn both_healthy_status_words_are_healthy() {
        assert_eq!(faults(3, 24.0), Faults::NONE);
        assert_eq!(
            faults(63, 24.0),
            Faults::NONE,
            "63 has the undervoltage bit set"
        );
    }

    #[test]
    fn undervoltage_is_judged_by_the_voltage() {
        assert_eq!(faults(3, 19.9), Faults::UNDERVOLTAGE);
        assert_eq!(faults(63, 0.0), Faults::UNDERVOLTAGE);
        assert_eq!(faults(3, 32.1), Faults::OVERVOLTAGE);
        assert_eq!(faults(3, f32::NAN), Faults::NOT_FINITE);
    }

    #[test]
    fn every_fault_bit_is_reported_by_name() {
        for (bit, fault, name) in [
            (0x0040, Faults::OVERVOLTAGE, "overvoltage"),
            (0x0080, Faults::OVERCURRENT_1, "overcurrent of motor 1"),
            (0x0100, Faults::OVERCURRENT_2, "overcurrent of motor 2"),
            (
                0x0200,
                Faults::OVERTEMPERATURE_1,
                "overtemperature of motor 1",
            ),
            (
                0x0400,
                Faults::OVERTEMPERATURE_2,
                "overtemperature of motor 2",
            ),
            (0x0004, Faults::ENCODER, "invalid encoder"),
        ] {
            assert_eq!(faults(3 | bit, 24.0), fault);
            assert_eq!(fault.to_string(), name);
        }
        for bit in [0x0800, 0x1000, 0x2000, 0x4000, 0x8000] {
            assert_eq!(
                faults(63 | bit, 24.0),
                Faults::NONE,
                "gripper and detect are no faults"
            );
        }
        assert_eq!(
            faults(0x00C3, 10.0).to_string(),
            "undervoltage, overvoltage, overcurrent of motor 1"
        );
        assert_eq!(Faults::NONE.to_string(), "no fault");
    }

    #[test]
    fn a_stamp_that_stands_still_is_noticed() {
        let mut watch = StampWatch::new();
        assert_eq!(watch.stalled_ns(100, 1_000), 0);
        assert_eq!(watch.stalled_ns(100, 3_000), 2_000);
        assert!(!watch.advances(), "it may be of before");
        assert_eq!(watch.stalled_ns(101, 4_000), 0);
        assert!(watch.advances());
        assert_eq!(watch.stalled_ns(7, 5_000), 0, "a restart");
        assert_eq!(watch.stalled_ns(7, 9_000), 4_000);
        // A drive that has always reported zero is stalled as well.
        let mut watch = StampWatch::new();
        watch.stalled_ns(0, 1_000);
        assert_eq!(watch.stalled_ns(0, 6_000), 5_000);
    }
}
