//! The robot's outline, segments and rectangles.

use super::motion::{Point2, Pose2};
use crate::keys::Quantity;
use crate::section;

const SIDE: Quantity = Quantity::new("a length", "m").above(0.0).at_most(5.0);

section! {
    /// The robot's outline: a rectangle given by its distances from `base_link`, all positive.
    #[derive(Copy)]
    pub struct Footprint {
        /// From `base_link` to the front edge.
        pub front_m: f64 as SIDE,
        /// From `base_link` to the rear edge.
        pub rear_m: f64 as SIDE,
        /// From `base_link` to the left edge.
        pub left_m: f64 as SIDE,
        /// From `base_link` to the right edge.
        pub right_m: f64 as SIDE,
    }
}

impl Footprint {
    /// The corners: front left, rear left, rear right, front right.
    #[must_use]
    #[inline]
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
    #[inline]
    pub fn length_m(&self) -> f64 {
        self.front_m + self.rear_m
    }

    /// Left to right.
    #[must_use]
    #[inline]
    pub fn width_m(&self) -> f64 {
        self.left_m + self.right_m
    }

    /// Distance from `base_link` to the farthest corner.
    #[must_use]
    #[inline]
    pub fn radius_m(&self) -> f64 {
        self.front_m
            .max(self.rear_m)
            .hypot(self.left_m.max(self.right_m))
    }

    /// The outline moved outwards by a margin.
    #[must_use]
    #[inline]
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
    #[inline]
    pub fn contains(&self, point: Point2) -> bool {
        point.x_m >= -self.rear_m
            && point.x_m <= self.front_m
            && point.y_m >= -self.right_m
            && point.y_m <= self.left_m
    }

    /// Between the outline at a pose and a region that it does not touch.
    #[must_use]
    pub fn gap_m(&self, pose: Pose2, region: &Rect) -> f64 {
        let ours = { self.corners() }.map(|corner| region.distance_m(pose.transform(corner)));
        let (min, max) = (region.min, region.max);
        let [right, left] =
            [(max.x_m, min.y_m), (min.x_m, max.y_m)].map(|(x, y)| Point2::new(x, y));
        let theirs =
            [min, right, max, left].map(|corner| self.distance_m(pose.inverse_transform(corner)));
        ours.into_iter().chain(theirs).fold(f64::INFINITY, f64::min)
    }

    /// Distance of a point, in `base_link`, from the outline; 0 inside.
    #[must_use]
    #[inline]
    pub fn distance_m(&self, point: Point2) -> f64 {
        self.as_rect().distance_m(point)
    }

    /// The outline as a rectangle of `base_link`.
    #[must_use]
    #[inline]
    pub fn as_rect(&self) -> Rect {
        Rect {
            min: Point2::new(-self.rear_m, -self.right_m),
            max: Point2::new(self.front_m, self.left_m),
        }
    }

    /// All four distances are finite and positive.
    #[must_use]
    #[inline]
    pub fn is_valid(&self) -> bool {
        [self.front_m, self.rear_m, self.left_m, self.right_m]
            .iter()
            .all(|side_m| side_m.is_finite() && *side_m > 0.0)
    }
}

/// A directed straight segment from `a` to `b`: a wall, or the centre line of a lane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "pod", derive(bytemuck::Pod, bytemuck::Zeroable))]
#[repr(C)]
pub struct Segment {
    /// Where it starts.
    pub a: Point2,
    /// Where it ends.
    pub b: Point2,
}

impl Segment {
    /// The segment from `a` to `b`.
    #[must_use]
    #[inline]
    pub const fn new(a: Point2, b: Point2) -> Self {
        Self { a, b }
    }

    /// From start to end.
    #[must_use]
    #[inline]
    pub fn length_m(&self) -> f64 {
        self.a.distance_m(self.b)
    }

    /// The direction from start to end.
    #[must_use]
    #[inline]
    pub fn direction_rad(&self) -> f64 {
        (self.b - self.a).direction_rad()
    }

    /// The unit vector from start to end; zero when both coincide.
    #[must_use]
    #[inline]
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
    #[inline]
    pub fn along_m(&self, point: Point2) -> f64 {
        (point - self.a).dot(self.unit())
    }

    /// Distance of `point` from the infinite line, positive to the left of its direction.
    #[must_use]
    #[inline]
    pub fn lateral_m(&self, point: Point2) -> f64 {
        self.unit().cross(point - self.a)
    }

    /// The point of the segment closest to `point`.
    #[must_use]
    #[inline]
    pub fn closest_point(&self, point: Point2) -> Point2 {
        let along_m = self.along_m(point).clamp(0.0, self.length_m());
        self.a + self.unit() * along_m
    }

    /// Distance of `point` from the segment.
    #[must_use]
    #[inline]
    pub fn distance_m(&self, point: Point2) -> f64 {
        self.closest_point(point).distance_m(point)
    }

    /// Whether two segments touch or cross.
    #[must_use]
    pub fn meets(&self, other: &Self) -> bool {
        const TOUCH_M: f64 = 1e-9;
        let side = |line: &Self, point: Point2| (line.b - line.a).cross(point - line.a);
        let parts = |line: &Self, other: &Self| side(line, other.a) * side(line, other.b) < 0.0;
        let touches = |line: &Self, point: Point2| line.distance_m(point) < TOUCH_M;
        (parts(self, other) && parts(other, self))
            || [self.a, self.b].iter().any(|&point| touches(other, point))
            || [other.a, other.b].iter().any(|&point| touches(self, point))
    }

    /// How far a ray from `origin` along `direction_rad` travels until it meets the segment.
    #[must_use]
    #[inline]
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
    #[inline]
    pub fn seen_from(&self, pose: Pose2) -> Self {
        Self::new(
            pose.inverse_transform(self.a),
            pose.inverse_transform(self.b),
        )
    }
}

/// A rectangle with its sides along the axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "pod", derive(bytemuck::Pod, bytemuck::Zeroable))]
#[repr(C)]
pub struct Rect {
    /// The corner with the smaller coordinates.
    pub min: Point2,
    /// The corner with the larger coordinates.
    pub max: Point2,
}

impl Rect {
    /// The rectangle that two opposite corners span, in any order.
    #[must_use]
    #[inline]
    pub fn new(one: Point2, other: Point2) -> Self {
        Self {
            min: Point2::new(one.x_m.min(other.x_m), one.y_m.min(other.y_m)),
            max: Point2::new(one.x_m.max(other.x_m), one.y_m.max(other.y_m)),
        }
    }

    /// Whether a point lies inside or on the border.
    #[must_use]
    #[inline]
    pub fn contains(&self, point: Point2) -> bool {
        point.x_m >= self.min.x_m
            && point.x_m <= self.max.x_m
            && point.y_m >= self.min.y_m
            && point.y_m <= self.max.y_m
    }

    /// Distance of a point from the rectangle; 0 inside.
    #[must_use]
    #[inline]
    pub fn distance_m(&self, point: Point2) -> f64 {
        let dx_m = (self.min.x_m - point.x_m)
            .max(point.x_m - self.max.x_m)
            .max(0.0);
        let dy_m = (self.min.y_m - point.y_m)
            .max(point.y_m - self.max.y_m)
            .max(0.0);
        Point2::new(dx_m, dy_m).norm_m()
    }

    /// The rectangle moved outwards by a margin; a negative one moves it inwards, until it [is empty](Self::is_empty).
    #[must_use]
    pub fn grown(&self, margin_m: f64) -> Self {
        let margin = Point2::new(margin_m, margin_m);
        Self {
            min: self.min - margin,
            max: self.max + margin,
        }
    }

    /// Whether nothing is left of it.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.min.x_m >= self.max.x_m || self.min.y_m >= self.max.y_m
    }

    /// Whether the two share more than a border; slivers under 1 mm do not count.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        const SLIVER_M: f64 = 1e-3;
        let share = |low: f64, other_low: f64, high: f64, other_high: f64| {
            high.min(other_high) - low.max(other_low) > SLIVER_M
        };
        share(self.min.x_m, other.min.x_m, self.max.x_m, other.max.x_m)
            && share(self.min.y_m, other.min.y_m, self.max.y_m, other.max.y_m)
    }

    /// The part of the segment inside the rectangle, as shares of it: 0 at its start, 1 at its end.
    #[must_use]
    pub fn clip(&self, line: &Segment) -> Option<(f64, f64)> {
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        let (min, max) = (self.min.xy_m(), self.max.xy_m());
        let (from, to) = (line.a.xy_m(), line.b.xy_m());
        for axis in 0..2 {
            let delta = to[axis] - from[axis];
            let (low, high) = (min[axis] - from[axis], max[axis] - from[axis]);
            if delta == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let (first, second) = (low / delta, high / delta);
            enter = enter.max(first.min(second));
            leave = leave.min(first.max(second));
        }
        (enter <= leave).then_some((enter, leave))
    }

    /// The middle.
    #[must_use]
    #[inline]
    pub fn centre(&self) -> Point2 {
        (self.min + self.max) * 0.5
    }
}
