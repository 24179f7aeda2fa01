//! What the drive's encoders say, in the robot's terms.

use description::wheels::{EncoderAngles, WheelSpeeds};
use drivers::kelo::{Feedback, WheelEncoder};

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

    /// How far an encoder's angle and speed are apart, when that is too far.
    pub(super) fn contradict(&self) -> Option<f64> {
        let [left, right] = [self.left, self.right].map(|encoder| encoder.apart_rad());
        let worst = if left.abs() > right.abs() {
            left
        } else {
            right
        };
        (worst.abs() > APART_RAD).then_some(worst)
    }
}
