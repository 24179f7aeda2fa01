//! Every wall of the map that is in view, matched with a scan.
//!
//! From the believed pose the matcher works out which wall each beam should hit: walls hide each other, end where they
//! end and leave openings. A beam whose end lies near enough to the wall that it, or a beam close by, should hit is
//! given to that wall; how near is near enough follows from the covariance of the pose and the noise of the range. Each
//! wall's points then go to the robust fit of [`line`](super::line): boxes, people and robots standing before a wall are
//! left out there, and a fit that covers too little is no wall.
//!
//! The matcher also judges the scan as a whole: beams that end *before* the wall are obstacles, which there always are,
//! but beams that pass *through* walls say that the pose, or the map, is wrong.
//!
//! Real time: [`WallMatcher::observe`] neither allocates nor locks nor panics. Its time grows with walls times the
//! directions they span, plus beams times [`PAIRS`](super::line); it is bounded for a map and a sensor.

mod view;

use super::line::LineFitter;
use super::{PerceptionGains, RANGE_STD_SHARE, WallFit};
use crate::geometry::{Point2, Pose2, Segment};
use crate::map::SemanticMap;
use crate::scan::{AlignedScan, BeamState};
use nalgebra::{Matrix3, Vector3};
use view::{Expected, View};

/// A beam's end is looked for at least this far, and at most that far, from its wall.
const GATE_MIN_M: f64 = 0.10;
const GATE_MAX_M: f64 = 0.80;
const GATE_SIGMA: f64 = 3.0;
/// Of a wall this much must be seen, or this share of what should be in view when that is less.
const MIN_SPAN_M: f64 = 0.40;
const MIN_SPAN_SHARE: f64 = 0.5;
/// Shorter than this nothing is a wall.
const LEAST_SPAN_M: f64 = 0.15;
/// Of the beams that should hit a wall, this share must.
const MIN_BEAM_SHARE: f64 = 0.15;
/// So much wall in view is enough to expect that the scan shows some of it.
const EXPECTED_M: f64 = 0.6;
/// Walls that one scan can report.
pub const MAX_SEEN_WALLS: usize = 32;

/// A wall that a scan shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenWall {
    /// Index of the wall in the map.
    pub wall: usize,
    /// The wall in `map`, directed as in the fit.
    pub line: Segment,
    /// How the robot stands to it.
    pub fit: WallFit,
}

/// How the beams of a scan agree with the map, as far as they point at walls within range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BeamCounts {
    /// Should hit a wall.
    pub expected: u32,
    /// End at a wall.
    pub agreeing: u32,
    /// End before it: something stands there.
    pub short: u32,
    /// Pass through it: impossible when pose and map are right.
    pub through: u32,
}

impl BeamCounts {
    /// So much passes through walls that pose and map cannot both be right.
    #[must_use]
    pub fn contradict(&self) -> bool {
        self.through >= 20 && 2 * self.through > self.agreeing + self.short
    }
}

/// What one scan showed of the map's walls.
#[derive(Clone, Copy, Debug)]
pub struct WallScan<'a> {
    /// The walls that were recognised, the longest seen first.
    pub seen: &'a [SeenWall],
    /// Enough wall should be in view that blindness would be suspicious.
    pub expected: bool,
    /// How the beams agree with the map.
    pub beams: BeamCounts,
}

/// What beams say about one wall.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    expected: u32,
    given: u32,
    /// Where along the wall the expected beams begin and end.
    from_m: f64,
    to_m: f64,
}

/// A beam's end that was given to a wall.
#[derive(Clone, Copy, Debug)]
struct Given {
    wall: u32,
    gate_m: f64,
    point: Point2,
}

/// Matches scans with the walls of one map; holds the memory that this needs.
#[derive(Clone, Debug)]
pub struct WallMatcher {
    walls: Box<[Segment]>,
    tallies: Box<[Tally]>,
    view: View,
    given: Vec<Given>,
    fitter: LineFitter,
    gains: PerceptionGains,
    seen: Vec<SeenWall>,
}

impl WallMatcher {
    /// A matcher for the map's walls and scans of at most `beams` beams. Allocates, once.
    #[must_use]
    pub fn new(map: &SemanticMap, beams: usize, gains: PerceptionGains) -> Self {
        let walls: Box<[Segment]> = map.walls().iter().map(|wall| wall.line).collect();
        Self {
            tallies: vec![Tally::default(); walls.len()].into_boxed_slice(),
            walls,
            view: View::new(),
            given: Vec::with_capacity(beams),
            fitter: LineFitter::new(beams, gains),
            gains,
            seen: Vec::with_capacity(MAX_SEEN_WALLS),
        }
    }

    /// Looks for the walls in a scan.
    ///
    /// `since` is where the scan has `base_link` (its reference time), seen from `base_link` now; `pose` is `base_link`
    /// in `map` now and `covariance` that of (x, y, θ).
    pub fn observe(
        &mut self,
        scan: &AlignedScan,
        since: Pose2,
        pose: Pose2,
        covariance: &Matrix3<f64>,
    ) -> WallScan<'_> {
        self.seen.clear();
        self.given.clear();
        let mut beams = BeamCounts::default();
        let mut expected = false;
        let sound = since.is_finite()
            && pose.is_finite()
            && covariance.iter().all(|number| number.is_finite());
        if sound && scan.is_valid() {
            let eye = since.compose(scan.geometry().mount);
            self.view
                .look(&self.walls, pose.compose(eye), scan.geometry().range_max_m);
            beams = self.give(scan, since, eye, pose, covariance);
            expected = self.fit_all(eye.position(), pose);
        }
        WallScan {
            seen: &self.seen,
            expected,
            beams,
        }
    }

    /// What the last [`observe`](Self::observe) recognised.
    #[must_use]
    pub fn seen(&self) -> &[SeenWall] {
        &self.seen
    }

    /// Gives each beam's end to the wall that it belongs to.
    fn give(
        &mut self,
        scan: &AlignedScan,
        since: Pose2,
        eye: Pose2,
        pose: Pose2,
        covariance: &Matrix3<f64>,
    ) -> BeamCounts {
        self.tallies.fill(Tally::default());
        let mut counts = BeamCounts::default();
        let range_max_m = scan.geometry().range_max_m;
        let eye_in_map = pose.transform(eye.position());
        let turn_std_rad = covariance[(2, 2)].max(0.0).sqrt();
        let shift_std_m = covariance[(0, 0)].max(covariance[(1, 1)]).max(0.0).sqrt();
        for beam in scan.points() {
            if beam.state == BeamState::Unknown {
                continue;
            }
            let point = since.transform(beam.point);
            let in_map = pose.transform(point);
            let ray = in_map - eye_in_map;
            let range_m = ray.norm_m();
            if !(range_m > 1e-3 && range_m.is_finite()) {
                continue;
            }
            let ray = ray * (1.0 / range_m);
            let spread_rad = GATE_SIGMA * (turn_std_rad + shift_std_m / range_m.max(0.3));
            let expected = self.view.expected(ray, spread_rad);
            if let Some((wall, at_m)) = expected.nearest {
                counts.expected += 1;
                self.tally(wall, eye_in_map + ray * at_m);
            }
            let arm = in_map - pose.position();
            let range_std_m = self.gains.range_std_m.max(RANGE_STD_SHARE * range_m);
            if beam.state == BeamState::Hit
                && let Some((wall, gate_m)) =
                    self.choose(&expected, in_map, arm, ray, range_std_m, covariance)
            {
                counts.agreeing += 1;
                self.tallies[wall].given += 1;
                if self.given.len() < self.given.capacity() {
                    let wall = wall as u32;
                    self.given.push(Given {
                        wall,
                        gate_m,
                        point,
                    });
                }
            } else if expected.nearest.is_some() {
                let slack_m = GATE_MIN_M + GATE_SIGMA * (shift_std_m + range_std_m);
                match expected.farthest_m {
                    Some(farthest_m)
                        if range_m > farthest_m + slack_m + GATE_SIGMA * range_std_m
                            && farthest_m + slack_m < range_max_m =>
                    {
                        counts.through += 1;
                    }
                    _ if beam.state == BeamState::Hit => counts.short += 1,
                    _ => {}
                }
            }
        }
        counts
    }

    fn tally(&mut self, wall: usize, hit: Point2) {
        let along_m = self.walls[wall].along_m(hit);
        let tally = &mut self.tallies[wall];
        if tally.expected == 0 {
            (tally.from_m, tally.to_m) = (along_m, along_m);
        }
        tally.expected += 1;
        tally.from_m = tally.from_m.min(along_m);
        tally.to_m = tally.to_m.max(along_m);
    }

    /// The wall among the candidates to which a point is nearest, in units of its gate.
    fn choose(
        &self,
        expected: &Expected,
        point: Point2,
        arm: Point2,
        ray: Point2,
        range_std_m: f64,
        covariance: &Matrix3<f64>,
    ) -> Option<(usize, f64)> {
        let mut best: Option<(f64, usize, f64)> = None;
        for wall in expected.walls() {
            let line = &self.walls[wall];
            let unit = line.unit();
            let from_start = point - line.a;
            let along_m = unit.dot(from_start);
            if along_m < 0.0 || along_m > line.length_m() {
                continue;
            }
            let normal = Point2::new(-unit.y_m, unit.x_m);
            let model = Vector3::new(normal.x_m, normal.y_m, arm.cross(normal));
            let pose_variance = model.dot(&(covariance * model)).max(0.0);
            let noise_m = range_std_m * normal.dot(ray).abs();
            let std_m = (pose_variance + noise_m * noise_m).sqrt();
            let gate_m = (GATE_MIN_M + GATE_SIGMA * std_m).min(GATE_MAX_M);
            let off = normal.dot(from_start).abs() / gate_m;
            if off <= 1.0 && best.is_none_or(|(least, _, _)| off < least) {
                best = Some((off, wall, gate_m));
            }
        }
        best.map(|(_, wall, gate_m)| (wall, gate_m))
    }

    /// Fits every wall that was given points; says whether enough wall should be in view.
    fn fit_all(&mut self, eye: Point2, pose: Pose2) -> bool {
        let mut expected_m = 0.0;
        for wall in 0..self.walls.len() {
            let tally = self.tallies[wall];
            let visible_m = tally.to_m - tally.from_m;
            expected_m += visible_m;
            let enough = tally.given as usize >= self.gains.min_points
                && f64::from(tally.given) >= MIN_BEAM_SHARE * f64::from(tally.expected);
            if !enough {
                continue;
            }
            let line = self.walls[wall];
            self.fitter.begin(&line.seen_from(pose), eye);
            for given in self
                .given
                .iter()
                .filter(|given| given.wall as usize == wall)
            {
                self.fitter.offer(given.point, given.gate_m);
            }
            let span_m = MIN_SPAN_M.min(MIN_SPAN_SHARE * visible_m).max(LEAST_SPAN_M);
            if let Some(fit) = self.fitter.solve(span_m)
                && self.seen.len() < self.seen.capacity()
            {
                self.seen.push(SeenWall { wall, line, fit });
            }
        }
        self.seen
            .sort_unstable_by(|one, other| other.fit.covered_m.total_cmp(&one.fit.covered_m));
        expected_m >= EXPECTED_M
    }
}

#[cfg(test)]
mod tests;
