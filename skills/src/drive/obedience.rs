//! Whether the wheels do what they are told: whoever plans a way relies on their speed, and on their braking.
//!
//! What a wheel may do is what it was told within the last moments, from the slowest to the fastest of it. How far it has
//! turned beyond that is summed up and forgotten within a second: a wheel that is slow to follow, brakes too weakly, turns
//! the wrong way, is blocked or rolls away exceeds its limit soon, and one whose speed is merely measured with noise never
//! does. A wheel that is told to stand, and has, may not turn farther than that at all.

use std::fmt;

use description::wheels::{EncoderAngles, WheelSpeeds};

use super::STANDING_RAD_S;
use super::window::{MILLISECOND_NS, Window};

/// What a wheel has turned too far is forgotten with this time constant.
const FORGOTTEN_S: f64 = 1.0;
/// Longest time that one exchange stands for.
const LONGEST_STEP_NS: u64 = 20 * MILLISECOND_NS;
/// A wheel that was told to stand for this long, and does, stays where it is.
const RESTS_NS: u64 = 500 * MILLISECOND_NS;
/// And one that was told to stand for this long is to do so: how far it creeps from then on counts, however slow it is.
const RESTS_AT_LAST_NS: u64 = 1000 * MILLISECOND_NS;

/// What disobeys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The left wheel.
    Left,
    /// The right wheel.
    Right,
    /// Both wheels, one too far and one not far enough: the unit does not turn under the platform.
    Pivot,
}

/// A wheel does not do what it was told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disobedience {
    /// Which.
    pub part: Part,
    /// The slowest and the fastest speed that it was told lately; of the left wheel for the pivot.
    pub told_rad_s: [f64; 2],
    /// The speed that it says it has.
    pub found_rad_s: f64,
    /// How far it has turned beyond what it was told; negative: not far enough forward.
    pub beyond_rad: f64,
}

impl fmt::Display for Disobedience {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [low, high] = self.told_rad_s;
        let (found, beyond) = (self.found_rad_s, self.beyond_rad);
        f.write_str(match self.part {
            Part::Left => "the left wheel",
            Part::Right => "the right wheel",
            Part::Pivot => "the pivot does not turn as told: the left wheel",
        })?;
        write!(
            f,
            " was told {low:.2} to {high:.2} rad/s, turns at {found:.2} rad/s and is {beyond:.2} rad beyond"
        )
    }
}

/// Watches both wheels.
///
/// Real time: nothing here allocates, locks or panics.
#[derive(Debug)]
pub struct Obedience {
    /// How far a wheel may turn beyond what it was told.
    limit_rad: f64,
    judged_ns: Option<u64>,
    /// Since when both were told to stand,
    told_to_stand_ns: u64,
    /// and do.
    rests_since_ns: u64,
    wheels: [Wheel; 2],
}

#[derive(Clone, Copy, Debug, Default)]
struct Wheel {
    told: Window,
    beyond_rad: f64,
    /// Where it came to rest.
    rests_at_rad: Option<f64>,
}

impl Wheel {
    /// What it does at the beginning is no disobedience, nor anything slower.
    fn begin(speed_rad_s: f64, now_ns: u64) -> Self {
        let mut wheel = Self::default();
        wheel.told.add(speed_rad_s, now_ns);
        wheel.told.add(0.0, now_ns);
        wheel
    }

    fn judge(&mut self, told_rad_s: f64, found_rad_s: f64, elapsed_s: f64, now_ns: u64) {
        self.told.add(told_rad_s, now_ns);
        let [least, most] = self.told.range();
        let error_rad_s = found_rad_s - found_rad_s.clamp(least, most);
        self.beyond_rad += error_rad_s * elapsed_s;
        self.beyond_rad -= self.beyond_rad * (elapsed_s / FORGOTTEN_S);
    }
}

impl Obedience {
    /// Wheels that may turn `limit_rad` beyond what they were told, within a second.
    #[must_use]
    pub fn new(limit_rad: f64) -> Self {
        Self {
            limit_rad,
            judged_ns: None,
            told_to_stand_ns: 0,
            rests_since_ns: 0,
            wheels: [Wheel::default(); 2],
        }
    }

    /// The wheels are not told anything, or not heard: what they do is judged anew from the next time on.
    pub fn forget(&mut self) {
        *self = Self::new(self.limit_rad);
    }

    /// What was sent, and what the drive says; the worst of what disobeys.
    pub fn judge(
        &mut self,
        told: WheelSpeeds,
        found: WheelSpeeds,
        angles: EncoderAngles,
        now_ns: u64,
    ) -> Option<Disobedience> {
        if !(told.is_finite() && found.is_finite()) {
            return None;
        }
        let found = [found.left_rad_s, found.right_rad_s];
        let Some(judged_ns) = self.judged_ns.replace(now_ns) else {
            self.wheels = found.map(|speed| Wheel::begin(speed, now_ns));
            self.told_to_stand_ns = now_ns;
            return None;
        };
        let elapsed_ns = now_ns.saturating_sub(judged_ns).min(LONGEST_STEP_NS);
        let elapsed_s = elapsed_ns as f64 / 1e9;
        for (wheel, (told, found)) in self
            .wheels
            .iter_mut()
            .zip([told.left_rad_s, told.right_rad_s].into_iter().zip(found))
        {
            wheel.judge(told, found, elapsed_s, now_ns);
        }
        self.judge_rest(told, found, [angles.left_rad, angles.right_rad], now_ns);
        self.worst(found)
    }

    /// Wheels that rest and turn all the same are beyond by how far they have turned.
    fn judge_rest(
        &mut self,
        told: WheelSpeeds,
        found: [f64; 2],
        angles_rad: [f64; 2],
        now_ns: u64,
    ) {
        if told != WheelSpeeds::STANDING {
            (self.told_to_stand_ns, self.rests_since_ns) = (now_ns, now_ns);
            self.wheels
                .iter_mut()
                .for_each(|own| own.rests_at_rad = None);
            return;
        }
        let stands = found.iter().all(|speed| speed.abs() < STANDING_RAD_S);
        let rests = stands && now_ns.saturating_sub(self.rests_since_ns) > RESTS_NS
            || now_ns.saturating_sub(self.told_to_stand_ns) > RESTS_AT_LAST_NS;
        for (wheel, angle_rad) in self.wheels.iter_mut().zip(angles_rad) {
            match wheel.rests_at_rad {
                Some(at_rad) => {
                    let rolled_rad = angle_rad - at_rad;
                    if rolled_rad.abs() > wheel.beyond_rad.abs() {
                        wheel.beyond_rad = rolled_rad;
                    }
                }
                None if rests => wheel.rests_at_rad = Some(angle_rad),
                None => {}
            }
        }
        if !stands && self.wheels.iter().all(|own| own.rests_at_rad.is_none()) {
            self.rests_since_ns = now_ns;
        }
    }

    fn worst(&self, found: [f64; 2]) -> Option<Disobedience> {
        let [left, right] = self.wheels.map(|wheel| wheel.beyond_rad);
        let worst = usize::from(right.abs() > left.abs());
        let beyond_rad = [left, right][worst];
        if beyond_rad.abs() <= self.limit_rad {
            return None;
        }
        // Against each other and alike: they steer, and the pivot is held.
        let opposed = left * right < 0.0 && left.abs().min(right.abs()) > 0.5 * beyond_rad.abs();
        let (part, shown) = match worst {
            _ if opposed => (Part::Pivot, 0),
            0 => (Part::Left, 0),
            _ => (Part::Right, 1),
        };
        Some(Disobedience {
            part,
            told_rad_s: self.wheels[shown].told.range(),
            found_rad_s: found[shown],
            beyond_rad: [left, right][shown],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// 2 cm at the rim of a wheel of 10 cm.
    const LIMIT_RAD: f64 = 0.38;
    /// Wheels of the drive follow with this time constant.
    const TAU_S: f64 = 0.015;

    /// Wheels that follow as `how` says, given what was told, what they do, and for how long; judged for `cycles` milliseconds.
    fn found(
        cycles: u64,
        told: impl Fn(u64) -> WheelSpeeds,
        mut how: impl FnMut(u64, f64, f64, usize) -> f64,
    ) -> Option<(u64, Disobedience)> {
        let mut obedience = Obedience::new(LIMIT_RAD);
        let (mut speeds, mut angles) = ([0.0; 2], [0.0; 2]);
        for cycle in 1..=cycles {
            let asked = told(cycle);
            for (side, asked) in [asked.left_rad_s, asked.right_rad_s]
                .into_iter()
                .enumerate()
            {
                speeds[side] = how(cycle, asked, speeds[side], side);
                angles[side] += speeds[side] * 1e-3;
            }
            let angles = EncoderAngles {
                left_rad: angles[0],
                right_rad: angles[1],
                pivot_rad: 0.0,
            };
            let speeds = WheelSpeeds::new(speeds[0], speeds[1]);
            let what = obedience.judge(asked, speeds, angles, cycle * MILLISECOND_NS);
            if let Some(what) = what {
                return Some((cycle, what));
            }
        }
        None
    }

    fn follows(asked: f64, speed: f64) -> f64 {
        speed + (asked - speed) * (1e-3 / TAU_S)
    }

    /// Up to 7.6 rad/s (0.4 m/s) at 10 rad/s², and down again at 38 rad/s² (2 m/s²) from 2 s on.
    fn drive(cycle: u64) -> WheelSpeeds {
        let s = cycle as f64 * 1e-3;
        let speed = if s < 2.0 {
            (10.0 * s).min(7.6)
        } else {
            (7.6 - 38.0 * (s - 2.0)).max(0.0)
        };
        WheelSpeeds::new(speed, speed)
    }

    #[test]
    fn wheels_that_follow_obey() {
        assert_eq!(
            found(4000, drive, |_, asked, speed, _| follows(asked, speed)),
            None
        );
    }

    #[test]
    fn a_wheel_that_turns_the_wrong_way_is_named() {
        let wrong =
            |_, asked: f64, speed, side| follows(if side == 1 { -asked } else { asked }, speed);
        let (cycle, what) = found(4000, drive, wrong).expect("found");
        assert!(
            what.part == Part::Right && what.beyond_rad < 0.0 && cycle < 400,
            "{cycle} {what}"
        );
    }

    #[test]
    fn weak_brakes_are_found_while_they_brake() {
        // Half of what was told.
        let weak = |_, asked: f64, speed: f64, _| follows(asked, speed).max(speed - 19e-3);
        let (cycle, what) = found(4000, drive, weak).expect("found");
        assert!(
            (2200..2400).contains(&cycle) && what.beyond_rad > 0.0,
            "{cycle} {what}"
        );
    }

    #[test]
    fn a_wheel_that_is_blocked_and_one_that_rolls_away_are_found() {
        let blocked = |_, asked, speed, side| {
            if side == 0 {
                0.0
            } else {
                follows(asked, speed)
            }
        };
        let (cycle, what) = found(4000, drive, blocked).expect("found");
        assert!(what.part == Part::Left && cycle < 500, "{cycle} {what}");
        // At 1 cm/s, on a slope, three seconds after it has come to rest.
        let rolls = |cycle, asked, speed, _| {
            if cycle > 5000 {
                0.2
            } else {
                follows(asked, speed)
            }
        };
        let (cycle, what) = found(9000, drive, rolls).expect("found");
        assert!((6700..7500).contains(&cycle), "{cycle} {what}");
    }

    #[test]
    fn a_wheel_that_never_comes_to_rest_is_found_however_slowly_it_creeps() {
        // At 1 to 2 cm/s: slower than what is found by speed, and faster than what stands.
        for creep_rad_s in [0.22, 0.3, 0.37] {
            let creeps = |_, asked, speed, side: usize| {
                let least = if side == 0 { creep_rad_s } else { 0.0 };
                follows(asked, speed).max(least)
            };
            // It is told to stand from 2.2 s on.
            let (cycle, what) = found(9000, drive, creeps).expect("found");
            assert!((3200..5200).contains(&cycle), "{cycle} {what}");
            assert_eq!(what.part, Part::Left);
        }
    }

    #[test]
    fn a_unit_that_does_not_turn_is_the_pivots_fault() {
        let steer = |_| WheelSpeeds::new(-2.0, 2.0);
        let (_, what) = found(4000, steer, |_, _, _, _| 0.0).expect("found");
        assert_eq!(what.part, Part::Pivot);
    }

    #[test]
    fn wheels_that_turn_when_they_are_told_to_stand_may_slow_down_first() {
        let mut obedience = Obedience::new(LIMIT_RAD);
        let mut speed = 7.6;
        for cycle in 1..1000 {
            let found = WheelSpeeds::new(speed, speed);
            let judged = obedience.judge(
                WheelSpeeds::STANDING,
                found,
                EncoderAngles::default(),
                cycle * MILLISECOND_NS,
            );
            assert_eq!(judged, None);
            speed = follows(0.0, speed);
        }
    }

    proptest! {
        /// Noise of a speed, whatever the setpoints do, as long as a wheel can follow them.
        #[test]
        fn noise_is_no_disobedience(
            seed in any::<u64>(),
            steps in prop::collection::vec(-8.0_f64..8.0, 2..12),
            noise_rad_s in 0.0_f64..0.6,
        ) {
            let mut random = seed | 1;
            let mut draw = move || {
                random ^= random << 13;
                random ^= random >> 7;
                random ^= random << 17;
                (random >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
            };
            let told = |cycle: u64| {
                // From one to the next at 40 rad/s².
                let index = (cycle / 600) as usize % steps.len();
                let (from, to) = (steps[(index + steps.len() - 1) % steps.len()], steps[index]);
                let way = 40e-3 * (cycle % 600) as f64;
                let speed = from + (to - from).clamp(-way, way);
                WheelSpeeds::new(speed, -0.5 * speed)
            };
            let mut exact = [0.0; 2];
            let result = found(6000, told, |_, asked, _, side| {
                exact[side] = follows(asked, exact[side]);
                exact[side] + 2.0 * noise_rad_s * draw()
            });
            prop_assert!(result.is_none(), "{result:?}");
        }
    }
}
