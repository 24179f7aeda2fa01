//! Robust straight-line fit to the scan points near a wall that is expected somewhere.
//!
//! The expected wall is a segment in `base_link`. Points inside its gate are taken into the segment's own coordinates
//! (along, across), so that the line is a small correction of the expectation. The fit starts from the pair of points
//! that accounts for most of the wall's length (not for most points: what stands near is dense), and is refined by least squares with Tukey's weights: what stands in front of the wall
//! does not pull it. Deterministic; no allocation after construction.

use super::{PerceptionGains, WallFit};
use crate::geometry::{Point2, Segment, wrap_angle};
use nalgebra::Matrix2;

/// Pairs of points that are tried.
const PAIRS: usize = 48;
/// Passes of the refinement.
const PASSES: usize = 4;
/// Coverage is counted in pieces of this length.
const PIECE_M: f64 = 0.1;
const PIECES: usize = 128;
/// Of the length where the gate holds points, this share must lie on the line.
const MIN_SHARE: f64 = 0.35;
/// The expected direction cannot be off by more than this slope.
const MAX_SLOPE: f64 = 0.6;
/// Left out at both ends of the expected segment, where the next wall begins.
const END_MARGIN_M: f64 = 0.10;
/// What no number of points averages away: mounting, calibration, a wall that is not straight.
const FLOOR_ACROSS_M: f64 = 0.004;
const FLOOR_ANGLE_RAD: f64 = 0.002;

/// A point in the coordinates of the expected wall.
#[derive(Clone, Copy, Debug, Default)]
struct WallPoint {
    along_m: f64,
    across_m: f64,
    /// One over the points on the same piece: what stands near is dense, and counts no more for that.
    share: f64,
}

/// across = offset + slope · (along − centre)
#[derive(Clone, Copy, Debug, Default)]
struct Line {
    centre_m: f64,
    offset_m: f64,
    slope: f64,
}

impl Line {
    fn residual_m(&self, point: &WallPoint) -> f64 {
        point.across_m - self.offset_m - self.slope * (point.along_m - self.centre_m)
    }
}

/// Fits lines; holds the memory that a fit needs.
#[derive(Clone, Debug)]
pub struct LineFitter {
    near: Vec<WallPoint>,
    gains: PerceptionGains,
}

impl LineFitter {
    /// A fitter that looks at no more than `capacity` points of a scan.
    #[must_use]
    pub fn new(capacity: usize, gains: PerceptionGains) -> Self {
        Self {
            near: Vec::with_capacity(capacity),
            gains,
        }
    }

    /// The wall near `expected` (in `base_link`), when enough `points` within `gate_m` agree on one and cover at
    /// least `min_span_m` of it.
    pub fn fit(
        &mut self,
        points: &[Point2],
        expected: &Segment,
        gate_m: f64,
        min_span_m: f64,
    ) -> Option<WallFit> {
        self.collect(points, expected, gate_m);
        if self.near.len() < self.gains.min_points {
            return None;
        }
        let line = self.refine(self.start(min_span_m)?)?;
        self.describe(expected, &line, min_span_m)
    }

    fn collect(&mut self, points: &[Point2], expected: &Segment, gate_m: f64) {
        self.near.clear();
        let (unit, length_m) = (expected.unit(), expected.length_m());
        for &point in points {
            let from_start = point - expected.a;
            let across_m = unit.cross(from_start);
            if across_m.abs() > gate_m {
                continue;
            }
            let along_m = unit.dot(from_start);
            if along_m < END_MARGIN_M || along_m > length_m - END_MARGIN_M {
                continue;
            }
            if self.near.len() == self.near.capacity() {
                break;
            }
            self.near.push(WallPoint {
                along_m,
                across_m,
                share: 0.0,
            });
        }
        let mut counts = [0u32; PIECES];
        for point in &self.near {
            counts[piece(point)] += 1;
        }
        for point in &mut self.near {
            point.share = 1.0 / f64::from(counts[piece(point)]);
        }
    }

    /// The line through two points that accounts for the most length.
    fn start(&self, min_span_m: f64) -> Option<Line> {
        let count = self.near.len();
        let mut best: Option<(f64, Line)> = None;
        for pair in 0..PAIRS {
            // Spread evenly: first points over the whole view, partners at changing distances.
            let first = pair * count / PAIRS;
            let distance = count / 4 + (pair % 5) * count / 10;
            let (a, b) = (&self.near[first], &self.near[(first + distance) % count]);
            let along_m = b.along_m - a.along_m;
            if along_m.abs() < min_span_m / 2.0 {
                continue;
            }
            let slope = (b.across_m - a.across_m) / along_m;
            if slope.abs() > MAX_SLOPE {
                continue;
            }
            let line = Line {
                centre_m: a.along_m,
                offset_m: a.across_m,
                slope,
            };
            let support = self.support(&line);
            if best.is_none_or(|(most, _)| support > most) {
                best = Some((support, line));
            }
        }
        best.map(|(_, line)| line)
    }

    /// Pieces of wall that lie on the line; the closer, the more they count.
    fn support(&self, line: &Line) -> f64 {
        let reach_m2 = self.gains.inlier_m.powi(2);
        let closeness = |point: &WallPoint| {
            let off = line.residual_m(point).powi(2) / reach_m2;
            point.share * (1.0 - off).max(0.0)
        };
        self.near.iter().map(closeness).sum()
    }

    fn refine(&self, start: Line) -> Option<Line> {
        let mut line = start;
        let reach_m = 1.5 * self.gains.inlier_m;
        for _ in 0..PASSES {
            let (mut sum, mut along, mut across) = (0.0, 0.0, 0.0);
            let (mut square, mut product) = (0.0, 0.0);
            for point in &self.near {
                let weight = tukey(line.residual_m(point) / reach_m);
                if weight > 0.0 {
                    let from_centre_m = point.along_m - line.centre_m;
                    sum += weight;
                    along += weight * from_centre_m;
                    across += weight * point.across_m;
                    square += weight * from_centre_m * from_centre_m;
                    product += weight * from_centre_m * point.across_m;
                }
            }
            if sum < 2.0 {
                return None;
            }
            let (mean, mean_across) = (along / sum, across / sum);
            let spread = square - along * mean;
            if spread < 1e-6 {
                return None;
            }
            line = Line {
                centre_m: line.centre_m + mean,
                offset_m: mean_across,
                slope: (product - along * mean_across) / spread,
            };
        }
        (line.slope.abs() <= MAX_SLOPE).then_some(line)
    }

    /// Judges the line and states it as seen from `base_link`.
    fn describe(&self, expected: &Segment, line: &Line, min_span_m: f64) -> Option<WallFit> {
        let (mut inliers, mut squares, mut spread) = (0usize, 0.0, 0.0);
        let (mut covered, mut all) = (0u128, 0u128);
        for point in &self.near {
            all |= 1 << piece(point);
            let residual_m = line.residual_m(point);
            if residual_m.abs() < self.gains.inlier_m {
                inliers += 1;
                covered |= 1 << piece(point);
                squares += residual_m * residual_m;
                spread += (point.along_m - line.centre_m).powi(2);
            }
        }
        let share = f64::from(covered.count_ones()) / f64::from(all.count_ones().max(1));
        let covered_m = PIECE_M * f64::from(covered.count_ones());
        if inliers < self.gains.min_points || share < MIN_SHARE || covered_m < min_span_m {
            return None;
        }
        let rms_m = (squares / inliers as f64).sqrt();
        let noise = rms_m.max(self.gains.range_std_m).powi(2);
        let across_variance = noise / inliers as f64 + FLOOR_ACROSS_M.powi(2);
        let angle_variance = noise / spread + FLOOR_ANGLE_RAD.powi(2);

        let turned_rad = line.slope.atan();
        let direction_rad = expected.direction_rad() + turned_rad;
        let (sin, cos) = direction_rad.sin_cos();
        let unit = Point2::new(cos, sin);
        let along = expected.unit();
        let normal = Point2::new(-along.y_m, along.x_m);
        let centre = expected.a + along * line.centre_m + normal * line.offset_m;
        // Lever from the points' centre to `base_link`: a wall seen far ahead tells its offset here less well.
        let lever_m = -unit.dot(centre);
        Some(WallFit {
            lateral_m: -unit.cross(centre),
            heading_rad: wrap_angle(-direction_rad),
            covariance: Matrix2::new(
                across_variance + lever_m * lever_m * angle_variance,
                lever_m * angle_variance,
                lever_m * angle_variance,
                angle_variance,
            ),
            inliers: inliers as u32,
            share,
            covered_m,
            rms_m,
        })
    }
}

/// The piece of wall that a point lies on; a very long wall counts round.
fn piece(point: &WallPoint) -> usize {
    let index = (point.along_m / PIECE_M).floor() as i64;
    index.rem_euclid(PIECES as i64) as usize
}

/// Tukey's weight of a residual in units of the reach.
fn tukey(ratio: f64) -> f64 {
    let square = ratio * ratio;
    if square < 1.0 {
        (1.0 - square) * (1.0 - square)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose2;

    fn wall_points(wall: &Segment, pose: Pose2, noise_m: f64) -> Vec<Point2> {
        (0..120)
            .map(|i| {
                let along = wall.a + (wall.b - wall.a) * (f64::from(i) / 119.0);
                let wobble = noise_m * (f64::from(i) * 2.4).sin();
                let inner = pose.inverse_transform(along);
                inner + inner * (wobble / inner.norm_m())
            })
            .collect()
    }

    fn fitter() -> LineFitter {
        LineFitter::new(700, PerceptionGains::default())
    }

    #[test]
    fn finds_offset_and_heading_of_a_wall_that_is_elsewhere_than_expected() {
        let wall = Segment::new(Point2::new(0.0, 1.6), Point2::new(4.0, 1.6));
        let truth = Pose2::new(1.0, -0.43, 0.07);
        let expected = wall.seen_from(Pose2::new(1.05, -0.5, 0.0));
        let points = wall_points(&wall, truth, 0.01);
        let fit = fitter().fit(&points, &expected, 0.4, 0.4).unwrap();
        assert!(
            (fit.lateral_m - wall.lateral_m(truth.position())).abs() < 0.01,
            "{fit:?}"
        );
        assert!((fit.heading_rad - 0.07).abs() < 0.01, "{fit:?}");
        assert!(fit.lateral_std_m() < 0.02 && fit.heading_std_rad() < 0.01);
    }

    #[test]
    fn what_stands_before_the_wall_does_not_pull_it() {
        let wall = Segment::new(Point2::new(0.0, 1.6), Point2::new(4.0, 1.6));
        let truth = Pose2::new(1.0, -0.5, 0.0);
        let mut points = wall_points(&wall, truth, 0.01);
        for (i, point) in points.iter_mut().enumerate() {
            if (30..75).contains(&i) {
                point.y_m -= 0.15;
            }
        }
        let expected = wall.seen_from(truth);
        let fit = fitter().fit(&points, &expected, 0.4, 0.4).unwrap();
        assert!((fit.lateral_m + 2.1).abs() < 0.01, "{fit:?}");
        assert!(fit.share < 0.7);
    }

    #[test]
    fn too_few_points_or_a_short_piece_is_no_wall() {
        let wall = Segment::new(Point2::new(0.0, 1.6), Point2::new(4.0, 1.6));
        let truth = Pose2::new(1.0, -0.5, 0.0);
        let points = wall_points(&wall, truth, 0.0);
        let expected = wall.seen_from(truth);
        assert!(fitter().fit(&points[..6], &expected, 0.4, 0.4).is_none());
        let short: Vec<_> = (0..40)
            .map(|i| Point2::new(1.0 + f64::from(i) * 0.006, 2.1))
            .collect();
        assert!(fitter().fit(&short, &expected, 0.4, 0.4).is_none());
        assert!(fitter().fit(&[], &expected, 0.4, 0.4).is_none());
    }

    #[test]
    fn scattered_points_are_no_wall() {
        let expected = Segment::new(Point2::new(0.0, 2.0), Point2::new(4.0, 2.0));
        let points: Vec<_> = (0..60)
            .map(|i| {
                let i = f64::from(i);
                Point2::new(i / 15.0, 2.0 + 0.4 * (i * 12.9898).sin())
            })
            .collect();
        let fit = fitter().fit(&points, &expected, 0.4, 0.4);
        assert!(fit.is_none(), "{fit:?}");
    }
}
