//! `[tubes]`: the motion tubes.

use std::f64::consts::FRAC_PI_2;

use super::{DURATION, GAIN, SPEED};
use crate::keys::{Count, List, Need, Quantity};
use crate::section;

const CURVATURE: Quantity = Quantity::new("a curvature", "1/m")
    .at_least(0.0)
    .at_most(20.0);
const STEP: Quantity = Quantity::new("a length", "m").at_least(0.01).at_most(1.0);
const MARGIN: Quantity = Quantity::new("a length", "m").at_least(0.0).at_most(2.0);
/// The most turn rates of a horizon.
pub const MOST_OMEGA_STEPS: u32 = 1001;
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
    pub struct Tubes {
        /// Durations and speeds ahead, the shortest way first.
        pub horizons: Vec<Horizon> as List(ROWS, Need::Required),
        /// The same, driven backwards; left out: the robot never drives backwards.
        pub backward_horizons: Vec<Horizon> as List(ROWS, Need::Optional),
        /// Turn rates reach from minus to plus this.
        pub omega_max_rad_s: f64 as Quantity::new("a turn rate", "rad/s").above(0.0).at_most(10.0) => FRAC_PI_2,
        /// Turn rates per horizon, evenly spaced; odd, so that straight is one of them.
        pub omega_steps: u32 as Count::new("an odd count", 3, MOST_OMEGA_STEPS) => 41,
        /// Spacing of the samples on a tube's border: no larger object slips between them.
        pub sample_step_m: f64 as STEP => 0.05,
        /// How far outside the border the samples lie: at least half of `sample_step_m` plus the sensor's error.
        pub augment_m: f64 as STEP => 0.06,
        /// Largest shift of a wanted curvature, so that the lane is kept.
        pub curvature_band_1_m: f64 as CURVATURE => 0.4,
        /// Cost of giving up 1 m/s of speed, where shifting the curvature by 1 1/m costs 1.
        pub speed_weight: f64 as GAIN => 4.0,
        /// The other side must be better by this much curvature before a shift changes sides.
        pub hysteresis_1_m: f64 as CURVATURE => 0.2,
        /// Free scans in a row that make a tube free; one blocked scan blocks it.
        pub free_scans: u32 as Count::new("a number of scans", 1, 50) => 3,
        /// From a command to the beginning of its deceleration.
        pub reaction_s: f64 as Quantity::new("a duration", "s").at_least(0.0).at_most(1.0) => 0.1,
        /// After a stop for want of a free tube, the way must be free for this long.
        pub resume_after_s: f64 as DURATION => 2.0,
        /// How long points beside the robot are remembered, in seconds of driving at the highest speed: slower driving
        /// forgets no more over the same distance.
        pub memory_s: f64 as DURATION => 2.0,
        /// Floor out of view that was seen free, or driven over, counts as free for this distance.
        pub floor_memory_m: f64 as Quantity::new("a way", "m").at_least(0.0).at_most(20.0) => 2.0,
        /// Tightest curve of a detour around a stationary obstacle; 0: no detours, the robot stops before it.
        pub detour_curvature_1_m: f64 as CURVATURE => 0.0,
        /// Largest heading change of a detour from the direction in which the robot was blocked.
        pub detour_heading_rad: f64 as Quantity::new("an angle", "rad").at_least(0.0).at_most(FRAC_PI_2) => 1.5,
        /// Highest speed on a detour.
        pub detour_speed_m_s: f64 as SPEED => 0.25,
        /// How long the robot is blocked before a detour begins.
        pub detour_after_s: f64 as DURATION => 0.1,
        /// Where no detour exists, the robot backs up this far over known floor; 0: never. It cannot see what comes up
        /// behind it.
        pub detour_retreat_m: f64 as MARGIN => 0.4,
        /// Speed at which things that were seen to move may approach; 0: motion is ignored.
        pub moving_speed_m_s: f64 as Quantity::new("a speed", "m/s").at_least(0.0).at_most(5.0) => 1.0,
        /// Distance that remains between a moving thing and the robot when it stands.
        pub moving_margin_m: f64 as MARGIN => 0.05,
        /// A thing that has moved is expected to move again for this long after it came to rest.
        pub moving_rest_s: f64 as DURATION => 4.0,
    }
}
