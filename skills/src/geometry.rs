//! Plane geometry that all skills share.
//!
//! Frames and units follow REP 103: x forward, y left, angles counter-clockwise, metres, radians, seconds.
//! Plain `Copy` values; nothing here allocates, locks or panics, so all of it may run in a real-time thread.
//!
//! ```
//! use skills::geometry::{Point2, Pose2};
//! let laser_in_base = Pose2::new(0.28, 0.0, 0.0);
//! let point = laser_in_base.transform(Point2::new(1.0, 0.5));
//! assert!((point.x_m - 1.28).abs() < 1e-12);
//! ```

use std::f64::consts::{PI, TAU};

/// An angle brought into (−π, π]. A value that is not finite stays as it is.
#[must_use]
pub fn wrap_angle(angle_rad: f64) -> f64 {
    if angle_rad > -PI && angle_rad <= PI {
        return angle_rad;
    }
    let wrapped = angle_rad.rem_euclid(TAU);
    if wrapped > PI { wrapped - TAU } else { wrapped }
}

/// A point, or a free vector, in the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point2 {
    /// Forward.
    pub x_m: f64,
    /// Left.
    pub y_m: f64,
}

impl Point2 {
    /// The point (x, y).
    #[must_use]
    pub const fn new(x_m: f64, y_m: f64) -> Self {
        Self { x_m, y_m }
    }

    /// Length of the vector from the origin.
    #[must_use]
    pub fn norm_m(self) -> f64 {
        self.x_m.hypot(self.y_m)
    }

    /// Direction of the vector from the origin.
    #[must_use]
    pub fn direction_rad(self) -> f64 {
        self.y_m.atan2(self.x_m)
    }

    /// Distance to `other`.
    #[must_use]
    pub fn distance_m(self, other: Self) -> f64 {
        (self - other).norm_m()
    }

    /// Scalar product.
    #[must_use]
    pub fn dot(self, other: Self) -> f64 {
        self.x_m * other.x_m + self.y_m * other.y_m
    }

    /// The component of the cross product that stands on the plane; positive when `other` lies to the left.
    #[must_use]
    pub fn cross(self, other: Self) -> f64 {
        self.x_m * other.y_m - self.y_m * other.x_m
    }

    /// Both coordinates are finite.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.x_m.is_finite() && self.y_m.is_finite()
    }
}

impl std::ops::Add for Point2 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.x_m + other.x_m, self.y_m + other.y_m)
    }
}

impl std::ops::Sub for Point2 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.x_m - other.x_m, self.y_m - other.y_m)
    }
}

impl std::ops::Mul<f64> for Point2 {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self::new(self.x_m * factor, self.y_m * factor)
    }
}

impl From<[f64; 2]> for Point2 {
    fn from([x_m, y_m]: [f64; 2]) -> Self {
        Self::new(x_m, y_m)
    }
}

/// A rigid placement of one frame in another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose2 {
    /// Forward, in the outer frame.
    pub x_m: f64,
    /// Left, in the outer frame.
    pub y_m: f64,
    /// Rotation of the inner frame in the outer one.
    pub theta_rad: f64,
}

impl Pose2 {
    /// The frame itself.
    pub const IDENTITY: Self = Self::new(0.0, 0.0, 0.0);

    /// A pose from its three numbers; the angle is taken as given.
    #[must_use]
    pub const fn new(x_m: f64, y_m: f64, theta_rad: f64) -> Self {
        Self {
            x_m,
            y_m,
            theta_rad,
        }
    }

    /// Where the origin of the inner frame lies.
    #[must_use]
    pub const fn position(self) -> Point2 {
        Point2::new(self.x_m, self.y_m)
    }

    /// `self ∘ inner`: the pose, in the outer frame, of a pose given in this one.
    #[must_use]
    pub fn compose(self, inner: Self) -> Self {
        let position = self.transform(inner.position());
        Self::new(
            position.x_m,
            position.y_m,
            wrap_angle(self.theta_rad + inner.theta_rad),
        )
    }

    /// The pose of the outer frame in this one.
    #[must_use]
    pub fn inverse(self) -> Self {
        let (sin, cos) = self.theta_rad.sin_cos();
        Self::new(
            -(cos * self.x_m + sin * self.y_m),
            sin * self.x_m - cos * self.y_m,
            wrap_angle(-self.theta_rad),
        )
    }

    /// The pose of `other` seen from this one; both are given in the same frame.
    #[must_use]
    pub fn between(self, other: Self) -> Self {
        self.inverse().compose(other)
    }

    /// A point of the inner frame, in the outer one.
    #[must_use]
    pub fn transform(self, point: Point2) -> Point2 {
        self.position() + self.rotate(point)
    }

    /// A point of the outer frame, in the inner one.
    #[must_use]
    pub fn inverse_transform(self, point: Point2) -> Point2 {
        let (sin, cos) = self.theta_rad.sin_cos();
        let delta = point - self.position();
        Point2::new(
            cos * delta.x_m + sin * delta.y_m,
            cos * delta.y_m - sin * delta.x_m,
        )
    }

    /// A free vector of the inner frame, in the outer one.
    #[must_use]
    pub fn rotate(self, vector: Point2) -> Point2 {
        let (sin, cos) = self.theta_rad.sin_cos();
        Point2::new(
            cos * vector.x_m - sin * vector.y_m,
            sin * vector.x_m + cos * vector.y_m,
        )
    }

    /// Where this pose gets to when it moves with a constant twist for a time.
    #[must_use]
    pub fn advance(self, twist: Twist2, duration_s: f64) -> Self {
        self.compose(twist.displacement(duration_s))
    }

    /// The pose `fraction` of the way to `other`: straight in position, the short way round in angle.
    #[must_use]
    pub fn interpolate(self, other: Self, fraction: f64) -> Self {
        Self::new(
            self.x_m + fraction * (other.x_m - self.x_m),
            self.y_m + fraction * (other.y_m - self.y_m),
            wrap_angle(self.theta_rad + fraction * wrap_angle(other.theta_rad - self.theta_rad)),
        )
    }

    /// All three numbers are finite.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.x_m.is_finite() && self.y_m.is_finite() && self.theta_rad.is_finite()
    }
}

/// Speed along x and turning speed of `base_link`; the fixed axle allows no speed along y.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist2 {
    /// Forward speed.
    pub v_m_s: f64,
    /// Turning speed, positive to the left.
    pub omega_rad_s: f64,
}

impl Twist2 {
    /// A twist from its two numbers.
    #[must_use]
    pub const fn new(v_m_s: f64, omega_rad_s: f64) -> Self {
        Self { v_m_s, omega_rad_s }
    }

    /// The pose reached from the origin after moving so for a time: an arc, or a straight line.
    #[must_use]
    pub fn displacement(self, duration_s: f64) -> Pose2 {
        let angle = self.omega_rad_s * duration_s;
        let distance = self.v_m_s * duration_s;
        // Series near zero, where the closed form divides by the angle.
        let (along, across) = if angle.abs() < 1e-4 {
            (1.0 - angle * angle / 6.0, angle / 2.0)
        } else {
            (angle.sin() / angle, (1.0 - angle.cos()) / angle)
        };
        Pose2::new(distance * along, distance * across, wrap_angle(angle))
    }

    /// Both numbers are finite.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.v_m_s.is_finite() && self.omega_rad_s.is_finite()
    }
}

/// What a controller wants of the base: a speed along a path of constant curvature.
///
/// The path, not the turning speed, is the intention: a command that is slowed down still follows the same curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionCommand {
    /// Forward speed of `base_link`.
    pub speed_m_s: f64,
    /// Turning per metre driven, positive to the left.
    pub curvature_1_m: f64,
}

impl MotionCommand {
    /// Standing still, wheels straight.
    pub const STOP: Self = Self::new(0.0, 0.0);

    /// A command from its two numbers.
    #[must_use]
    pub const fn new(speed_m_s: f64, curvature_1_m: f64) -> Self {
        Self {
            speed_m_s,
            curvature_1_m,
        }
    }

    /// The twist that drives it.
    #[must_use]
    pub fn twist(self) -> Twist2 {
        Twist2::new(self.speed_m_s, self.speed_m_s * self.curvature_1_m)
    }

    /// The same path at another speed.
    #[must_use]
    pub fn with_speed(self, speed_m_s: f64) -> Self {
        Self { speed_m_s, ..self }
    }

    /// Both numbers are finite.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.speed_m_s.is_finite() && self.curvature_1_m.is_finite()
    }
}

/// The robot's outline: a rectangle given by its distances from `base_link`, all positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// From `base_link` to the front edge.
    pub front_m: f64,
    /// From `base_link` to the rear edge.
    pub rear_m: f64,
    /// From `base_link` to the left edge.
    pub left_m: f64,
    /// From `base_link` to the right edge.
    pub right_m: f64,
}

impl Footprint {
    /// The corners: front left, rear left, rear right, front right.
    #[must_use]
    pub fn corners(&self) -> [Point2; 4] {
        [
            Point2::new(self.front_m, self.left_m),
            Point2::new(-self.rear_m, self.left_m),
            Point2::new(-self.rear_m, -self.right_m),
            Point2::new(self.front_m, -self.right_m),
        ]
    }

    /// Front to rear.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.front_m + self.rear_m
    }

    /// Left to right.
    #[must_use]
    pub fn width_m(&self) -> f64 {
        self.left_m + self.right_m
    }

    /// Distance from `base_link` to the farthest corner.
    #[must_use]
    pub fn radius_m(&self) -> f64 {
        self.front_m
            .max(self.rear_m)
            .hypot(self.left_m.max(self.right_m))
    }

    /// The outline moved outwards by a margin.
    #[must_use]
    pub fn grown(&self, margin_m: f64) -> Self {
        Self {
            front_m: self.front_m + margin_m,
            rear_m: self.rear_m + margin_m,
            left_m: self.left_m + margin_m,
            right_m: self.right_m + margin_m,
        }
    }

    /// Whether a point, in `base_link`, lies inside or on the outline.
    #[must_use]
    pub fn contains(&self, point: Point2) -> bool {
        point.x_m >= -self.rear_m
            && point.x_m <= self.front_m
            && point.y_m >= -self.right_m
            && point.y_m <= self.left_m
    }

    /// Distance of a point, in `base_link`, from the outline; 0 inside.
    #[must_use]
    pub fn distance_m(&self, point: Point2) -> f64 {
        self.as_rect().distance_m(point)
    }

    /// The outline as a rectangle of `base_link`.
    #[must_use]
    pub fn as_rect(&self) -> Rect {
        Rect {
            min: Point2::new(-self.rear_m, -self.right_m),
            max: Point2::new(self.front_m, self.left_m),
        }
    }

    /// All four distances are finite and positive.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        [self.front_m, self.rear_m, self.left_m, self.right_m]
            .iter()
            .all(|side_m| side_m.is_finite() && *side_m > 0.0)
    }
}

/// A directed straight segment from `a` to `b`: a wall, or the centre line of a lane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Segment {
    /// Where it starts.
    pub a: Point2,
    /// Where it ends.
    pub b: Point2,
}

impl Segment {
    /// The segment from `a` to `b`.
    #[must_use]
    pub const fn new(a: Point2, b: Point2) -> Self {
        Self { a, b }
    }

    /// From start to end.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.a.distance_m(self.b)
    }

    /// The direction from start to end.
    #[must_use]
    pub fn direction_rad(&self) -> f64 {
        (self.b - self.a).direction_rad()
    }

    /// The unit vector from start to end; zero when both coincide.
    #[must_use]
    pub fn unit(&self) -> Point2 {
        let length_m = self.length_m();
        if length_m > 0.0 {
            (self.b - self.a) * (1.0 / length_m)
        } else {
            Point2::default()
        }
    }

    /// Where the foot of the perpendicular from `point` lies along the line, from the start; may lie outside the segment.
    #[must_use]
    pub fn along_m(&self, point: Point2) -> f64 {
        (point - self.a).dot(self.unit())
    }

    /// Distance of `point` from the infinite line, positive to the left of its direction.
    #[must_use]
    pub fn lateral_m(&self, point: Point2) -> f64 {
        self.unit().cross(point - self.a)
    }

    /// The point of the segment closest to `point`.
    #[must_use]
    pub fn closest_point(&self, point: Point2) -> Point2 {
        let along_m = self.along_m(point).clamp(0.0, self.length_m());
        self.a + self.unit() * along_m
    }

    /// Distance of `point` from the segment.
    #[must_use]
    pub fn distance_m(&self, point: Point2) -> f64 {
        self.closest_point(point).distance_m(point)
    }

    /// How far a ray from `origin` along `direction_rad` travels until it meets the segment.
    #[must_use]
    pub fn ray_range_m(&self, origin: Point2, direction_rad: f64) -> Option<f64> {
        let (sin, cos) = direction_rad.sin_cos();
        let ray = Point2::new(cos, sin);
        let edge = self.b - self.a;
        let determinant = ray.cross(edge);
        if determinant.abs() < 1e-12 {
            return None;
        }
        let offset = self.a - origin;
        let range_m = offset.cross(edge) / determinant;
        let fraction = offset.cross(ray) / determinant;
        (range_m >= 0.0 && (0.0..=1.0).contains(&fraction)).then_some(range_m)
    }

    /// The same segment seen from the inner frame of `pose`.
    #[must_use]
    pub fn seen_from(&self, pose: Pose2) -> Self {
        Self::new(
            pose.inverse_transform(self.a),
            pose.inverse_transform(self.b),
        )
    }
}

/// A rectangle with its sides along the axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rect {
    /// The corner with the smaller coordinates.
    pub min: Point2,
    /// The corner with the larger coordinates.
    pub max: Point2,
}

impl Rect {
    /// The rectangle that two opposite corners span, in any order.
    #[must_use]
    pub fn new(one: Point2, other: Point2) -> Self {
        Self {
            min: Point2::new(one.x_m.min(other.x_m), one.y_m.min(other.y_m)),
            max: Point2::new(one.x_m.max(other.x_m), one.y_m.max(other.y_m)),
        }
    }

    /// Whether a point lies inside or on the border.
    #[must_use]
    pub fn contains(&self, point: Point2) -> bool {
        point.x_m >= self.min.x_m
            && point.x_m <= self.max.x_m
            && point.y_m >= self.min.y_m
            && point.y_m <= self.max.y_m
    }

    /// Distance of a point from the rectangle; 0 inside.
    #[must_use]
    pub fn distance_m(&self, point: Point2) -> f64 {
        let dx_m = (self.min.x_m - point.x_m)
            .max(point.x_m - self.max.x_m)
            .max(0.0);
        let dy_m = (self.min.y_m - point.y_m)
            .max(point.y_m - self.max.y_m)
            .max(0.0);
        dx_m.hypot(dy_m)
    }

    /// The middle.
    #[must_use]
    pub fn centre(&self) -> Point2 {
        (self.min + self.max) * 0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_2;

    fn pose() -> impl Strategy<Value = Pose2> {
        (-10.0..10.0, -10.0..10.0, -PI..PI).prop_map(|(x, y, t)| Pose2::new(x, y, t))
    }

    fn close(one: Pose2, other: Pose2) -> bool {
        one.position().distance_m(other.position()) < 1e-9
            && wrap_angle(one.theta_rad - other.theta_rad).abs() < 1e-9
    }

    proptest! {
        #[test]
        fn a_pose_and_its_inverse_cancel(one in pose(), other in pose()) {
            prop_assert!(close(one.compose(one.inverse()), Pose2::IDENTITY));
            prop_assert!(close(one.compose(one.between(other)), other));
            let point = other.position();
            prop_assert!(one.inverse_transform(one.transform(point)).distance_m(point) < 1e-9);
        }

        #[test]
        fn wrapping_keeps_the_direction(angle in -100.0..100.0f64) {
            let wrapped = wrap_angle(angle);
            prop_assert!(wrapped > -PI && wrapped <= PI);
            prop_assert!((wrapped.sin() - angle.sin()).abs() < 1e-9);
            prop_assert!((wrapped.cos() - angle.cos()).abs() < 1e-9);
        }

        #[test]
        fn two_half_displacements_make_a_whole(v in -1.0..1.0f64, omega in -2.0..2.0f64, t in 0.0..4.0f64) {
            let twist = Twist2::new(v, omega);
            let half = twist.displacement(t / 2.0);
            let whole = twist.displacement(t);
            prop_assert!(half.compose(half).position().distance_m(whole.position()) < 1e-7);
        }
    }

    #[test]
    fn a_quarter_circle_ends_where_it_should() {
        let end = Twist2::new(0.5, 0.5).displacement(TAU);
        assert!(end.position().distance_m(Point2::new(0.0, 2.0)) < 1e-12);
        let end = MotionCommand::new(0.25, 2.0)
            .twist()
            .displacement(FRAC_PI_2 / 0.5);
        assert!(close(end, Pose2::new(0.5, 0.5, FRAC_PI_2)));
    }

    #[test]
    fn a_segment_measures_along_left_and_by_ray() {
        let wall = Segment::new(Point2::new(0.0, 1.0), Point2::new(4.0, 1.0));
        assert_eq!(wall.along_m(Point2::new(3.0, 5.0)), 3.0);
        assert_eq!(wall.lateral_m(Point2::new(3.0, 5.0)), 4.0);
        assert_eq!(wall.distance_m(Point2::new(7.0, 5.0)), 5.0);
        let range = wall.ray_range_m(Point2::new(2.0, 0.0), FRAC_PI_2);
        assert!((range.unwrap() - 1.0).abs() < 1e-12);
        assert_eq!(wall.ray_range_m(Point2::new(2.0, 0.0), 0.0), None);
        assert_eq!(wall.ray_range_m(Point2::new(2.0, 0.0), -FRAC_PI_2), None);
    }

    #[test]
    fn an_empty_segment_divides_by_nothing() {
        let point = Segment::default();
        assert_eq!(point.distance_m(Point2::new(3.0, 4.0)), 5.0);
        assert_eq!(point.lateral_m(Point2::new(3.0, 4.0)), 0.0);
    }

    #[test]
    fn a_footprint_measures_outwards() {
        let footprint = Footprint {
            front_m: 0.32,
            rear_m: 0.08,
            left_m: 0.15,
            right_m: 0.15,
        };
        assert!(footprint.contains(Point2::new(0.3, -0.1)));
        assert!((footprint.distance_m(Point2::new(0.42, 0.0)) - 0.1).abs() < 1e-12);
        assert!((footprint.length_m() - 0.4).abs() < 1e-12);
        assert!(
            !Footprint {
                rear_m: f64::NAN,
                ..footprint
            }
            .is_valid()
        );
    }

    #[test]
    fn what_is_not_finite_stays_visible() {
        assert!(wrap_angle(f64::NAN).is_nan());
        assert!(!MotionCommand::new(f64::INFINITY, 0.0).is_finite());
        assert!(!Pose2::new(0.0, f64::NAN, 0.0).is_finite());
    }
}
