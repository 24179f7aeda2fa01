//! Limits how fast the commanded speed rises and falls.

/// Below this the robot counts as standing and may reverse, m/s.
const STANDING_M_S: f64 = 0.02;
/// The ramp runs at most this much ahead of the measured speed, m/s.
const AHEAD_M_S: f64 = 0.2;

/// The speed commanded last, and the limits of its change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedRamp {
    acceleration_m_s2: f64,
    deceleration_m_s2: f64,
    speed_m_s: f64,
}

impl SpeedRamp {
    /// At standstill.
    #[must_use]
    pub fn new(acceleration_m_s2: f64, deceleration_m_s2: f64) -> Self {
        Self {
            acceleration_m_s2,
            deceleration_m_s2,
            speed_m_s: 0.0,
        }
    }

    /// The speed commanded last.
    #[must_use]
    pub fn speed_m_s(&self) -> f64 {
        self.speed_m_s
    }

    /// The next speed, in the direction of `wish_m_s`. It approaches the wish at the ramp's slopes; the limit `safe_m_s`
    /// (positive) applies at once. A change of direction waits for standstill.
    pub fn step(&mut self, wish_m_s: f64, safe_m_s: f64, measured_m_s: f64, dt_s: f64) -> f64 {
        let reach_m_s = measured_m_s.abs() + AHEAD_M_S;
        let mut speed_m_s = self.speed_m_s.max(-reach_m_s).min(reach_m_s);
        let against = |other_m_s: f64| other_m_s * wish_m_s < 0.0;
        let turning =
            (against(measured_m_s) && measured_m_s.abs() > STANDING_M_S) || against(speed_m_s);
        let target_m_s = if turning || wish_m_s.is_nan() {
            0.0
        } else {
            wish_m_s
        };
        let slope_m_s2 = if target_m_s.abs() > speed_m_s.abs() {
            self.acceleration_m_s2
        } else {
            self.deceleration_m_s2
        };
        let step_m_s = slope_m_s2 * dt_s;
        speed_m_s += (target_m_s - speed_m_s).max(-step_m_s).min(step_m_s);
        let safe_m_s = safe_m_s.max(0.0);
        self.speed_m_s = speed_m_s.max(-safe_m_s).min(safe_m_s);
        self.speed_m_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT_S: f64 = 0.05;

    fn drive(ramp: &mut SpeedRamp, speed_m_s: &mut f64, wish_m_s: f64, steps: usize) {
        for _ in 0..steps {
            let before_m_s = *speed_m_s;
            *speed_m_s = ramp.step(wish_m_s, f64::INFINITY, *speed_m_s, DT_S);
            let slope_m_s2 = (speed_m_s.abs() - before_m_s.abs()) / DT_S;
            assert!(
                (-0.4 - 1e-9..=0.5 + 1e-9).contains(&slope_m_s2),
                "{slope_m_s2}"
            );
            assert!(
                *speed_m_s * before_m_s >= 0.0,
                "a reversal stands in between"
            );
        }
    }

    #[test]
    fn it_keeps_to_both_slopes_and_stands_before_it_turns_back() {
        let mut ramp = SpeedRamp::new(0.5, 0.4);
        let mut speed_m_s = 0.0;
        for (wish_m_s, steps) in [(0.4, 20), (0.2, 15), (0.3, 10), (-0.1, 40), (0.4, 40)] {
            drive(&mut ramp, &mut speed_m_s, wish_m_s, steps);
            assert!(
                (speed_m_s - wish_m_s).abs() < 1e-9,
                "{wish_m_s} {speed_m_s}"
            );
        }
    }

    #[test]
    fn what_is_safe_holds_at_once_and_the_ramp_goes_on_from_there() {
        let mut ramp = SpeedRamp::new(0.5, 0.4);
        let mut speed_m_s = 0.0;
        drive(&mut ramp, &mut speed_m_s, 0.4, 20);
        assert_eq!(ramp.step(0.4, 0.1, 0.4, DT_S), 0.1);
        assert!((ramp.step(0.4, 1.0, 0.1, DT_S) - 0.125).abs() < 1e-9);
        assert_eq!(ramp.step(0.4, 0.0, 0.1, DT_S), 0.0);
    }

    #[test]
    fn what_is_no_number_stops() {
        let mut ramp = SpeedRamp::new(0.5, 0.4);
        for (wish_m_s, safe_m_s, measured_m_s) in [
            (f64::NAN, 1.0, 0.1),
            (0.4, f64::NAN, 0.1),
            (0.4, 1.0, f64::NAN),
        ] {
            for _ in 0..100 {
                let speed_m_s = ramp.step(wish_m_s, safe_m_s, measured_m_s, DT_S);
                assert!((0.0..=0.4).contains(&speed_m_s), "{speed_m_s}");
            }
        }
        assert_eq!(ramp.step(0.4, f64::NAN, 0.1, DT_S), 0.0);
    }
}
