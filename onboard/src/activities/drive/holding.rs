//! How much current standing wheels get.

use crate::realtime::clock::SECOND_NS;
use description::wheels::{EncoderAngles, WheelSpeeds};
use skills::drive::STANDING_RAD_S;

/// Wheels that have stood for this long need less current,
const RELAXES_NS: u64 = SECOND_NS / 2;
/// unless they turn by more than this with it: 1 mm at the rim of a wheel of 10 cm.
const MOVED_RAD: f64 = 0.02;

/// Whether standing wheels may be held with less current: once they have stood for half a second, and as long as they do. Wheels
/// that move then, on a slope, get all of it back until they have driven.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Holding {
    /// Since when they stand, as they were told.
    stands_since_ns: Option<u64>,
    /// Where they stood when the current fell.
    relaxed_at: Option<EncoderAngles>,
    /// They moved with less.
    needs_all: bool,
}

impl Holding {
    /// Whether less current will do, for wheels that were told this and say that.
    pub(super) fn relaxes(
        &mut self,
        told: WheelSpeeds,
        found: WheelSpeeds,
        angles: EncoderAngles,
        now_ns: u64,
    ) -> bool {
        if told != WheelSpeeds::STANDING {
            *self = Self::default();
            return false;
        }
        let moves = found.fastest_rad_s() > STANDING_RAD_S;
        if let Some(at) = self.relaxed_at {
            let turned = WheelSpeeds::new(
                angles.left_rad - at.left_rad,
                angles.right_rad - at.right_rad,
            );
            self.needs_all |= moves || turned.fastest_rad_s() > MOVED_RAD;
        }
        if moves {
            (self.stands_since_ns, self.relaxed_at) = (None, None);
            return false;
        }
        let since_ns = *self.stands_since_ns.get_or_insert(now_ns);
        let relaxes = !self.needs_all && now_ns - since_ns >= RELAXES_NS;
        self.relaxed_at = relaxes.then(|| self.relaxed_at.unwrap_or(angles));
        relaxes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::realtime::clock::MILLISECOND_NS;

    #[test]
    fn current_falls_after_half_a_second_of_standing_and_returns_when_wheels_move() {
        let mut holding = Holding::default();
        let at = |left_rad| EncoderAngles {
            left_rad,
            ..EncoderAngles::default()
        };
        let (zero, rolling) = (WheelSpeeds::STANDING, WheelSpeeds::new(3.0, 3.0));
        let ms = |time: u64| time * MILLISECOND_NS;
        assert!(!holding.relaxes(rolling, rolling, at(0.0), ms(1)));
        // Told to stand, it rolls out first.
        assert!(!holding.relaxes(zero, rolling, at(0.1), ms(2)));
        assert!(!holding.relaxes(zero, zero, at(0.2), ms(100)));
        assert!(!holding.relaxes(zero, zero, at(0.2), ms(599)));
        assert!(holding.relaxes(zero, zero, at(0.2), ms(600)));
        assert!(holding.relaxes(zero, zero, at(0.21), ms(700)));
        // It creeps down a slope.
        assert!(!holding.relaxes(zero, zero, at(0.23), ms(800)));
        assert!(!holding.relaxes(zero, zero, at(0.23), ms(5000)));
        // Until it has driven.
        assert!(!holding.relaxes(rolling, rolling, at(0.5), ms(5001)));
        assert!(!holding.relaxes(zero, zero, at(0.5), ms(5002)));
        assert!(holding.relaxes(zero, zero, at(0.5), ms(5502)));
        assert!(!holding.relaxes(zero, WheelSpeeds::new(0.0, -0.3), at(0.5), ms(5600)));
    }
}
