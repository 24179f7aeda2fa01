//! Where the beams of a sensor point.

use crate::direction::{DIRECTION_DOUBT_RAD, direction_rad, floor};
use description::geometry::{Point2, Pose2, wrap_angle};
use std::f64::consts::{PI, TAU};
use thiserror::Error;

/// The largest number of beams that a scan may have.
pub const MAX_BEAMS: usize = 8192;

/// Nearer points have no direction in single precision that is worth asking for.
const LEAST_M: f64 = 1e-6;

/// Where the beams of a sensor point, where it is mounted and how fast it turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanGeometry {
    /// `laser` in `base_link`; x of `laser` along the angle 0.
    pub mount: Pose2,
    /// Direction of the first beam in `laser`.
    pub angle_first_rad: f64,
    /// From a beam to the next, counter-clockwise.
    pub angle_step_rad: f64,
    /// Beams in one scan.
    pub beams: usize,
    /// Shorter lengths are not trusted as lengths.
    pub range_min_m: f64,
    /// Longer lengths are not trusted; a longer one says: free to here.
    pub range_max_m: f64,
    /// Time of one whole turn of the sensor; 0 when all beams are measured at once.
    pub turn_s: f64,
}

/// What is wrong with a scan geometry.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum ScanGeometryError {
    /// A number is NaN or infinite.
    #[error("a number of the scan geometry is not finite")]
    NotFinite,
    /// Too few or too many beams.
    #[error("a scan of {found} beams; expected 2 to {MAX_BEAMS}")]
    Beams { found: usize },
    /// The beams do not fit into one turn, or do not advance.
    #[error("{beams} beams at {angle_step_rad} rad; expected steps over 0 and at most one turn")]
    Angles { beams: usize, angle_step_rad: f64 },
    /// The range is empty.
    #[error("ranges from {range_min_m} m to {range_max_m} m; expected 0 <= min < max <= 65 m")]
    Ranges { range_min_m: f64, range_max_m: f64 },
    /// The turn takes a negative or an absurd time.
    #[error("a turn of {turn_s} s; expected 0 to 1 s")]
    Turn { turn_s: f64 },
}

impl ScanGeometry {
    /// The geometry of a SCIP device, which counts `steps_per_turn` steps in a turn and looks ahead at `front_step`,
    /// that reports steps `first_step` to `last_step` in clusters of `cluster`.
    #[must_use]
    pub fn from_steps(
        mount: Pose2,
        steps_per_turn: u32,
        front_step: u32,
        (first_step, last_step): (u32, u32),
        cluster: u32,
        (range_min_m, range_max_m): (f64, f64),
        turn_s: f64,
    ) -> Self {
        let cluster = cluster.max(1);
        let step_rad = TAU / f64::from(steps_per_turn.max(1));
        let steps = (last_step + 1).saturating_sub(first_step);
        // A cluster looks along the middle of its steps.
        let first = f64::from(first_step) + f64::from(cluster - 1) / 2.0;
        Self {
            mount,
            angle_first_rad: (first - f64::from(front_step)) * step_rad,
            angle_step_rad: step_rad * f64::from(cluster),
            beams: steps.div_ceil(cluster) as usize,
            range_min_m,
            range_max_m,
            turn_s,
        }
    }

    /// The geometry of a Hokuyo URG-04LX that reports all its steps: 682 beams, about 240°, ten turns a second.
    #[must_use]
    pub fn urg_04lx(mount: Pose2, range_max_m: f64) -> Self {
        Self::from_steps(mount, 1024, 384, (44, 725), 1, (0.02, range_max_m), 0.1)
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`ScanGeometryError`] with the first number out of range.
    pub fn validate(&self) -> Result<(), ScanGeometryError> {
        let numbers = [
            self.angle_first_rad,
            self.angle_step_rad,
            self.range_min_m,
            self.range_max_m,
            self.turn_s,
        ];
        if !self.mount.is_finite() || numbers.iter().any(|number| !number.is_finite()) {
            return Err(ScanGeometryError::NotFinite);
        }
        if !(2..=MAX_BEAMS).contains(&self.beams) {
            return Err(ScanGeometryError::Beams { found: self.beams });
        }
        let view_rad = self.angle_step_rad * (self.beams - 1) as f64;
        if self.angle_step_rad <= 0.0 || view_rad > TAU {
            return Err(ScanGeometryError::Angles {
                beams: self.beams,
                angle_step_rad: self.angle_step_rad,
            });
        }
        if self.range_min_m < 0.0 || self.range_max_m <= self.range_min_m || self.range_max_m > 65.0
        {
            return Err(ScanGeometryError::Ranges {
                range_min_m: self.range_min_m,
                range_max_m: self.range_max_m,
            });
        }
        if !(0.0..=1.0).contains(&self.turn_s) {
            return Err(ScanGeometryError::Turn {
                turn_s: self.turn_s,
            });
        }
        Ok(())
    }

    /// Direction of a beam in `laser`.
    #[must_use]
    pub fn beam_angle_rad(&self, beam: usize) -> f64 {
        self.angle_first_rad + self.angle_step_rad * beam as f64
    }

    /// Where a direction in `laser` lies on the grid of beams; below 0 or above the last beam when out of view.
    #[must_use]
    pub fn beam_position(&self, angle_rad: f64) -> f64 {
        let half = (self.beams - 1) as f64 / 2.0;
        let middle_rad = self.angle_first_rad + self.angle_step_rad * half;
        wrap_angle(angle_rad - middle_rad) / self.angle_step_rad + half
    }

    /// The beam nearest to a direction in `laser`, if one looks there.
    #[must_use]
    pub fn nearest_beam(&self, angle_rad: f64) -> Option<usize> {
        let position = self.beam_position(angle_rad).round();
        (position >= 0.0 && position < self.beams as f64).then_some(position as usize)
    }

    /// The beam nearest to the direction of a point of `laser`, if one looks there.
    #[must_use]
    pub fn beam_at(&self, point: Point2) -> Option<usize> {
        self.beam_grid().beam_at(point)
    }

    /// For those who ask for the beams of many points.
    #[must_use]
    pub(crate) fn beam_grid(&self) -> BeamGrid<'_> {
        let half = (self.beams - 1) as f64 / 2.0;
        BeamGrid {
            geometry: self,
            middle_rad: self.angle_first_rad + self.angle_step_rad * half,
            middle_place: half + 0.5,
            per_rad: 1.0 / self.angle_step_rad,
        }
    }

    /// From the first beam of a scan to the last.
    #[must_use]
    pub fn duration_ns(&self) -> u64 {
        let turns = self.angle_step_rad * (self.beams - 1) as f64 / TAU;
        (self.turn_s * turns * 1e9) as u64
    }
}

/// The beams of a geometry with what every point is asked with, so that a loop over points divides nothing by it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BeamGrid<'a> {
    geometry: &'a ScanGeometry,
    middle_rad: f64,
    /// Of the middle of the view, counted from the beginning of the first beam.
    middle_place: f64,
    /// Beams in a radian.
    per_rad: f64,
}

impl BeamGrid<'_> {
    /// The number of the beam nearest to the direction of a point of `laser`, also where none looks.
    #[must_use]
    #[inline]
    pub(crate) fn beam_number(&self, point: Point2) -> i64 {
        self.clear_beam_number(point).unwrap_or_else(|| {
            let position = self.geometry.beam_position(point.direction_rad());
            position.round() as i64
        })
    }

    /// The beam nearest to the direction of a point of `laser`, if one looks there.
    #[must_use]
    #[inline]
    pub(crate) fn beam_at(&self, point: Point2) -> Option<usize> {
        match self.clear_beam_number(point) {
            Some(number) => usize::try_from(number)
                .ok()
                .filter(|beam| *beam < self.geometry.beams),
            None => self.geometry.nearest_beam(point.direction_rad()),
        }
    }

    /// The same without an arc tangent; `None` where a direction that is only nearly right does not decide it: between
    /// two beams, opposite to the middle of the view, or at the sensor itself.
    #[inline]
    fn clear_beam_number(&self, point: Point2) -> Option<i64> {
        let near_rad = f64::from(direction_rad(point.y_m as f32, point.x_m as f32));
        let from_middle_rad = wrap_angle(near_rad - self.middle_rad);
        let place = from_middle_rad * self.per_rad + self.middle_place;
        let beam = floor(place);
        let beside = place - beam as f64;
        let doubt = DIRECTION_DOUBT_RAD * self.per_rad;
        let clear = beside > doubt
            && beside < 1.0 - doubt
            && from_middle_rad.abs() < PI - DIRECTION_DOUBT_RAD
            && point.x_m.abs().max(point.y_m.abs()) > LEAST_M;
        clear.then_some(beam)
    }
}
