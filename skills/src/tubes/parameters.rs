//! What a set of tubes is made of, how commands are adapted to it, and what can be wrong with either.

use crate::scan::ScanGeometryError;
use thiserror::Error;

/// One row of tubes: how long ahead, at which speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Horizon {
    /// How long ahead.
    pub duration_s: f64,
    /// The speed, and the highest that a free tube of this row allows.
    pub speed_m_s: f64,
}

impl Horizon {
    /// The length of the path of `base_link`.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.duration_s * self.speed_m_s
    }
}

/// What a set of tubes is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct TubeParameters {
    /// The rows, in any order.
    pub horizons: Vec<Horizon>,
    /// Turning speeds are spread evenly over ± this.
    pub omega_max_rad_s: f64,
    /// How many turning speeds; odd, so that straight ahead is among them.
    pub omega_steps: usize,
    /// Discs and boxes larger than this do not slip between samples.
    pub d_sample_m: f64,
    /// How far outside the border the samples lie: half of `d_sample_m` plus the sensor's error.
    pub d_aug_m: f64,
    /// How long points beside the robot are remembered.
    pub memory_s: f64,
}

impl Default for TubeParameters {
    /// Horizons of one to four seconds at 0.25 to 0.40 m/s, for a small robot in a building.
    fn default() -> Self {
        let horizon = |duration_s, speed_m_s| Horizon {
            duration_s,
            speed_m_s,
        };
        Self {
            horizons: vec![
                horizon(1.0, 0.25),
                horizon(2.0, 0.30),
                horizon(3.0, 0.35),
                horizon(4.0, 0.40),
            ],
            omega_max_rad_s: std::f64::consts::FRAC_PI_2,
            omega_steps: 41,
            d_sample_m: 0.05,
            d_aug_m: 0.045,
            memory_s: 2.0,
        }
    }
}

/// How a wanted command is adapted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptPolicy {
    /// The curvature may be shifted by no more than this, so that the lane is kept.
    pub curvature_band_1_m: f64,
    /// What a lost m/s weighs against a shift of the curvature by one 1/m.
    pub speed_weight: f64,
    /// The other side must be better by this much curvature before a shift changes sides.
    pub hysteresis_1_m: f64,
    /// A tube counts as free after so many free scans in a row; as blocked after one.
    pub free_scans: u8,
    /// The deceleration that a stop can count on.
    pub stop_deceleration_m_s2: f64,
    /// From a command to the beginning of its deceleration.
    pub reaction_s: f64,
    /// After a stop for want of a free tube: drives on when one has been free for so long.
    pub resume_after_s: f64,
    /// Without a valid scan for this long it stops.
    pub scan_timeout_s: f64,
    /// After that, and at start, it drives on when scans have been good for so long.
    pub good_scans_s: f64,
}

impl Default for AdaptPolicy {
    fn default() -> Self {
        Self {
            curvature_band_1_m: 0.4,
            speed_weight: 4.0,
            hysteresis_1_m: 0.2,
            free_scans: 3,
            stop_deceleration_m_s2: 2.0,
            reaction_s: 0.1,
            resume_after_s: 2.0,
            scan_timeout_s: 0.25,
            good_scans_s: 2.0,
        }
    }
}

/// Why no set of tubes could be made, or no adaptation be set up.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum TubeError {
    /// A number that must be finite and positive.
    #[error("{name} is {found}; expected a number over 0")]
    NotPositive {
        /// Which.
        name: &'static str,
        /// Its value.
        found: f64,
    },
    /// A number outside its range.
    #[error("{name} is {found}; expected {min} to {max}")]
    OutOfRange {
        /// Which.
        name: &'static str,
        /// Its value.
        found: f64,
        /// Smallest allowed.
        min: f64,
        /// Largest allowed.
        max: f64,
    },
    /// No horizon at all.
    #[error("no horizon; expected at least one")]
    NoHorizon,
    /// Two horizons of the same length.
    #[error("two horizons are {length_m} m long; expected different lengths")]
    SameLength {
        /// That length.
        length_m: f64,
    },
    /// A faster horizon is shorter than a slower one.
    #[error(
        "the horizon of {speed_m_s} m/s is shorter than a slower one; expected longer horizons to be faster"
    )]
    FasterButShorter {
        /// Its speed.
        speed_m_s: f64,
    },
    /// An even number of turning speeds has no straight ahead.
    #[error("{found} turning speeds; expected an odd number")]
    EvenSteps {
        /// How many.
        found: usize,
    },
    /// Paths between two neighbouring tubes would leave both.
    #[error(
        "neighbouring tubes of {length_m} m end {gap_m} m apart; expected under the robot's width, {width_m} m: use more turning speeds"
    )]
    TubesApart {
        /// Length of the tubes.
        length_m: f64,
        /// How far apart their ends lie.
        gap_m: f64,
        /// The width of the robot.
        width_m: f64,
    },
    /// The samples lie too close to the tube.
    #[error("d_aug_m is {d_aug_m}; expected at least half of d_sample_m, {d_sample_m}")]
    AugmentedTooLittle {
        /// Found.
        d_aug_m: f64,
        /// The sample step.
        d_sample_m: f64,
    },
    /// The footprint has a side that is not positive.
    #[error("a side of the footprint is not over 0")]
    Footprint,
    /// A tail longer than the nose needs other templates.
    #[error(
        "the footprint reaches {rear_m} m back and {front_m} m forward; expected no more back than forward"
    )]
    LongTail {
        /// Back.
        rear_m: f64,
        /// Forward.
        front_m: f64,
    },
    /// The sensor must see the robot's surroundings from within.
    #[error("the sensor at ({x_m}, {y_m}) m is outside the footprint; expected inside")]
    SensorOutside {
        /// Forward.
        x_m: f64,
        /// Left.
        y_m: f64,
    },
    /// The scan geometry is unusable.
    #[error("scan geometry: {0}")]
    Scan(#[from] ScanGeometryError),
    /// Too many samples for their index.
    #[error("{samples} samples are too many")]
    TooLarge {
        /// How many.
        samples: usize,
    },
    /// The sensor can judge none of the tubes.
    #[error("all {tubes} tubes are refused, the first because {first}")]
    NothingLeft {
        /// How many were tried.
        tubes: usize,
        /// Why the first was refused.
        first: super::set::Refusal,
    },
}

/// The most turning speeds in a row.
pub const MAX_STEPS: usize = 1001;
/// The most rows.
pub const MAX_HORIZONS: usize = 32;

pub(crate) fn positive(name: &'static str, found: f64) -> Result<(), TubeError> {
    if found.is_finite() && found > 0.0 {
        Ok(())
    } else {
        Err(TubeError::NotPositive { name, found })
    }
}

fn within(name: &'static str, found: f64, min: f64, max: f64) -> Result<(), TubeError> {
    if (min..=max).contains(&found) {
        Ok(())
    } else {
        Err(TubeError::OutOfRange {
            name,
            found,
            min,
            max,
        })
    }
}

impl TubeParameters {
    /// Checks what can be checked without a robot.
    pub fn validate(&self) -> Result<(), TubeError> {
        if self.horizons.is_empty() {
            return Err(TubeError::NoHorizon);
        }
        within(
            "the number of horizons",
            self.horizons.len() as f64,
            1.0,
            MAX_HORIZONS as f64,
        )?;
        for horizon in &self.horizons {
            within("horizon duration_s", horizon.duration_s, 0.05, 60.0)?;
            within("horizon speed_m_s", horizon.speed_m_s, 0.01, 10.0)?;
        }
        for pair in self.sorted_horizons().windows(2) {
            let (longer, shorter) = (pair[0], pair[1]);
            if longer.length_m() - shorter.length_m() < 1e-6 {
                return Err(TubeError::SameLength {
                    length_m: longer.length_m(),
                });
            }
            if longer.speed_m_s < shorter.speed_m_s {
                return Err(TubeError::FasterButShorter {
                    speed_m_s: shorter.speed_m_s,
                });
            }
        }
        positive("omega_max_rad_s", self.omega_max_rad_s)?;
        if self.omega_steps.is_multiple_of(2) {
            return Err(TubeError::EvenSteps {
                found: self.omega_steps,
            });
        }
        within(
            "omega_steps",
            self.omega_steps as f64,
            3.0,
            MAX_STEPS as f64,
        )?;
        within("d_sample_m", self.d_sample_m, 0.005, 1.0)?;
        within("d_aug_m", self.d_aug_m, 0.0, 1.0)?;
        if self.d_aug_m < self.d_sample_m / 2.0 {
            return Err(TubeError::AugmentedTooLittle {
                d_aug_m: self.d_aug_m,
                d_sample_m: self.d_sample_m,
            });
        }
        within("memory_s", self.memory_s, 0.0, 10.0)
    }

    /// The horizons, the longest first.
    #[must_use]
    pub fn sorted_horizons(&self) -> Vec<Horizon> {
        let mut horizons = self.horizons.clone();
        horizons.sort_by(|a, b| b.length_m().total_cmp(&a.length_m()));
        horizons
    }

    /// From a turning speed to the next.
    #[must_use]
    pub fn omega_step_rad_s(&self) -> f64 {
        2.0 * self.omega_max_rad_s / (self.omega_steps - 1) as f64
    }
}

impl AdaptPolicy {
    /// Checks every number.
    pub fn validate(&self) -> Result<(), TubeError> {
        within("curvature_band_1_m", self.curvature_band_1_m, 0.0, 10.0)?;
        within("speed_weight", self.speed_weight, 0.0, 1e3)?;
        within("hysteresis_1_m", self.hysteresis_1_m, 0.0, 10.0)?;
        within("free_scans", f64::from(self.free_scans), 1.0, 100.0)?;
        within(
            "stop_deceleration_m_s2",
            self.stop_deceleration_m_s2,
            0.05,
            20.0,
        )?;
        within("reaction_s", self.reaction_s, 0.0, 2.0)?;
        within("resume_after_s", self.resume_after_s, 0.0, 60.0)?;
        within("scan_timeout_s", self.scan_timeout_s, 0.02, 5.0)?;
        within("good_scans_s", self.good_scans_s, 0.0, 60.0)
    }
}
