//! What the drive's encoders say, in the robot's terms.

use description::wheels::{EncoderAngles, WheelSpeeds};
use drivers::kelo::{EncoderContradiction, Feedback, Measured, WheelEncoder};

use crate::symbols::values::Encoders;

/// An encoder of a wheel whose angle moves otherwise than its speed says, by more than this within a second, is broken,
const WHEEL_APART_RAD: f64 = 0.5;
/// and so is the pivot's: by as much the robot would be wrong about where it turns to.
const PIVOT_APART_RAD: f64 = 0.15;

/// The encoders of both wheels, and of the pivot between them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wheels {
    left: WheelEncoder,
    right: WheelEncoder,
    pivot: WheelEncoder,
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
        // The angle itself is absolute, and is taken as it is.
        (self.pivot).read(feedback.pivot_rad, feedback.pivot_rad_s, now_ns);
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

    /// The encoder whose angle and speed are farthest apart, when that is too far.
    pub(super) fn contradict(&self) -> Option<EncoderContradiction> {
        let encoders = [
            (Measured::Left, &self.left, WHEEL_APART_RAD),
            (Measured::Right, &self.right, WHEEL_APART_RAD),
            (Measured::Pivot, &self.pivot, PIVOT_APART_RAD),
        ];
        let share = |encoder: &WheelEncoder, most_rad: f64| encoder.apart_rad().abs() / most_rad;
        let (of, worst, _) = { encoders.into_iter() }
            .filter(|(_, encoder, most_rad)| share(encoder, *most_rad) > 1.0)
            .max_by(|one, other| share(one.1, one.2).total_cmp(&share(other.1, other.2)))?;
        let (expected_rad, found_rad) = worst.turned_rad();
        Some(EncoderContradiction {
            of,
            expected_rad,
            found_rad,
            apart_rad: worst.apart_rad(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::realtime::clock::MILLISECOND_NS;

    #[test]
    fn the_encoder_that_sticks_is_named_with_what_it_should_have_turned() {
        for (sticks, most_rad) in [
            (Measured::Left, 0.5),
            (Measured::Right, 0.5),
            (Measured::Pivot, 0.15),
        ] {
            let mut wheels = Wheels::default();
            let found = (1..=1000_u16).find_map(|cycle| {
                let at_s = f32::from(cycle) * 1e-3;
                let turned_rad = |of, rad_s: f32| if of == sticks { 0.0 } else { rad_s * at_s };
                let feedback = Feedback {
                    left_rad: turned_rad(Measured::Left, 7.0),
                    right_rad: turned_rad(Measured::Right, 7.0),
                    pivot_rad: turned_rad(Measured::Pivot, 2.0),
                    left_rad_s: 7.0,
                    right_rad_s: 7.0,
                    pivot_rad_s: 2.0,
                    ..Feedback::default()
                };
                let now_ns = u64::from(cycle) * MILLISECOND_NS;
                wheels.read(&feedback, 0.0, 0, now_ns);
                wheels.contradict()
            });
            let found = found.expect("it sticks");
            let apart_rad = found.expected_rad - found.found_rad;
            assert!(
                found.of == sticks
                    && found.found_rad.abs() < 0.01
                    && (most_rad..most_rad + 0.1).contains(&apart_rad),
                "{found}"
            );
        }
    }
}
