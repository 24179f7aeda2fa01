//! The matcher: beams are given to walls, and each wall's points to the fit.

use super::beyond::{Beam, seen_beyond};
use super::view::{Expected, View};
use crate::map::SemanticMap;
use crate::perception::RANGE_STD_SHARE;
use crate::perception::line::LineFitter;
use crate::perception::wall_fit::WallFit;
use crate::scan::{AlignedScan, BeamState};
use description::geometry::{Point2, Pose2, Segment};
use description::robot::Navigation;
use nalgebra::{Matrix3, Vector3};

/// Least and largest distance of a beam's end from its wall; between them this many standard deviations.
const GATE_MIN_M: f64 = 0.10;
const GATE_MAX_M: f64 = 0.80;
const GATE_SIGMA: f64 = 3.0;
/// Length of a wall that must be seen; of a short wall this share.
const MIN_SPAN_M: f64 = 0.50;
const MIN_SPAN_SHARE: f64 = 0.5;
/// Nothing shorter counts as a wall.
const LEAST_SPAN_M: f64 = 0.15;
/// The less certain the pose, the more of a wall must be seen, up to this: robots have straight sides too.
const SPAN_SIGMA: f64 = 10.0;
const SPAN_MAX_M: f64 = 1.2;
/// Least share of the expected beams that must hit a wall.
const MIN_BEAM_SHARE: f64 = 0.15;
/// This close to the ends of a wall a beam may pass beside it as well as through it.
const END_SLACK_M: f64 = 0.10;
/// A wall is missing when beams pass through this length of it, and this share of what should be in view.
const MISSING_M: f64 = 0.6;
const MISSING_SHARE: f64 = 0.5;
/// With this length of wall in view the scan is expected to show some of it.
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

/// How the beams of a scan agree with the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BeamCounts {
    /// Should hit a wall within range.
    pub expected: u32,
    /// End at a wall.
    pub agreeing: u32,
    /// Walls that should be in view, but that most beams pass through: impossible when pose and map are right.
    pub walls_through: u32,
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

/// Which way a wall runs, and how far.
#[derive(Clone, Copy, Debug)]
struct Direction {
    unit: Point2,
    length_m: f64,
}

impl Direction {
    fn of(wall: &Segment) -> Self {
        Self {
            unit: wall.unit(),
            length_m: wall.length_m(),
        }
    }
}

/// Matches scans with the walls of one map; holds the memory that this needs.
#[derive(Clone, Debug)]
pub struct WallMatcher {
    pub(super) walls: Box<[Segment]>,
    directions: Box<[Direction]>,
    tallies: Box<[Tally]>,
    pub(super) view: View,
    beams: Vec<Beam>,
    fitter: LineFitter,
    gains: Navigation,
    seen: Vec<SeenWall>,
}

impl WallMatcher {
    /// A matcher for the map's walls and scans of at most `beams` beams. Allocates, once.
    #[must_use]
    pub fn new(map: &SemanticMap, beams: usize, gains: Navigation) -> Self {
        let walls: Box<[Segment]> = map.walls().iter().map(|wall| wall.line).collect();
        Self {
            tallies: vec![Tally::default(); walls.len()].into_boxed_slice(),
            directions: walls.iter().map(Direction::of).collect(),
            walls,
            view: View::new(),
            beams: Vec::with_capacity(beams),
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
        self.beams.clear();
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
            let eye = eye.position();
            expected = self.fit_all(scan, eye, pose, covariance, &mut beams);
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
        let eye_in_map = pose.transform(eye.position());
        let turn_std_rad = covariance[(2, 2)].max(0.0).sqrt();
        let shift_std_m = covariance[(0, 0)].max(covariance[(1, 1)]).max(0.0).sqrt();
        let (to_now, to_map) = (since.transformation(), pose.transformation());
        for (index, beam) in scan.points().iter().enumerate() {
            if self.beams.len() == self.beams.capacity() {
                break;
            }
            if beam.state == BeamState::Unknown {
                // The wall expected there counts as expected, although the beam says nothing.
                let angle_rad = scan.geometry().beam_angle_rad(index);
                let (sin, cos) = (pose.theta_rad + eye.theta_rad + angle_rad).sin_cos();
                let ray = Point2::new(cos, sin);
                if let Some((wall, at_m)) = self.view.expected(ray, 0.0).nearest {
                    counts.expected += 1;
                    self.tally(wall, eye_in_map + ray * at_m);
                }
                continue;
            }
            let end = to_now(beam.point);
            let in_map = to_map(end);
            let ray = in_map - eye_in_map;
            let range_m = ray.norm_m();
            if !(range_m > 1e-3 && range_m.is_finite()) {
                continue;
            }
            let per_range_1_m = 1.0 / range_m;
            let ray = ray * per_range_1_m;
            let spread_rad =
                GATE_SIGMA * (turn_std_rad + shift_std_m * per_range_1_m.min(1.0 / 0.3));
            let expected = self.view.expected(ray, spread_rad);
            if let Some((wall, at_m)) = expected.nearest {
                counts.expected += 1;
                self.tally(wall, eye_in_map + ray * at_m);
            }
            let arm = in_map - pose.position();
            let range_std_m = self.gains.range_std_m.max(RANGE_STD_SHARE * range_m);
            let chosen = (beam.state == BeamState::Hit)
                .then(|| self.choose(&expected, in_map, arm, ray, range_std_m, covariance))
                .flatten();
            if let Some((wall, _)) = chosen {
                counts.agreeing += 1;
                self.tallies[wall].given += 1;
            }
            self.beams.push(Beam {
                end,
                range_std_m,
                range_std_share: range_std_m * per_range_1_m,
                wall: chosen.map(|(wall, _)| wall as u32),
                gate_m: chosen.map_or(0.0, |(_, gate_m)| gate_m),
            });
        }
        counts
    }

    fn tally(&mut self, wall: usize, hit: Point2) {
        let along_m = self.directions[wall].unit.dot(hit - self.walls[wall].a);
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
        // The wall, how far off it is, and its gate.
        let mut best: Option<(usize, f64, f64)> = None;
        for wall in expected.walls() {
            let Direction { unit, length_m } = self.directions[wall];
            let from_start = point - self.walls[wall].a;
            let along_m = unit.dot(from_start);
            if along_m < 0.0 || along_m > length_m {
                continue;
            }
            let normal = Point2::new(-unit.y_m, unit.x_m);
            let (x, y, turn) = (normal.x_m, normal.y_m, arm.cross(normal));
            let of_covariance = |row: usize| {
                covariance[(row, 0)] * x + covariance[(row, 1)] * y + covariance[(row, 2)] * turn
            };
            let pose_variance =
                (x * of_covariance(0) + y * of_covariance(1) + turn * of_covariance(2)).max(0.0);
            let noise_m = range_std_m * normal.dot(ray).abs();
            let std_m = (pose_variance + noise_m * noise_m).sqrt();
            let gate_m = (GATE_MIN_M + GATE_SIGMA * std_m).min(GATE_MAX_M);
            let off_m = normal.dot(from_start).abs();
            // Shares of gates are compared, without a division.
            let is_nearer = |(_, least_m, its_gate_m)| off_m * its_gate_m < least_m * gate_m;
            if off_m <= gate_m && best.is_none_or(is_nearer) {
                best = Some((wall, off_m, gate_m));
            }
        }
        best.map(|(wall, _, gate_m)| (wall, gate_m))
    }

    /// Fits every wall that was given points; says whether enough wall should be in view.
    fn fit_all(
        &mut self,
        scan: &AlignedScan,
        eye: Point2,
        pose: Pose2,
        covariance: &Matrix3<f64>,
        counts: &mut BeamCounts,
    ) -> bool {
        let sight_m = scan.geometry().range_max_m;
        let mut expected_m = 0.0;
        for wall in 0..self.walls.len() {
            let tally = self.tallies[wall];
            if tally.expected == 0 && tally.given == 0 {
                continue;
            }
            let visible_m = tally.to_m - tally.from_m;
            expected_m += visible_m;
            let line = self.walls[wall];
            let in_base = line.seen_from(pose);
            let ends_m = END_SLACK_M + GATE_SIGMA * std_along_m(covariance, line.unit());
            let enough = tally.given as usize >= (self.gains.wall_min_points as usize)
                && f64::from(tally.given) >= MIN_BEAM_SHARE * f64::from(tally.expected);
            let unit = line.unit();
            let across_std_m = std_along_m(covariance, Point2::new(-unit.y_m, unit.x_m));
            let fit = if enough {
                let known_m = (SPAN_SIGMA * across_std_m).min(SPAN_MAX_M);
                let short_m = (MIN_SPAN_SHARE * line.length_m()).max(LEAST_SPAN_M);
                let span_m = MIN_SPAN_M.min(short_m);
                self.fit(wall, &in_base, eye, sight_m, span_m.max(known_m))
            } else {
                None
            };
            if let Some(fit) = fit {
                let found = found_line(&in_base, &fit);
                let beyond = seen_beyond(&self.beams, &found, eye, ends_m, 0.0);
                if !beyond.refutes(fit.covered_m) && self.seen.len() < self.seen.capacity() {
                    self.seen.push(SeenWall { wall, line, fit });
                    continue;
                }
            }
            // Nothing there that could be the wall. Is it hidden, or is it not there?
            let unit = line.unit();
            let across_m = GATE_SIGMA * std_along_m(covariance, Point2::new(-unit.y_m, unit.x_m));
            let beyond = seen_beyond(&self.beams, &in_base, eye, ends_m, across_m);
            if beyond.all_m >= MISSING_M.max(MISSING_SHARE * visible_m) {
                counts.walls_through += 1;
            }
        }
        self.seen
            .sort_unstable_by(|one, other| other.fit.covered_m.total_cmp(&one.fit.covered_m));
        expected_m >= EXPECTED_M
    }

    fn fit(
        &mut self,
        wall: usize,
        in_base: &Segment,
        eye: Point2,
        sight_m: f64,
        span_m: f64,
    ) -> Option<WallFit> {
        self.fitter.begin(in_base, eye, sight_m);
        for beam in &self.beams {
            if beam.wall == Some(wall as u32) {
                self.fitter.offer(beam.end, beam.gate_m);
            }
        }
        self.fitter.solve(span_m)
    }
}

/// Standard deviation of the position along a direction of `map`.
fn std_along_m(covariance: &Matrix3<f64>, unit: Point2) -> f64 {
    let model = Vector3::new(unit.x_m, unit.y_m, 0.0);
    model.dot(&(covariance * model)).max(0.0).sqrt()
}

/// The expected wall (in `base_link`) where the fit has it.
fn found_line(expected: &Segment, fit: &WallFit) -> Segment {
    let (sin, cos) = (-fit.heading_rad).sin_cos();
    let unit = Point2::new(cos, sin);
    let normal = Point2::new(-sin, cos);
    // `base_link` lies `lateral_m` to the left of the line.
    let place = |point: Point2| unit * unit.dot(point) - normal * fit.lateral_m;
    Segment::new(place(expected.a), place(expected.b))
}
