//! What a set of tubes is made of, and how commands are adapted to it.

use description::robot::MOST_OMEGA_STEPS;

use super::error::{TubeError, positive, within};

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
    /// The rows of tubes ahead, in any order.
    pub horizons: Vec<Horizon>,
    /// The rows of tubes behind, driven backwards; none when empty.
    pub backward: Vec<Horizon>,
    /// Turning speeds are spread evenly over ± this.
    pub omega_max_rad_s: f64,
    /// How many turning speeds; odd, so that straight ahead is among them.
    pub omega_steps: usize,
    /// Discs and boxes larger than this do not slip between samples.
    pub d_sample_m: f64,
    /// How far outside the border the samples lie: half of `d_sample_m` plus the sensor's error.
    pub d_aug_m: f64,
    /// How long points beside the robot are remembered, in seconds of driving at the highest speed: slower driving
    /// forgets no more than the same way.
    pub memory_s: f64,
    /// Floor out of view that was seen free, or driven over, counts as free for so long a way.
    pub floor_memory_m: f64,
}

impl Default for TubeParameters {
    /// Horizons of one to four seconds at 0.10 to 0.40 m/s, for a small robot in a building.
    fn default() -> Self {
        let horizon = |duration_s, speed_m_s| Horizon {
            duration_s,
            speed_m_s,
        };
        Self {
            horizons: vec![
                horizon(1.0, 0.10),
                horizon(1.0, 0.25),
                horizon(2.0, 0.30),
                horizon(3.0, 0.35),
                horizon(4.0, 0.40),
            ],
            backward: vec![horizon(1.5, 0.10)],
            omega_max_rad_s: std::f64::consts::FRAC_PI_2,
            omega_steps: 41,
            d_sample_m: 0.05,
            d_aug_m: 0.045,
            memory_s: 2.0,
            floor_memory_m: 2.0,
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
    /// The way around things that stand.
    pub detour: DetourPolicy,
    /// Caution about things that move.
    pub moving: MovingPolicy,
}

/// How the way around a standing thing is found when what is wanted leads into it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetourPolicy {
    /// Tightest curve of a detour; 0 makes none: the robot slows down and stops.
    pub curvature_1_m: f64,
    /// A detour leads no farther away from the direction in which the robot was hindered.
    pub heading_rad: f64,
    /// The highest speed on a detour.
    pub speed_m_s: f64,
    /// Hindered for so long before a detour begins.
    pub after_s: f64,
    /// Where no way leads on it backs out so far, where it may drive backwards; 0: never. What comes up behind a
    /// standing robot is not seen.
    pub retreat_m: f64,
}

impl Default for DetourPolicy {
    fn default() -> Self {
        Self {
            curvature_1_m: 2.5,
            heading_rad: 1.5,
            speed_m_s: 0.25,
            after_s: 0.1,
            retreat_m: 0.4,
        }
    }
}

/// How fast things that were seen to move may come nearer.
///
/// The robot drives no faster than lets it stand before such a thing, coming straight at it, arrives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingPolicy {
    /// The speed that is reckoned with; 0 takes no notice of motion.
    pub speed_m_s: f64,
    /// What remains between when the robot stands.
    pub margin_m: f64,
    /// What has moved may move on for so long after it came to rest.
    pub rest_s: f64,
}

impl Default for MovingPolicy {
    fn default() -> Self {
        Self {
            speed_m_s: 1.0,
            margin_m: 0.05,
            rest_s: 4.0,
        }
    }
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
            detour: DetourPolicy::default(),
            moving: MovingPolicy::default(),
        }
    }
}

/// The most rows.
pub const MAX_HORIZONS: usize = 32;

impl TubeParameters {
    /// Checks what can be checked without a robot.
    pub(crate) fn validate(&self) -> Result<(), TubeError> {
        if self.horizons.is_empty() {
            return Err(TubeError::NoHorizon);
        }
        for rows in [&self.horizons, &self.backward] {
            validate_rows(rows)?;
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
            f64::from(MOST_OMEGA_STEPS),
        )?;
        within("d_sample_m", self.d_sample_m, 0.005, 1.0)?;
        within("d_aug_m", self.d_aug_m, 0.0, 1.0)?;
        if self.d_aug_m < self.d_sample_m / 2.0 {
            return Err(TubeError::AugmentedTooLittle {
                d_aug_m: self.d_aug_m,
                d_sample_m: self.d_sample_m,
            });
        }
        within("memory_s", self.memory_s, 0.0, 10.0)?;
        within("floor_memory_m", self.floor_memory_m, 0.0, 100.0)
    }

    /// The horizons ahead, the longest first.
    #[must_use]
    pub fn sorted_horizons(&self) -> Vec<Horizon> {
        longest_first(&self.horizons)
    }

    /// The horizons behind, the longest first.
    #[must_use]
    pub fn sorted_backward(&self) -> Vec<Horizon> {
        longest_first(&self.backward)
    }

    /// The highest speed ahead.
    #[must_use]
    pub fn fastest_m_s(&self) -> f64 {
        let speeds = self.horizons.iter().map(|horizon| horizon.speed_m_s);
        speeds.fold(0.0, f64::max)
    }

    /// From a turning speed to the next.
    #[must_use]
    pub fn omega_step_rad_s(&self) -> f64 {
        2.0 * self.omega_max_rad_s / (self.omega_steps - 1) as f64
    }
}

fn longest_first(rows: &[Horizon]) -> Vec<Horizon> {
    let mut rows = rows.to_vec();
    rows.sort_by(|a, b| b.length_m().total_cmp(&a.length_m()));
    rows
}

fn validate_rows(rows: &[Horizon]) -> Result<(), TubeError> {
    within(
        "the number of horizons",
        rows.len() as f64,
        0.0,
        MAX_HORIZONS as f64,
    )?;
    for row in rows {
        within("horizon duration_s", row.duration_s, 0.05, 60.0)?;
        within("horizon speed_m_s", row.speed_m_s, 0.01, 10.0)?;
    }
    for pair in longest_first(rows).windows(2) {
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
    Ok(())
}

impl AdaptPolicy {
    /// Checks every number.
    pub(crate) fn validate(&self) -> Result<(), TubeError> {
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
        within("good_scans_s", self.good_scans_s, 0.0, 60.0)?;
        let DetourPolicy {
            curvature_1_m,
            heading_rad,
            speed_m_s,
            after_s,
            retreat_m,
        } = self.detour;
        within("detour curvature_1_m", curvature_1_m, 0.0, 20.0)?;
        let most_rad = std::f64::consts::FRAC_PI_2;
        within("detour heading_rad", heading_rad, 0.0, most_rad)?;
        within("detour speed_m_s", speed_m_s, 0.01, 10.0)?;
        within("detour after_s", after_s, 0.0, 60.0)?;
        within("detour retreat_m", retreat_m, 0.0, 2.0)?;
        within("moving speed_m_s", self.moving.speed_m_s, 0.0, 10.0)?;
        within("moving margin_m", self.moving.margin_m, 0.0, 2.0)?;
        within("moving rest_s", self.moving.rest_s, 0.0, 60.0)
    }
}
