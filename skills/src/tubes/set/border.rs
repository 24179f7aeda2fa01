//! The border of one tube, as points at a distance outside it.
//!
//! All in `base_link` at t0. A turning tube is written once, for the left and forward; a right turn is the left turn of
//! the mirrored robot, mirrored, and so is driving backwards. The border has four parts:
//! - the arc of the outer front corner;
//! - the arc of the outer rear corner, which swings out at the beginning, or all along when the tail is longer than the
//!   nose, as of every robot that drives backwards;
//! - the leading edge at the end: front edge and inner side, with the corners between rounded;
//! - the arc of the inner end of the axle, which no other point of the robot passes inside of.
//!
//! Where the robot stands at t0 needs no border: it stands there.

use description::geometry::{Footprint, Point2, Pose2, Twist2};
use std::f64::consts::{FRAC_PI_2, PI};

/// A path of `base_link` at a constant curvature; its length is negative when driven backwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Path {
    pub curvature_1_m: f64,
    pub length_m: f64,
}

impl Path {
    /// The angle turned, positive to the left.
    pub fn angle_rad(&self) -> f64 {
        self.curvature_1_m * self.length_m
    }

    /// Where `base_link` is after a part of the path, signed as its length.
    pub fn pose_at(&self, travelled_m: f64) -> Pose2 {
        Twist2::new(1.0, self.curvature_1_m).displacement(travelled_m)
    }

    /// Its arcs are lines, to within rounding.
    fn is_straight(&self) -> bool {
        self.angle_rad().abs() < 1e-6
    }
}

/// How many points cover a length when neighbours are at most a step apart and both ends are covered.
pub(crate) fn sample_count(length_m: f64, step_m: f64) -> usize {
    // The 1e-9 keeps a length of exactly n steps from becoming n + 1 by rounding.
    (length_m / step_m - 1e-9).ceil().max(0.0) as usize + 1
}

/// Adds the points of the border at `offset_m` outside the tube, at most `step_m` apart.
///
/// The inner side of a turn must lie on this side of the turning centre.
pub(crate) fn sample_border(
    footprint: &Footprint,
    path: Path,
    offset_m: f64,
    step_m: f64,
    points: &mut Vec<Point2>,
) {
    let mut body = *footprint;
    let mut turn = Path {
        curvature_1_m: path.curvature_1_m.abs(),
        length_m: path.length_m.abs(),
    };
    let mut border = Border {
        points,
        step_m,
        mirror: Point2::new(1.0, 1.0),
    };
    if path.length_m < 0.0 {
        border.mirror.x_m = -1.0;
        std::mem::swap(&mut body.front_m, &mut body.rear_m);
    }
    if path.is_straight() {
        turn.curvature_1_m = 0.0;
        border.straight(&body, turn.length_m, offset_m);
        return;
    }
    if path.curvature_1_m < 0.0 {
        border.mirror.y_m = -1.0;
        std::mem::swap(&mut body.left_m, &mut body.right_m);
    }
    border.left(&body, turn, offset_m);
}

struct Border<'a> {
    points: &'a mut Vec<Point2>,
    step_m: f64,
    /// −1 mirrors that coordinate of all points.
    mirror: Point2,
}

impl Border<'_> {
    fn add(&mut self, point: Point2) {
        let Point2 { x_m, y_m } = self.mirror;
        self.points
            .push(Point2::new(x_m * point.x_m, y_m * point.y_m));
    }

    fn line(&mut self, from: Point2, to: Point2) {
        let count = sample_count(from.distance_m(to), self.step_m);
        for index in 0..count {
            let fraction = index as f64 / (count - 1).max(1) as f64;
            self.add(from + (to - from) * fraction);
        }
    }

    fn arc(&mut self, centre: Point2, radius_m: f64, from_rad: f64, to_rad: f64, step_m: f64) {
        let count = sample_count(radius_m * (to_rad - from_rad).abs(), step_m);
        for index in 0..count {
            let fraction = index as f64 / (count - 1).max(1) as f64;
            let (sin, cos) = (from_rad + fraction * (to_rad - from_rad)).sin_cos();
            self.add(centre + Point2::new(cos, sin) * radius_m);
        }
    }

    /// A corner of the robot, rounded. Half steps: the corner of a box can point at it from any side.
    fn corner(&mut self, corner: Point2, offset_m: f64, from_rad: f64, to_rad: f64) {
        self.arc(corner, offset_m, from_rad, to_rad, self.step_m / 2.0);
    }

    fn straight(&mut self, body: &Footprint, length_m: f64, offset_m: f64) {
        let (front, end) = (body.front_m, body.front_m + length_m);
        let (left, right) = (body.left_m, -body.right_m);
        let left_line = left + offset_m;
        self.line(Point2::new(front, left_line), Point2::new(end, left_line));
        self.corner(Point2::new(end, left), offset_m, FRAC_PI_2, 0.0);
        let edge = end + offset_m;
        self.line(Point2::new(edge, left), Point2::new(edge, right));
        self.corner(Point2::new(end, right), offset_m, 0.0, -FRAC_PI_2);
        let right_line = right - offset_m;
        self.line(Point2::new(end, right_line), Point2::new(front, right_line));
    }

    fn left(&mut self, body: &Footprint, path: Path, offset_m: f64) {
        let centre = Point2::new(0.0, 1.0 / path.curvature_1_m);
        let turn_rad = path.angle_rad();
        let end = path.pose_at(path.length_m);
        let front_right = Point2::new(body.front_m, -body.right_m);
        let front_left = Point2::new(body.front_m, body.left_m);
        let arm_m = centre.y_m + body.right_m;
        let front_rad = (body.front_m / arm_m).atan();

        self.tail(body, centre, turn_rad, end, offset_m);

        let from_centre = front_right - centre;
        let (radius_m, phase_rad) = (from_centre.norm_m(), from_centre.direction_rad());
        // A tail longer than the nose has swept what the nose came through before.
        let within_tail_rad = if body.rear_m > body.front_m {
            (turn_rad - 2.0 * front_rad).max(0.0)
        } else {
            0.0
        };
        self.arc(
            centre,
            radius_m + offset_m,
            phase_rad + within_tail_rad,
            phase_rad + turn_rad,
            self.step_m,
        );
        let corner = end.transform(front_right);
        self.corner(corner, offset_m, phase_rad + turn_rad, turn_rad);
        let edge_m = body.front_m + offset_m;
        self.line(
            end.transform(Point2::new(edge_m, -body.right_m)),
            end.transform(Point2::new(edge_m, body.left_m)),
        );
        let corner = end.transform(front_left);
        self.corner(corner, offset_m, turn_rad, turn_rad + FRAC_PI_2);
        let side_m = body.left_m + offset_m;
        self.line(
            end.transform(Point2::new(body.front_m, side_m)),
            end.transform(Point2::new(0.0, side_m)),
        );

        // A hole smaller than the offset still has its middle sampled.
        let inner_m = (centre.y_m - body.left_m - offset_m).max(0.0);
        let phase_rad = -FRAC_PI_2;
        self.arc(
            centre,
            inner_m,
            phase_rad + turn_rad,
            phase_rad,
            self.step_m,
        );
    }

    /// The swing of the outer rear corner, until it comes to where the robot's side was at t0; of a long tail to the end.
    fn tail(&mut self, body: &Footprint, centre: Point2, turn_rad: f64, end: Pose2, offset_m: f64) {
        let rear_right = Point2::new(-body.rear_m, -body.right_m);
        let from_centre = rear_right - centre;
        let (radius_m, phase_rad) = (from_centre.norm_m(), from_centre.direction_rad());
        let arm_m = centre.y_m + body.right_m;
        let long = body.rear_m > body.front_m;
        let whole_rad = 2.0 * (body.rear_m / arm_m).atan();
        let swing_rad = if long {
            turn_rad
        } else {
            turn_rad.min(whole_rad)
        };
        self.arc(
            centre,
            radius_m + offset_m,
            phase_rad,
            phase_rad + swing_rad,
            self.step_m,
        );
        if turn_rad < whole_rad || long {
            // At the end the side stands out, from the tail to where the old side crosses it or the nose has passed.
            let side_m = -body.right_m - offset_m;
            let corner = end.transform(rear_right);
            self.corner(corner, offset_m, phase_rad + turn_rad, turn_rad - FRAC_PI_2);
            let crossing_m = arm_m * (turn_rad.min(PI - 1e-6) / 2.0).tan();
            self.line(
                end.transform(Point2::new(-body.rear_m, side_m)),
                end.transform(Point2::new(-crossing_m.min(body.front_m), side_m)),
            );
        }
    }
}

/// The robot's places along a path, close together, for asking what it covers.
pub(crate) struct Sweep {
    /// Position, cosine and sine of every place.
    places: Vec<(Point2, f64, f64)>,
}

impl Sweep {
    /// Places in steps in which no part of the robot moves more than `resolution_m`.
    pub fn new(footprint: &Footprint, path: Path, resolution_m: f64) -> Self {
        let per_metre = 1.0 + footprint.radius_m() * path.curvature_1_m.abs();
        let count = sample_count(path.length_m.abs(), resolution_m / per_metre);
        let places = (0..count)
            .map(|index| {
                let fraction = index as f64 / (count - 1).max(1) as f64;
                let pose = path.pose_at(path.length_m * fraction);
                let (sin, cos) = pose.theta_rad.sin_cos();
                (pose.position(), cos, sin)
            })
            .collect();
        Self { places }
    }

    /// Whether the robot covers a point anywhere on its path.
    pub fn covers(&self, footprint: &Footprint, point: Point2) -> bool {
        self.places.iter().any(|&(position, cos, sin)| {
            let delta = point - position;
            footprint.contains(Point2::new(
                cos * delta.x_m + sin * delta.y_m,
                cos * delta.y_m - sin * delta.x_m,
            ))
        })
    }
}

/// The largest turn of a tube: a larger one leads back to where the robot stands.
pub(crate) const MAX_TURN_RAD: f64 = PI;

#[cfg(test)]
mod tests {
    use super::*;

    const BODY: Footprint = Footprint {
        front_m: 0.32,
        rear_m: 0.08,
        left_m: 0.15,
        right_m: 0.15,
    };

    fn border(body: &Footprint, curvature_1_m: f64, length_m: f64, offset_m: f64) -> Vec<Point2> {
        let path = Path {
            curvature_1_m,
            length_m,
        };
        let mut points = Vec::new();
        sample_border(body, path, offset_m, 0.05, &mut points);
        points
    }

    /// Distance of a point from the swept area.
    fn distance_m(body: &Footprint, path: Path, point: Point2) -> f64 {
        (0..=4000)
            .map(|i| path.pose_at(path.length_m * f64::from(i) / 4000.0))
            .map(|pose| body.distance_m(pose.inverse_transform(point)))
            .fold(f64::MAX, f64::min)
    }

    #[test]
    fn sample_counts_follow_the_formula() {
        // n = ceil(length / step) + 1, both ends sampled.
        assert_eq!(sample_count(1.6, 0.05), 33);
        assert_eq!(sample_count(1.61, 0.05), 34);
        assert_eq!(sample_count(0.0, 0.05), 1);
        // Straight, 0.4 m/s for 4 s: two sides of 33, the front of 7, two corners of 4.
        let corner = sample_count(0.025 * FRAC_PI_2, 0.025);
        assert_eq!(
            border(&BODY, 0.0, 1.6, 0.025).len(),
            2 * 33 + 7 + 2 * corner
        );
    }

    #[test]
    fn every_sample_lies_at_the_offset_outside() {
        let long_tail = Footprint {
            front_m: 0.5,
            rear_m: 0.4,
            left_m: 0.2,
            right_m: 0.3,
        };
        let longer_tail = Footprint {
            front_m: 0.1,
            rear_m: 0.5,
            left_m: 0.2,
            right_m: 0.25,
        };
        for body in [BODY, long_tail, longer_tail] {
            for curvature_1_m in [0.0, 0.02, 0.3, -0.3, 1.0, 2.0, -2.0, 2.9] {
                for length_m in [0.1, 0.25, 0.6, 1.0, -0.1, -0.25, -0.6, -1.0] {
                    let path = Path {
                        curvature_1_m,
                        length_m,
                    };
                    for point in border(&body, curvature_1_m, length_m, 0.03) {
                        let distance_m = distance_m(&body, path, point);
                        // Nearer only where the swing meets the old side at a blunt angle, as with a long tail.
                        assert!(
                            distance_m < 0.0302 && distance_m > 0.02,
                            "{distance_m} at {point:?} of {path:?}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn neighbours_are_at_most_a_step_apart() {
        for curvature_1_m in [0.0, 0.5, -1.0, 2.0] {
            let points = border(&BODY, curvature_1_m, 1.0, 0.025);
            // One gap is the robot itself, between the tail and the outer corner.
            let wide = points
                .windows(2)
                .filter(|pair| pair[0].distance_m(pair[1]) > 0.05 + 1e-9)
                .count();
            assert!(wide <= 1, "{wide} gaps at {curvature_1_m}");
        }
    }

    #[test]
    fn a_right_turn_is_a_mirrored_left_turn() {
        let left = border(&BODY, 1.3, 0.8, 0.025);
        let right = border(&BODY, -1.3, 0.8, 0.025);
        for (left, right) in left.iter().zip(&right) {
            assert_eq!(left.x_m, right.x_m);
            assert_eq!(left.y_m, -right.y_m);
        }
    }

    #[test]
    fn a_hardly_curved_tube_is_like_a_straight_one() {
        let straight = border(&BODY, 0.0, 1.0, 0.025);
        let path = Path {
            curvature_1_m: 1e-5,
            length_m: 1.0,
        };
        for point in straight {
            assert!((distance_m(&BODY, path, point) - 0.025).abs() < 1e-3);
        }
    }
}
