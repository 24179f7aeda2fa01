//! What the drive's encoders say, in the robot's terms.

use description::wheels::{EncoderAngles, WheelSpeeds};
use drivers::kelo::{EncoderContradiction, Feedback, WheelEncoder};

use crate::symbols::values::Encoders;

/// An encoder whose angle moves otherwise than its speed says, by more than this within a second, is broken.
const APART_RAD: f64 = 0.5;

/// Both wheels' encoders.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wheels {
    left: WheelEncoder,
    right: WheelEncoder,
}

impl Wheels {
    /// Takes in what the drive says; `epoch` says since when its encoders count.
    pub(super) fn read(
        &mut self,
        feedback: &Feedback,
        pivot_zero_rad: f64,
        epoch: u64,
        now_ns: u64,
    ) -> Encoders {
        let Feedback {
            left_rad,
            right_rad,
            left_rad_s,
            right_rad_s,
            ..
        } = *feedback;
        Encoders {
            angles: EncoderAngles {
                left_rad: self.left.read(left_rad, left_rad_s, now_ns),
                right_rad: self.right.read(right_rad, right_rad_s, now_ns),
                pivot_rad: f64::from(feedback.pivot_rad) - pivot_zero_rad,
            },
            speeds: WheelSpeeds::new(f64::from(left_rad_s), f64::from(right_rad_s)),
            pivot_rad_s: f64::from(feedback.pivot_rad_s),
            epoch,
        }
    }

    /// The encoder whose angle and speed are farther apart, when that is too far.
    pub(super) fn contradict(&self) -> Option<EncoderContradiction> {
        let [left, right] = [self.left, self.right].map(|encoder| encoder.apart_rad().abs());
        let (right, worst) = if left > right {
            (false, &self.left)
        } else {
            (true, &self.right)
        };
        let apart_rad = worst.apart_rad();
        let (expected_rad, found_rad) = worst.turned_rad();
        (apart_rad.abs() > APART_RAD).then_some(EncoderContradiction {
            right,
            expected_rad,
            found_rad,
            apart_rad,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::realtime::clock::MILLISECOND_NS;

    #[test]
    fn the_encoder_that_sticks_is_named_with_what_it_should_have_turned() {
        for right in [false, true] {
            let mut wheels = Wheels::default();
            let found = (1..=1000_u16).find_map(|cycle| {
                let turned_rad = 7.0 * f32::from(cycle) * 1e-3;
                let feedback = Feedback {
                    left_rad: if right { turned_rad } else { 0.0 },
                    right_rad: if right { 0.0 } else { turned_rad },
                    left_rad_s: 7.0,
                    right_rad_s: 7.0,
                    ..Feedback::default()
                };
                let now_ns = u64::from(cycle) * MILLISECOND_NS;
                wheels.read(&feedback, 0.0, 0, now_ns);
                wheels.contradict()
            });
            let found = found.expect("it sticks");
            let apart_rad = found.expected_rad - found.found_rad;
            assert!(
                found.right == right
                    && found.found_rad.abs() < 0.01
                    && (0.5..0.6).contains(&apart_rad),
                "{found}"
            );
        }
    }
}
