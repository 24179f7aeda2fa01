//! The fit: from points to the line that most of the wall's length agrees on.

use super::ScanPoints;
use super::judge::describe;
use super::points::{Four, INLIER_SIGMA, Line, Noise, PIECES, WallPoint};
use crate::perception::RANGE_STD_SHARE;
use crate::perception::wall_fit::WallFit;
use description::geometry::{Point2, Segment};
use description::robot::Navigation;

/// Pairs of points that are tried.
const PAIRS: usize = 48;
/// A line with this share of all the support that there can be is refined at once: no other pair has much more.
const ENOUGH: f64 = 0.9;
/// Fours of points after which a line that has fallen behind is given up.
const FOURS: usize = 4;
/// More than rounding makes of sums of shares, which are at most the number of pieces.
const ROUNDING: f64 = 1e-9;
/// Passes of the refinement; the last ones use only points as close as noise explains.
const PASSES: usize = 6;
const NARROW_PASSES: usize = 3;
/// A point counts up to 1.5 times its reach.
const TUKEY_SHARE: f64 = 1.0 / 1.5;
/// The expected direction cannot be off by more than this slope.
const MAX_SLOPE: f64 = 0.6;
/// Left out at both ends of the expected segment, where the next wall begins; of a short one this share.
const END_MARGIN_M: f64 = 0.10;
const END_MARGIN_SHARE: f64 = 0.15;

/// Fits lines; holds the memory that a fit needs.
#[derive(Clone, Debug)]
pub struct LineFitter {
    near: Vec<WallPoint>,
    /// The same four at a time, but for the last ones: what is asked for by every line that is tried.
    fours: Vec<Four>,
    expected: Segment,
    unit: Point2,
    length_m: f64,
    /// Of the sensor, in the coordinates of the expected wall.
    eye: Point2,
    /// As far as the sensor sees.
    sight_m: f64,
    gains: Navigation,
    noise: Noise,
}

impl LineFitter {
    /// A fitter that uses at most `capacity` points of a scan.
    #[must_use]
    pub fn new(capacity: usize, gains: Navigation) -> Self {
        Self {
            near: Vec::with_capacity(capacity),
            fours: Vec::with_capacity(capacity / 4),
            expected: Segment::default(),
            unit: Point2::default(),
            length_m: 0.0,
            eye: Point2::default(),
            sight_m: f64::INFINITY,
            noise: Noise::of(&gains),
            gains,
        }
    }

    /// The wall near `expected` (in `base_link`), when enough points within `gate_m` agree on one and cover at
    /// least `min_span_m` of it.
    pub fn fit(
        &mut self,
        seen: ScanPoints<'_>,
        expected: &Segment,
        gate_m: f64,
        min_span_m: f64,
    ) -> Option<WallFit> {
        self.begin(expected, seen.eye, seen.sight_m);
        for &point in seen.points {
            self.offer(point, gate_m);
        }
        self.solve(min_span_m)
    }

    /// Starts over with an expected wall, seen by a sensor at `eye` as far as `sight_m`; both in `base_link`.
    pub(in crate::perception) fn begin(&mut self, expected: &Segment, eye: Point2, sight_m: f64) {
        self.near.clear();
        self.sight_m = sight_m;
        self.expected = *expected;
        self.unit = expected.unit();
        self.length_m = expected.length_m();
        self.eye = self.place(eye);
    }

    /// Takes a point when it lies beside the wall and within the gate.
    pub(in crate::perception) fn offer(&mut self, point: Point2, gate_m: f64) {
        let place = self.place(point);
        let margin_m = END_MARGIN_M.min(END_MARGIN_SHARE * self.length_m);
        let beside = place.x_m >= margin_m && place.x_m <= self.length_m - margin_m;
        // Also leaves out what is not a number.
        if !(beside && place.y_m.abs() <= gate_m) || self.near.len() == self.near.capacity() {
            return;
        }
        self.near.push(WallPoint::of(place, self.eye, &self.noise));
    }

    /// The wall that the points taken agree on.
    pub(in crate::perception) fn solve(&mut self, min_span_m: f64) -> Option<WallFit> {
        if self.near.len() < (self.gains.wall_min_points as usize) {
            return None;
        }
        let mut counts = [0u32; PIECES];
        for point in &self.near {
            counts[point.piece] += 1;
        }
        // One division for each piece, not for each point; no point is in an empty one.
        let shares = counts.map(|count| 1.0 / f64::from(count.max(1)));
        for point in &mut self.near {
            point.share = shares[point.piece];
        }
        self.fours.clear();
        self.fours
            .extend(self.near.as_chunks().0.iter().map(Four::of));
        let rest = &self.near[4 * self.fours.len()..];
        let mut left = rest.iter().map(|point| point.share).sum();
        for four in self.fours.iter_mut().rev() {
            four.left = left;
            left += four.share.iter().sum::<f64>();
        }
        let mut line = self.refine(self.start(min_span_m, left)?)?;
        if self.leave_out_of_sight(&line) {
            line = self.refine(line)?;
        }
        describe(
            &self.near,
            &line,
            &self.expected,
            self.gains.wall_min_points as usize,
            min_span_m,
        )
    }

    /// Where the wall passes out of sight, noise lets only those points through that came out short. Takes them all out;
    /// `false`: there were none.
    fn leave_out_of_sight(&mut self, line: &Line) -> bool {
        let (before, eye, sight_m) = (self.near.len(), self.eye, self.sight_m);
        let least_std_m = self.gains.range_std_m;
        self.near.retain(|point| {
            let on_line_m = point.across_m - line.residual_m(point.along_m, point.across_m);
            let range_m = Point2::new(point.along_m, on_line_m).distance_m(eye);
            let std_m = least_std_m.max(RANGE_STD_SHARE * range_m);
            range_m + INLIER_SIGMA * std_m < sight_m
        });
        self.near.len() < before
    }

    /// A point of `base_link` in the coordinates of the expected wall.
    fn place(&self, point: Point2) -> Point2 {
        let from_start = point - self.expected.a;
        Point2::new(self.unit.dot(from_start), self.unit.cross(from_start))
    }

    /// The line through two points that accounts for the most length, of all that there is.
    fn start(&self, min_span_m: f64, all: f64) -> Option<Line> {
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
            let most = best.map_or(f64::NEG_INFINITY, |(most, _)| most);
            if let Some(support) = self.support(&line, most) {
                if support > ENOUGH * all {
                    return Some(line);
                }
                best = Some((support, line));
            }
        }
        best.map(|(_, line)| line)
    }

    /// Pieces of wall that lie on the line, the closer the more they count, less those that are seen beyond it. `None` when
    /// they are no more than `most`: that is found as soon as those that are left cannot make up for it.
    fn support(&self, line: &Line, most: f64) -> Option<f64> {
        let beyond = if self.eye.y_m > 0.0 { -1.0 } else { 1.0 };
        let count = |along_m: f64, across_m: f64, per_reach_1_m: f64, share: f64| {
            let off = line.residual_m(along_m, across_m) * per_reach_1_m;
            let outside = if off * beyond > 0.0 { -1.0 } else { 0.0 };
            let square = off * off;
            share * if square < 1.0 { 1.0 - square } else { outside }
        };
        // Four sums, which do not wait for each other: this is tried for many lines.
        let mut sums = [0.0; 4];
        for fours in self.fours.chunks(FOURS) {
            for four in fours {
                for (i, sum) in sums.iter_mut().enumerate() {
                    *sum += count(
                        four.along_m[i],
                        four.across_m[i],
                        four.per_reach_1_m[i],
                        four.share[i],
                    );
                }
            }
            let left = fours.last().map_or(0.0, |four| four.left);
            if sums.iter().sum::<f64>() + left + ROUNDING < most {
                return None;
            }
        }
        let rest = { self.near[4 * self.fours.len()..].iter() }
            .map(|own| count(own.along_m, own.across_m, own.per_reach_1_m, own.share));
        let support = sums.iter().sum::<f64>() + rest.sum::<f64>();
        (support > most).then_some(support)
    }

    fn refine(&self, start: Line) -> Option<Line> {
        let mut line = start;
        for pass in 0..PASSES {
            let narrow = pass + NARROW_PASSES >= PASSES;
            let (mut sum, mut along, mut across) = (0.0, 0.0, 0.0);
            let (mut square, mut product, mut counted) = (0.0, 0.0, 0.0);
            for point in &self.near {
                let per_reach_1_m = if narrow {
                    point.per_noise_1_m
                } else {
                    point.per_reach_1_m
                };
                let residual_m = line.residual_m(point.along_m, point.across_m);
                let tukey = tukey(residual_m * per_reach_1_m * TUKEY_SHARE);
                if tukey > 0.0 {
                    let weight = tukey * point.weight_1_m2;
                    let from_centre_m = point.along_m - line.centre_m;
                    counted += tukey;
                    sum += weight;
                    along += weight * from_centre_m;
                    across += weight * point.across_m;
                    square += weight * from_centre_m * from_centre_m;
                    product += weight * from_centre_m * point.across_m;
                }
            }
            if counted < 2.0 {
                return None;
            }
            let (mean, mean_across) = (along / sum, across / sum);
            let spread = square - along * mean;
            if spread < 1e-6 * sum {
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
mod tests;
