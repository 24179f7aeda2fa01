//! `[tubes]`: the motion tubes.

use std::f64::consts::FRAC_PI_2;

use super::{DURATION, GAIN};
use crate::geometry::Footprint;
use crate::keys::{Count, Flat, KeyError, List, Need, Quantity, SPEED, rounded};
use crate::section;

const CURVATURE: Quantity = Quantity::new("a curvature", "1/m")
    .at_least(0.0)
    .at_most(20.0);
const BAND: Quantity = Quantity::new("a curvature", "1/m")
    .at_least(0.0)
    .at_most(10.0);
const STEP: Quantity = Quantity::new("a length", "m").at_least(0.01).at_most(1.0);
const MARGIN: Quantity = Quantity::new("a length", "m").at_least(0.0).at_most(2.0);
/// The most turn rates of a horizon: steps of 0.18° over ±π/2 leave no gap between tubes of 4 s.
const MOST_OMEGA_STEPS: u32 = 1001;
/// The most rows in one direction: evaluation takes time in proportion.
const MOST_HORIZONS: usize = 16;
const ROWS: &str = "tables { horizon_s = …, speed_m_s = … }";

section! {
    /// One row of tubes: their duration and their speed.
    #[derive(Copy)]
    pub struct Horizon {
        /// How far ahead in time.
        pub horizon_s: f64 as Quantity::new("a duration", "s").above(0.0).at_most(10.0),
        /// The speed, and the highest that a free tube of this row allows.
        pub speed_m_s: f64 as SPEED,
    }
}

section! {
    /// The set of motion tubes (`omega_steps` for each horizon), and how commands are adapted to it.
    pub struct Tubes: Default {
        /// Durations and speeds ahead, the shortest way first.
        pub horizons: Vec<Horizon> as List(ROWS, Need::Required) => Horizon::of_a_small_robot(),
        /// The same, driven backwards; left out: the robot never drives backwards.
        pub backward_horizons: Vec<Horizon> as List(ROWS, Need::Optional) => Vec::new(),
        /// Turn rates reach from minus to plus this.
        pub omega_max_rad_s: f64 as Quantity::new("a turn rate", "rad/s").above(0.0).at_most(10.0) => FRAC_PI_2,
        /// Turn rates per horizon, evenly spaced; odd, so that straight is one of them.
        pub omega_steps: u32 as Count::new("an odd count", 3, MOST_OMEGA_STEPS) => 41,
        /// Spacing of the samples on a tube's border: no larger object slips between them.
        pub sample_step_m: f64 as STEP => 0.05,
        /// How far outside the border the samples lie: what the robot keeps from everything, and at least half of `sample_step_m` plus
        /// the sensor's error.
        pub augment_m: f64 as STEP => 0.1,
        /// The same while somebody who sees the robot drives it by hand: where nothing wider is free it creeps, at the lowest speeds
        /// of both directions.
        pub by_hand_augment_m: f64 as STEP => 0.06,
        /// How long points beside the robot are remembered, in seconds of driving at the highest speed: slower driving
        /// forgets no more over the same distance.
        pub memory_s: f64 as Quantity::new("a duration", "s").above(0.0).at_most(10.0) => 2.0,
        /// Floor out of view that was seen free, or driven over, counts as free for this distance.
        pub floor_memory_m: f64 as Quantity::new("a way", "m").at_least(0.0).at_most(20.0) => 2.0,
        /// How commands are adapted to the tubes.
        pub adapt: AdaptPolicy as Flat => AdaptPolicy::default(),
    }
}

section! {
    /// How a wanted command is adapted to the tubes.
    #[derive(Copy)]
    pub struct AdaptPolicy: Default {
        /// Largest shift of a wanted curvature, so that the lane is kept.
        pub curvature_band_1_m: f64 as BAND => 0.4,
        /// Cost of giving up 1 m/s of speed, where shifting the curvature by 1 1/m costs 1.
        pub speed_weight: f64 as GAIN => 4.0,
        /// The other side must be better by this much curvature before a shift changes sides.
        pub hysteresis_1_m: f64 as BAND => 0.2,
        /// Free scans in a row that make a tube free; one blocked scan blocks it.
        pub free_scans: u32 as Count::new("a number of scans", 1, 50) => 3,
        /// From the evaluation of a scan until the wheels brake, whichever part of the robot hangs meanwhile.
        pub reaction_s: f64 as Quantity::new("a duration", "s").at_least(0.0).at_most(1.0) => 0.2,
        /// After a stop for want of a free tube, the way must be free for this long.
        pub resume_after_s: f64 as DURATION => 2.0,
        /// The way around things that stand.
        pub detour: DetourPolicy as Flat => DetourPolicy::default(),
        /// Caution about things that move.
        pub moving: MovingPolicy as Flat => MovingPolicy::default(),
    }
}

section! {
    /// How the robot gets around a standing thing that its way leads into.
    #[derive(Copy)]
    pub struct DetourPolicy: Default {
        /// Tightest curve of a detour around a stationary obstacle; 0: no detours, the robot stops before it, as it must where areas are managed.
        pub curvature_1_m @ "detour_curvature_1_m": f64 as CURVATURE => 0.0,
        /// Largest heading change of a detour from the direction in which the robot was blocked.
        pub heading_rad @ "detour_heading_rad": f64
            as Quantity::new("an angle", "rad").at_least(0.0).at_most(FRAC_PI_2) => 1.5,
        /// Highest speed on a detour.
        pub speed_m_s @ "detour_speed_m_s": f64 as SPEED => 0.25,
        /// How long the robot is blocked before a detour begins.
        pub after_s @ "detour_after_s": f64 as DURATION => 0.1,
        /// Where no detour exists, the robot backs up this far over known floor; 0: never. It cannot see what comes up
        /// behind it.
        pub retreat_m @ "detour_retreat_m": f64 as MARGIN => 0.4,
    }
}

section! {
    /// How fast things that were seen to move may come nearer: the robot drives no faster than lets it stand before
    /// such a thing, coming straight at it, arrives.
    #[derive(Copy)]
    pub struct MovingPolicy: Default {
        /// Speed at which things that were seen to move may approach; 0: motion is ignored.
        pub speed_m_s @ "moving_speed_m_s": f64
            as Quantity::new("a speed", "m/s").at_least(0.0).at_most(5.0) => 1.0,
        /// Distance that remains between a moving thing and the robot when it stands.
        pub margin_m @ "moving_margin_m": f64 as MARGIN => 0.05,
        /// A thing that has moved is expected to move again for this long after it came to rest.
        pub rest_s @ "moving_rest_s": f64 as DURATION => 4.0,
    }
}

impl Horizon {
    /// The length of the path of `base_link`.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.horizon_s * self.speed_m_s
    }

    fn of_a_small_robot() -> Vec<Self> {
        [
            (1.0, 0.10),
            (1.0, 0.25),
            (2.0, 0.30),
            (3.0, 0.35),
            (4.0, 0.40),
        ]
        .map(|(horizon_s, speed_m_s)| Self {
            horizon_s,
            speed_m_s,
        })
        .into()
    }
}

impl Tubes {
    /// The highest speed ahead.
    #[must_use]
    pub fn fastest_m_s(&self) -> f64 {
        let speeds = self.horizons.iter().map(|horizon| horizon.speed_m_s);
        speeds.fold(0.0, f64::max)
    }

    /// From a turn rate to the next.
    #[must_use]
    pub fn omega_step_rad_s(&self) -> f64 {
        2.0 * self.omega_max_rad_s / f64::from(self.omega_steps - 1)
    }

    /// What does not fit together, for a robot with this outline; each value is within its own range. A value that is
    /// not a number is not judged.
    #[must_use]
    pub fn contradictions(&self, footprint: &Footprint) -> Vec<KeyError> {
        let mut errors = Vec::new();
        if self.omega_steps.is_multiple_of(2) {
            errors.push(KeyError::new(
                "omega_steps",
                self.omega_steps.to_string(),
                "an odd count, so that driving straight is one of them",
            ));
        }
        let margins = [
            ("augment_m", self.augment_m),
            ("by_hand_augment_m", self.by_hand_augment_m),
        ];
        let half_m = self.sample_step_m / 2.0;
        for (key, margin_m) in margins.into_iter().filter(|(_, own)| *own < half_m) {
            let half_m = rounded(half_m);
            errors.push(KeyError::new(
                key,
                format!("{margin_m:?}"),
                format!("at least {half_m} m, half of `sample_step_m`: less leaves objects unseen"),
            ));
        }
        let before = errors.len();
        horizons_grow("horizons", &self.horizons, &mut errors);
        horizons_grow("backward_horizons", &self.backward_horizons, &mut errors);
        if errors.len() == before {
            errors.extend(self.ends_apart(footprint.width_m()));
        }
        errors
            .iter_mut()
            .for_each(|error| error.key.insert_str(0, "tubes."));
        errors
    }

    /// Between the ends of two neighbouring tubes no path may fit that leaves both.
    fn ends_apart(&self, width_m: f64) -> Option<KeyError> {
        // Curvatures 2 omega_max / (steps - 1) / v apart end that times half the length squared apart.
        let rows = self.horizons.iter().chain(&self.backward_horizons);
        let needed = rows
            .map(|row| 1.0 + self.omega_max_rad_s * row.length_m() * row.horizon_s / width_m)
            .fold(0.0, f64::max);
        (f64::from(self.omega_steps) <= needed).then(|| {
            KeyError::new(
                "omega_steps",
                self.omega_steps.to_string(),
                format!("over {needed:.1}, so that neighbouring tubes end less than the robot's width, {width_m} m, apart"),
            )
        })
    }
}

/// Longer ways are not slower, and there are not too many of them.
fn horizons_grow(key: &str, horizons: &[Horizon], errors: &mut Vec<KeyError>) {
    let mut wrong = |key: String, found: String, expected: String| {
        errors.push(KeyError::new(key, found, expected));
    };
    for (index, pair) in horizons.windows(2).enumerate() {
        let (before, this) = (pair[0], pair[1]);
        let at = |name: &str| format!("{key}[{}].{name}", index + 1);
        if this.length_m() <= before.length_m() {
            let (horizon_s, speed_m_s) = (before.horizon_s, before.speed_m_s);
            let expected =
                format!("a longer way than the one before it, {horizon_s} s at {speed_m_s} m/s");
            wrong(at("horizon_s"), format!("{:?}", this.horizon_s), expected);
        }
        if this.speed_m_s < before.speed_m_s {
            let expected = format!(
                "at least that of the one before it, {} m/s",
                before.speed_m_s
            );
            wrong(at("speed_m_s"), format!("{:?}", this.speed_m_s), expected);
        }
    }
    if horizons.len() > MOST_HORIZONS {
        let found = format!("{} horizons", horizons.len());
        wrong(key.to_owned(), found, format!("at most {MOST_HORIZONS}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::keys::Section;

    #[test]
    fn the_most_turn_rates_are_allowed_and_no_more() {
        let with = |omega_steps| Tubes {
            omega_steps,
            ..Tubes::default()
        };
        assert!(with(1001).check().is_ok());
        let error = with(1003).check().unwrap_err();
        assert_eq!(
            (error.key.as_str(), error.found.as_str()),
            ("omega_steps", "1003")
        );
    }
}
