//! Points, poses, twists and commands.

use std::f64::consts::{PI, TAU};

/// An angle brought into (−π, π]. A value that is not finite stays as it is.
#[must_use]
#[inline]
pub fn wrap_angle(angle_rad: f64) -> f64 {
    if angle_rad > -PI && angle_rad <= PI {
        return angle_rad;
    }
    let wrapped = angle_rad.rem_euclid(TAU);
    if wrapped > PI { wrapped - TAU } else { wrapped }
}

/// A point, or a free vector, in the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "pod",
    derive(bytemuck::Pod, bytemuck::Zeroable, serde::Serialize)
)]
#[repr(C)]
pub struct Point2 {
    /// Forward.
    pub x_m: f64,
    /// Left.
    pub y_m: f64,
}

impl Point2 {
    /// The point (x, y).
    #[must_use]
    #[inline]
    pub const fn new(x_m: f64, y_m: f64) -> Self {
        Self { x_m, y_m }
    }

    /// Both coordinates, in metres.
    #[must_use]
    #[inline]
    pub const fn xy_m(self) -> [f64; 2] {
        [self.x_m, self.y_m]
    }

    /// Length of the vector from the origin.
    #[must_use]
    #[inline]
    pub fn norm_m(self) -> f64 {
        // Not `hypot`, which takes four times as long to be right about lengths that no robot meets.
        (self.x_m * self.x_m + self.y_m * self.y_m).sqrt()
    }

    /// Direction of the vector from the origin.
    #[must_use]
    #[inline]
    pub fn direction_rad(self) -> f64 {
        self.y_m.atan2(self.x_m)
    }

    /// Distance to `other`.
    #[must_use]
    #[inline]
    pub fn distance_m(self, other: Self) -> f64 {
        (self - other).norm_m()
    }

    /// Scalar product.
    #[must_use]
    #[inline]
    pub fn dot(self, other: Self) -> f64 {
        self.x_m * other.x_m + self.y_m * other.y_m
    }

    /// The component of the cross product that stands on the plane; positive when `other` lies to the left.
    #[must_use]
    #[inline]
    pub fn cross(self, other: Self) -> f64 {
        self.x_m * other.y_m - self.y_m * other.x_m
    }

    /// Both coordinates are finite.
    #[must_use]
    #[inline]
    pub fn is_finite(self) -> bool {
        self.x_m.is_finite() && self.y_m.is_finite()
    }
}

impl std::ops::Add for Point2 {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self::new(self.x_m + other.x_m, self.y_m + other.y_m)
    }
}

impl std::ops::Sub for Point2 {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x_m - other.x_m, self.y_m - other.y_m)
    }
}

impl std::ops::Mul<f64> for Point2 {
    type Output = Self;
    #[inline]
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
#[cfg_attr(
    feature = "pod",
    derive(
        bytemuck::Pod,
        bytemuck::Zeroable,
        serde::Serialize,
        serde::Deserialize
    )
)]
#[repr(C)]
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
    #[inline]
    pub const fn new(x_m: f64, y_m: f64, theta_rad: f64) -> Self {
        Self {
            x_m,
            y_m,
            theta_rad,
        }
    }

    /// Where the origin of the inner frame lies.
    #[must_use]
    #[inline]
    pub const fn position(self) -> Point2 {
        Point2::new(self.x_m, self.y_m)
    }

    /// `self ∘ inner`: the pose, in the outer frame, of a pose given in this one.
    #[must_use]
    #[inline]
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
    #[inline]
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
    #[inline]
    pub fn between(self, other: Self) -> Self {
        self.inverse().compose(other)
    }

    /// A point of the inner frame, in the outer one.
    #[must_use]
    #[inline]
    pub fn transform(self, point: Point2) -> Point2 {
        self.position() + self.rotate(point)
    }

    /// The same for many points, with one sine and cosine for all.
    #[inline]
    pub fn transformation(self) -> impl Fn(Point2) -> Point2 + Copy {
        let (sin, cos) = self.theta_rad.sin_cos();
        move |point| {
            self.position()
                + Point2::new(
                    cos * point.x_m - sin * point.y_m,
                    sin * point.x_m + cos * point.y_m,
                )
        }
    }

    /// A point of the outer frame, in the inner one.
    #[must_use]
    #[inline]
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
    #[inline]
    pub fn rotate(self, vector: Point2) -> Point2 {
        let (sin, cos) = self.theta_rad.sin_cos();
        Point2::new(
            cos * vector.x_m - sin * vector.y_m,
            sin * vector.x_m + cos * vector.y_m,
        )
    }

    /// This pose after moving with a constant twist for a time.
    #[must_use]
    #[inline]
    pub fn advance(self, twist: Twist2, duration_s: f64) -> Self {
        self.compose(twist.displacement(duration_s))
    }

    /// The pose `fraction` of the way to `other`: straight in position, the short way round in angle.
    #[must_use]
    #[inline]
    pub fn interpolate(self, other: Self, fraction: f64) -> Self {
        Self::new(
            self.x_m + fraction * (other.x_m - self.x_m),
            self.y_m + fraction * (other.y_m - self.y_m),
            wrap_angle(self.theta_rad + fraction * wrap_angle(other.theta_rad - self.theta_rad)),
        )
    }

    /// All three numbers are finite.
    #[must_use]
    #[inline]
    pub fn is_finite(self) -> bool {
        self.x_m.is_finite() && self.y_m.is_finite() && self.theta_rad.is_finite()
    }
}

/// Speed along x and turning speed of `base_link`; the fixed axle allows no speed along y.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "pod",
    derive(
        bytemuck::Pod,
        bytemuck::Zeroable,
        serde::Serialize,
        serde::Deserialize
    )
)]
#[repr(C)]
pub struct Twist2 {
    /// Forward speed.
    pub v_m_s: f64,
    /// Turning speed, positive to the left.
    pub omega_rad_s: f64,
}

impl Twist2 {
    /// A twist from its two numbers.
    #[must_use]
    #[inline]
    pub const fn new(v_m_s: f64, omega_rad_s: f64) -> Self {
        Self { v_m_s, omega_rad_s }
    }

    /// The pose reached from the origin after moving with this twist for a time: an arc, or a straight line.
    #[must_use]
    #[inline]
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
    #[inline]
    pub fn is_finite(self) -> bool {
        self.v_m_s.is_finite() && self.omega_rad_s.is_finite()
    }
}

/// What a controller asks of the base: a speed along a path of constant curvature.
///
/// The path, not the turning speed, is the intention: a command that is slowed down still follows the same curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "pod",
    derive(bytemuck::Pod, bytemuck::Zeroable, serde::Serialize)
)]
#[repr(C)]
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
    #[inline]
    pub const fn new(speed_m_s: f64, curvature_1_m: f64) -> Self {
        Self {
            speed_m_s,
            curvature_1_m,
        }
    }

    /// The twist that drives it.
    #[must_use]
    #[inline]
    pub fn twist(self) -> Twist2 {
        Twist2::new(self.speed_m_s, self.speed_m_s * self.curvature_1_m)
    }

    /// The same path at another speed.
    #[must_use]
    #[inline]
    pub fn with_speed(self, speed_m_s: f64) -> Self {
        Self { speed_m_s, ..self }
    }

    /// Both numbers are finite.
    #[must_use]
    #[inline]
    pub fn is_finite(self) -> bool {
        self.speed_m_s.is_finite() && self.curvature_1_m.is_finite()
    }
}
