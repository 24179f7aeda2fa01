//! The angle of a wheel with the same resolution after days as after a minute.
//!
//! The drive counts a wheel's angle in a 32-bit float that grows for ever: after a day at 0.4 m/s one step of it is 0.06 rad, 3 mm
//! at the rim. Its speed keeps its resolution. So the angle follows the speed within the half step to which the reading is
//! rounded: it never drifts from the reading, and is the reading as long as that is fine.

use std::f64::consts::{PI, TAU};
use std::fmt;

/// After a longer gap the speed does not say how far a wheel has turned.
const LONGEST_STEP_NS: u64 = 50_000_000;
/// What a reading may differ from what the speed says, before it is a jump.
const JUMP_RAD: f64 = 0.5;
/// With this time constant it is forgotten that the reading and the speed have differed.
const FORGOTTEN_S: f64 = 1.0;
/// Share of the way by which the drive may measure its speed wrongly.
const SPEED_ERROR: f64 = 0.05;

/// What an encoder measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measured {
    /// The left wheel.
    Left,
    /// The right wheel.
    Right,
    /// The pivot.
    Pivot,
}

/// An encoder moves otherwise than the speed of what it measures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EncoderContradiction {
    /// Which.
    pub of: Measured,
    /// How far it has turned lately by the speed that the drive reports,
    pub expected_rad: f64,
    /// and by its encoder.
    pub found_rad: f64,
    /// How far these are apart, beyond what an error of the speed explains.
    pub apart_rad: f64,
}

impl fmt::Display for EncoderContradiction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let whose = match self.of {
            Measured::Left => "left wheel's",
            Measured::Right => "right wheel's",
            Measured::Pivot => "pivot's",
        };
        let (expected, found) = (self.expected_rad, self.found_rad);
        write!(
            f,
            "the {whose} encoder has turned by {found:.2} rad within a second, expected {expected:.2} rad by its speed"
        )
    }
}

/// Reads one encoder, a wheel's or the pivot's.
///
/// Real time: nothing here allocates, locks or panics.
#[derive(Debug, Clone, Copy, Default)]
pub struct WheelEncoder {
    last: Option<Reading>,
    /// Turns that the reading has lost when it wrapped.
    turns_rad: f64,
    /// How far the reading has lately moved otherwise than the speed says,
    apart_rad: f64,
    /// how far by the speed,
    by_speed_rad: f64,
    /// and how far by the reading.
    by_reading_rad: f64,
}

#[derive(Debug, Clone, Copy)]
struct Reading {
    angle_rad: f64,
    speed_rad_s: f64,
    now_ns: u64,
}

impl WheelEncoder {
    /// Takes a reading, and the drive's own speed with it, at `now_ns`; returns the angle. What jumps is given as it is, but for
    /// whole turns: a reading that wraps is followed.
    pub fn read(&mut self, reading_rad: f32, speed_rad_s: f32, now_ns: u64) -> f64 {
        let step_rad = resolution_rad(reading_rad);
        let speed_rad_s = f64::from(speed_rad_s);
        let mut read_rad = f64::from(reading_rad) + self.turns_rad;
        let angle_rad = match self.last {
            Some(last)
                if now_ns.saturating_sub(last.now_ns) <= LONGEST_STEP_NS
                    && (read_rad + last.speed_rad_s + speed_rad_s).is_finite() =>
            {
                let elapsed_s = now_ns.saturating_sub(last.now_ns) as f64 * 1e-9;
                let way_rad = 0.5 * (last.speed_rad_s + speed_rad_s) * elapsed_s;
                let expected_rad = last.angle_rad + way_rad;
                let turns = ((expected_rad - read_rad) / TAU).round();
                let unwrapped_rad = read_rad + turns * TAU;
                if (read_rad - expected_rad).abs() > PI
                    && (unwrapped_rad - expected_rad).abs() < JUMP_RAD
                {
                    self.turns_rad += turns * TAU;
                    read_rad = unwrapped_rad;
                }
                let half_rad = 0.5 * step_rad;
                let angle_rad = expected_rad.clamp(read_rad - half_rad, read_rad + half_rad);
                let apart_rad = angle_rad - expected_rad;
                if apart_rad.abs() < JUMP_RAD {
                    let explained_rad = SPEED_ERROR * way_rad.abs();
                    self.apart_rad +=
                        apart_rad.signum() * (apart_rad.abs() - explained_rad).max(0.0);
                }
                let moved_rad = angle_rad - last.angle_rad;
                for (sum_rad, step_rad) in [
                    (&mut self.apart_rad, 0.0),
                    (&mut self.by_speed_rad, way_rad),
                    (&mut self.by_reading_rad, moved_rad),
                ] {
                    *sum_rad += step_rad;
                    *sum_rad -= *sum_rad * (elapsed_s / FORGOTTEN_S);
                }
                angle_rad
            }
            _ => read_rad,
        };
        // A reading that is no number says nothing about the next one.
        self.last = angle_rad.is_finite().then_some(Reading {
            angle_rad,
            speed_rad_s,
            now_ns,
        });
        angle_rad
    }

    /// By how much the reading has moved otherwise than the speed says, within the last second or so.
    #[must_use]
    pub fn apart_rad(&self) -> f64 {
        self.apart_rad
    }

    /// How far the wheel has turned within the last second or so: by the drive's speed, and by the reading.
    #[must_use]
    pub fn turned_rad(&self) -> (f64, f64) {
        (self.by_speed_rad, self.by_reading_rad)
    }
}

/// How far the next larger number of this kind is.
fn resolution_rad(reading_rad: f32) -> f64 {
    let magnitude = reading_rad.abs();
    f64::from(magnitude.next_up()) - f64::from(magnitude)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const CYCLE_NS: u64 = 1_000_000;

    /// What an encoder says of a wheel that turns as `speed` says, from `start_rad` on; the true angle and what was read.
    fn turned(
        start_rad: f64,
        cycles: u64,
        speed: impl Fn(f64) -> f64,
        wrap: impl Fn(f64) -> f64,
    ) -> Vec<(f64, f64, WheelEncoder)> {
        let (mut encoder, mut true_rad) = (WheelEncoder::default(), start_rad);
        (0..cycles)
            .map(|cycle| {
                let (before_s, now_s) =
                    (cycle.saturating_sub(1) as f64 * 1e-3, cycle as f64 * 1e-3);
                if cycle > 0 {
                    true_rad += 0.5e-3 * (speed(before_s) + speed(now_s));
                }
                let reading = wrap(true_rad) as f32;
                let read = encoder.read(reading, speed(now_s) as f32, (cycle + 1) * CYCLE_NS);
                (true_rad, read, encoder)
            })
            .collect()
    }

    #[test]
    fn a_wheel_after_a_day_is_read_as_finely_as_a_new_one() {
        // 0.4 m/s for a day, with wheels of 10 cm.
        let day_rad = 7.6 * 86_400.0;
        let speed = |s: f64| 4.0 + 3.0 * (0.7 * s).sin();
        let read = turned(day_rad, 60_000, speed, |angle| angle);
        for pair in read.windows(6) {
            let (true_way, way) = (pair[5].0 - pair[0].0, pair[5].1 - pair[0].1);
            // The raw reading's steps are 0.0625 rad.
            assert!((way - true_way).abs() < 0.004, "{true_way} {way}");
            assert!((pair[0].1 - pair[0].0).abs() < 0.04);
            assert!(pair[0].2.apart_rad().abs() < 0.05);
        }
    }

    #[test]
    fn a_young_encoder_is_read_as_it_is() {
        for (true_rad, read, _) in turned(0.0, 5000, |_| 5.0, |angle| angle) {
            assert!((true_rad - read).abs() < 1e-5);
        }
    }

    #[test]
    fn a_reading_that_wraps_is_followed() {
        let wrap = |angle: f64| angle - TAU * ((angle + PI) / TAU).floor();
        for speed in [6.0, -6.0] {
            for (true_rad, read, _) in turned(0.0, 20_000, |_| speed, wrap) {
                assert!((true_rad - read).abs() < 1e-4, "{true_rad} {read}");
            }
        }
    }

    #[test]
    fn an_encoder_that_stands_still_while_the_wheel_turns_is_noticed() {
        let mut encoder = WheelEncoder::default();
        for cycle in 1..1000 {
            encoder.read(10.0, 2.0, cycle * CYCLE_NS);
        }
        assert!(encoder.apart_rad() < -0.5, "{}", encoder.apart_rad());
    }

    #[test]
    fn jumps_and_nonsense_are_given_as_they_are_and_do_no_lasting_harm() {
        let mut encoder = WheelEncoder::default();
        assert_eq!(encoder.read(1.0, 0.0, CYCLE_NS), 1.0);
        assert!((encoder.read(5.0, 0.0, 2 * CYCLE_NS) - 5.0).abs() < 1e-6);
        assert!(encoder.read(f32::NAN, 0.0, 3 * CYCLE_NS).is_nan());
        assert_eq!(encoder.read(2.0, f32::INFINITY, 4 * CYCLE_NS), 2.0);
        assert!((encoder.read(3.0, 1.0, 5 * CYCLE_NS) - 3.0).abs() < 1e-6);
        assert_eq!(encoder.read(3.0, f32::NAN, 6 * CYCLE_NS), 3.0);
        assert_eq!(encoder.read(3.0, 0.0, 7 * CYCLE_NS), 3.0);
        let (by_speed_rad, by_reading_rad) = encoder.turned_rad();
        assert!(by_speed_rad.is_finite() && by_reading_rad.is_finite());
        assert!(encoder.apart_rad().abs() < 0.1);
    }

    proptest! {
        #[test]
        fn whatever_is_read_the_angle_stays_near_it(
            readings in prop::collection::vec((any::<f32>(), any::<f32>(), 0_u64..100_000_000), 1..100)
        ) {
            let (mut encoder, mut now_ns) = (WheelEncoder::default(), 0);
            for (reading, speed, elapsed_ns) in readings {
                now_ns += elapsed_ns;
                let angle_rad = encoder.read(reading, speed, now_ns);
                prop_assert_eq!(angle_rad.is_finite(), reading.is_finite());
                prop_assert!(encoder.apart_rad().is_finite());
            }
        }
    }
}
