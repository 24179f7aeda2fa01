//! One scan, aligned to one instant.

use super::geometry::{ScanGeometry, ScanGeometryError};
use crate::history::OdometryHistory;
use description::geometry::{Point2, Pose2};
use thiserror::Error;

/// Raw values under this are codes.
pub const FIRST_LENGTH_MM: u16 = 20;
/// In the ranges of [`AlignedScan::ranges_m`]: nothing is known of this direction.
pub const UNKNOWN_RANGE_M: f32 = -1.0;

/// Poses are looked up at this many instants of a turn, and interpolated between.
const KNOTS: usize = 16;
/// A source whose scans stay the same, value by value, while the robot drives this far, is frozen.
const FROZEN_DISTANCE_M: f64 = 0.10;
const FROZEN_ANGLE_RAD: f64 = 0.10;
/// So is one that repeats itself this often, wherever the robot is, with so many echoes: the noise of each is larger than the millimetre
/// in which it is told, so already the first repeat is no scan.
const FROZEN_REPEATS: u32 = 5;
const FROZEN_ECHOES: usize = 30;

/// What a beam found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum BeamState {
    /// The device does not know.
    #[default]
    Unknown,
    /// Nothing up to the largest range.
    Free,
    /// Something at the range.
    Hit,
}

/// One beam, moved to the reference time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScanPoint {
    /// In `base_link` at the reference time: what was hit, or the end of a free beam; the origin when unknown.
    pub point: Point2,
    /// As measured, from where the sensor was then; the largest range when free, 0 when unknown.
    pub range_m: f32,
    /// What the beam found.
    pub state: BeamState,
}

/// Why a scan was not taken. The previous one stays as it was.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum AlignError {
    /// Another number of beams than the geometry has.
    #[error("a scan of {found} beams; expected {expected}")]
    BeamCount { expected: usize, found: usize },
    /// Not newer than the scan before.
    #[error("scan stamp {stamp_ns} ns is not after the one before, {previous_ns} ns")]
    NotAfter { stamp_ns: u64, previous_ns: u64 },
    /// The odometry does not reach over the time of the scan.
    #[error("no odometry for the scan of {stamp_ns} ns")]
    NoOdometry { stamp_ns: u64 },
    /// The scan is the one before, to the millimetre: it says nothing of where the robot is now.
    #[error("scan of {stamp_ns} ns repeats the one before")]
    Repeated { stamp_ns: u64 },
    /// The scan stayed the same: the robot moved meanwhile, or it has done so again and again.
    #[error("scan of {stamp_ns} ns repeats those before")]
    Frozen { stamp_ns: u64 },
}

/// A sensor pose inside a turn, ready for interpolation.
#[derive(Clone, Copy, Default)]
struct Knot {
    x_m: f64,
    y_m: f64,
    cos: f64,
    sin: f64,
}

/// A scan aligned to one instant. All memory is taken at construction.
#[derive(Clone, Debug)]
pub struct AlignedScan {
    geometry: ScanGeometry,
    /// Unit vectors of the beams in `laser`.
    directions: Box<[(f64, f64)]>,
    points: Box<[ScanPoint]>,
    ranges_m: Box<[f32]>,
    echoes: usize,
    stamp_ns: u64,
    reference_ns: u64,
    odom_pose: Pose2,
    valid: bool,
    check_frozen: bool,
    fingerprint: u64,
    /// How often it was seen again.
    repeats: u32,
    /// Where the robot was when the fingerprint was first seen.
    fingerprint_pose: Pose2,
}

impl AlignedScan {
    /// An empty scan, all unknown.
    ///
    /// # Errors
    /// Those of [`ScanGeometry::validate`].
    pub fn new(geometry: ScanGeometry) -> Result<Self, ScanGeometryError> {
        geometry.validate()?;
        let directions = (0..geometry.beams)
            .map(|beam| {
                let (sin, cos) = geometry.beam_angle_rad(beam).sin_cos();
                (cos, sin)
            })
            .collect();
        Ok(Self {
            geometry,
            directions,
            points: vec![ScanPoint::default(); geometry.beams].into_boxed_slice(),
            ranges_m: vec![UNKNOWN_RANGE_M; geometry.beams].into_boxed_slice(),
            echoes: 0,
            stamp_ns: 0,
            reference_ns: 0,
            odom_pose: Pose2::IDENTITY,
            valid: false,
            check_frozen: true,
            fingerprint: 0,
            repeats: 0,
            fingerprint_pose: Pose2::IDENTITY,
        })
    }

    /// Accepts identical scans from a moving robot: for sources without any noise, as in tests.
    #[must_use]
    pub fn without_frozen_check(mut self) -> Self {
        self.check_frozen = false;
        self
    }

    /// Takes a scan whose first beam was measured at `stamp_ns`. On an error the scan before stays as it was.
    ///
    /// # Errors
    /// [`AlignError`]: why the scan was not taken.
    pub fn align(
        &mut self,
        raw_mm: &[u16],
        stamp_ns: u64,
        history: &OdometryHistory,
    ) -> Result<(), AlignError> {
        let beams = self.geometry.beams;
        if raw_mm.len() != beams {
            return Err(AlignError::BeamCount {
                expected: beams,
                found: raw_mm.len(),
            });
        }
        if self.valid && stamp_ns <= self.stamp_ns {
            return Err(AlignError::NotAfter {
                stamp_ns,
                previous_ns: self.stamp_ns,
            });
        }
        let duration_ns = self.geometry.duration_ns();
        let reference_ns = stamp_ns.saturating_add(duration_ns);
        let odom_pose = history
            .at(reference_ns)
            .ok_or(AlignError::NoOdometry { stamp_ns })?;
        let mut knots = [Knot::default(); KNOTS + 1];
        for (index, knot) in knots.iter_mut().enumerate() {
            let at_ns = stamp_ns + duration_ns * index as u64 / KNOTS as u64;
            let pose = history
                .at(at_ns)
                .ok_or(AlignError::NoOdometry { stamp_ns })?;
            let sensor = odom_pose.between(pose).compose(self.geometry.mount);
            let (sin, cos) = sensor.theta_rad.sin_cos();
            *knot = Knot {
                x_m: sensor.x_m,
                y_m: sensor.y_m,
                cos,
                sin,
            };
        }
        self.check_for_frozen(raw_mm, stamp_ns, odom_pose)?;

        self.stamp_ns = stamp_ns;
        self.reference_ns = reference_ns;
        self.odom_pose = odom_pose;
        self.valid = true;
        self.place_points(raw_mm, &knots);
        self.rebin();
        Ok(())
    }

    fn check_for_frozen(
        &mut self,
        raw_mm: &[u16],
        stamp_ns: u64,
        odom_pose: Pose2,
    ) -> Result<(), AlignError> {
        let fingerprint = fingerprint(raw_mm);
        if fingerprint != self.fingerprint || !self.valid {
            self.fingerprint = fingerprint;
            self.repeats = 0;
            self.fingerprint_pose = odom_pose;
            return Ok(());
        }
        self.repeats = self.repeats.saturating_add(1);
        let moved = self.fingerprint_pose.between(odom_pose);
        let still = moved.position().norm_m() < FROZEN_DISTANCE_M
            && moved.theta_rad.abs() < FROZEN_ANGLE_RAD;
        let echoes = raw_mm.iter().filter(|&&raw| raw >= FIRST_LENGTH_MM).count();
        let many = echoes >= FROZEN_ECHOES;
        let often = many && self.repeats >= FROZEN_REPEATS;
        // An empty hall looks the same from everywhere.
        let frozen = often || !still && raw_mm.iter().any(|&raw| raw != 0);
        match (frozen, many) {
            _ if !self.check_frozen => Ok(()),
            (true, _) => Err(AlignError::Frozen { stamp_ns }),
            (false, true) => Err(AlignError::Repeated { stamp_ns }),
            (false, false) => Ok(()),
        }
    }

    fn place_points(&mut self, raw_mm: &[u16], knots: &[Knot; KNOTS + 1]) {
        let range_max_m = self.geometry.range_max_m as f32;
        // The sensor measures in whole millimetres.
        let nearest_mm = (self.geometry.range_min_m * 1e3).round() as u16;
        let nearest_mm = nearest_mm.max(FIRST_LENGTH_MM);
        let knots_per_beam = KNOTS as f64 / (self.geometry.beams - 1) as f64;
        self.echoes = raw_mm.iter().filter(|&&raw| raw >= nearest_mm).count();
        let beams = self.points.iter_mut().zip(&*self.directions).zip(raw_mm);
        for (beam, ((place, &(cos, sin)), &raw)) in beams.enumerate() {
            let (state, range_m) = match raw {
                0 => (BeamState::Free, range_max_m),
                near if near < nearest_mm => {
                    *place = ScanPoint::default();
                    continue;
                }
                length_mm => {
                    let range_m = f32::from(length_mm) * 1e-3;
                    if range_m >= range_max_m {
                        (BeamState::Free, range_max_m)
                    } else {
                        (BeamState::Hit, range_m)
                    }
                }
            };
            let position = beam as f64 * knots_per_beam;
            let index = (position as usize).min(KNOTS - 1);
            let fraction = position - index as f64;
            let (from, to) = (knots[index], knots[index + 1]);
            let lerp = |a: f64, b: f64| a + fraction * (b - a);
            let (turn_cos, turn_sin) = (lerp(from.cos, to.cos), lerp(from.sin, to.sin));
            let range = f64::from(range_m);
            *place = ScanPoint {
                point: Point2::new(
                    lerp(from.x_m, to.x_m) + range * (turn_cos * cos - turn_sin * sin),
                    lerp(from.y_m, to.y_m) + range * (turn_sin * cos + turn_cos * sin),
                ),
                range_m,
                state,
            };
        }
    }

    /// Puts the aligned points on the grid of beams of the sensor where it stood at the reference time. Where the
    /// motion pulls two neighbours apart, the beams between take the shorter of both; where it pushes points onto
    /// one beam, the shortest counts. A robot that stands still gets its ranges back unchanged.
    fn rebin(&mut self) {
        let geometry = self.geometry;
        let beams = geometry.beams as i64;
        self.ranges_m.fill(UNKNOWN_RANGE_M);
        let take = |ranges_m: &mut [f32], beam: i64, range_m: f32| {
            if let Some(place) = usize::try_from(beam).ok().and_then(|b| ranges_m.get_mut(b))
                && (*place < 0.0 || range_m < *place)
            {
                *place = range_m;
            }
        };
        let (mount_sin, mount_cos) = geometry.mount.theta_rad.sin_cos();
        let grid = geometry.beam_grid();
        let mut previous: Option<(i64, f32)> = None;
        for scan_point in &*self.points {
            if scan_point.state == BeamState::Unknown {
                previous = None;
                continue;
            }
            let delta = scan_point.point - geometry.mount.position();
            let in_laser = Point2::new(
                mount_cos * delta.x_m + mount_sin * delta.y_m,
                mount_cos * delta.y_m - mount_sin * delta.x_m,
            );
            let range_m = (in_laser.norm_m() as f32).min(geometry.range_max_m as f32);
            let beam = grid.beam_number(in_laser);
            take(&mut self.ranges_m, beam, range_m);
            if let Some((before, before_m)) = previous {
                let (low, high) = (before.min(beam), before.max(beam));
                // A leap over half the view is the seam behind a sensor that looks all around.
                if high - low <= beams / 2 {
                    for between in low + 1..high {
                        take(&mut self.ranges_m, between, range_m.min(before_m));
                    }
                }
            }
            previous = Some((beam, range_m));
        }
    }

    /// The geometry that it was built for.
    #[must_use]
    pub fn geometry(&self) -> &ScanGeometry {
        &self.geometry
    }

    /// A scan was taken.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.valid
    }

    /// The beams in their order, placed in `base_link` at the reference time.
    #[must_use]
    pub fn points(&self) -> &[ScanPoint] {
        &self.points
    }

    /// The points that were hit, in `base_link` at the reference time.
    pub fn hits(&self) -> impl Iterator<Item = Point2> + '_ {
        self.points
            .iter()
            .filter(|beam| beam.state == BeamState::Hit)
            .map(|beam| beam.point)
    }

    /// Beams that measured a length, beyond the largest range too; the others had no echo, or one that is not trusted.
    #[must_use]
    pub fn echoes(&self) -> usize {
        self.echoes
    }

    /// Free range per beam of the geometry, from the sensor's place at the reference time; [`UNKNOWN_RANGE_M`]
    /// where nothing is known.
    #[must_use]
    pub fn ranges_m(&self) -> &[f32] {
        &self.ranges_m
    }

    /// When the first beam was measured.
    #[must_use]
    pub fn stamp_ns(&self) -> u64 {
        self.stamp_ns
    }

    /// The instant that everything is aligned to: that of the last beam.
    #[must_use]
    pub fn reference_ns(&self) -> u64 {
        self.reference_ns
    }

    /// `base_link` in `odom` at the reference time.
    #[must_use]
    pub fn odom_pose(&self) -> Pose2 {
        self.odom_pose
    }
}

/// FNV-1a over the values; never the 0 of a fresh scan for practical purposes.
fn fingerprint(raw_mm: &[u16]) -> u64 {
    raw_mm.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &raw| {
        (hash ^ u64::from(raw)).wrapping_mul(0x0100_0000_01b3)
    })
}
