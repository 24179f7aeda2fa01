//! Plane geometry of the world: poses, segments, footprints, distances. Metres and radians in the `map` frame.

/// A point or vector.
pub type Point = [f64; 2];

/// Position and heading.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pose {
    /// East.
    pub x_m: f64,
    /// North.
    pub y_m: f64,
    /// Heading, counter-clockwise from east; not wrapped.
    pub theta_rad: f64,
}

impl Pose {
    /// A pose from its three numbers.
    #[must_use]
    pub const fn new(x_m: f64, y_m: f64, theta_rad: f64) -> Pose {
        Pose {
            x_m,
            y_m,
            theta_rad,
        }
    }

    /// The pose of something mounted at `local` on this.
    #[must_use]
    pub fn compose(&self, local: &Pose) -> Pose {
        let [x_m, y_m] = self.transform([local.x_m, local.y_m]);
        Pose::new(x_m, y_m, self.theta_rad + local.theta_rad)
    }

    /// A point given in this frame, in the frame this pose is given in.
    #[must_use]
    pub fn transform(&self, point: Point) -> Point {
        self.transform_all([point])[0]
    }

    /// Several points, for one sine and cosine.
    pub(super) fn transform_all<const N: usize>(&self, points: [Point; N]) -> [Point; N] {
        let (sin, cos) = self.theta_rad.sin_cos();
        points.map(|[x, y]| [self.x_m + cos * x - sin * y, self.y_m + sin * x + cos * y])
    }

    /// Between this pose (`share` 0) and `other` (1); headings are not wrapped, so neither is the result.
    #[must_use]
    pub fn interpolate(&self, other: &Pose, share: f64) -> Pose {
        let mix = |a: f64, b: f64| a + (b - a) * share;
        Pose::new(
            mix(self.x_m, other.x_m),
            mix(self.y_m, other.y_m),
            mix(self.theta_rad, other.theta_rad),
        )
    }

    /// Every number is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.x_m.is_finite() && self.y_m.is_finite() && self.theta_rad.is_finite()
    }
}

/// Speed of `base_link` along its heading, and rate of turn.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Twist {
    /// Forward speed.
    pub v_m_s: f64,
    /// Yaw rate, counter-clockwise positive.
    pub omega_rad_s: f64,
}

/// A straight piece of wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// One end.
    pub from_m: Point,
    /// The other end.
    pub to_m: Point,
}

impl Segment {
    /// A segment between two points.
    #[must_use]
    pub const fn new(from_m: Point, to_m: Point) -> Segment {
        Segment { from_m, to_m }
    }

    /// The segment moved by a vector.
    #[must_use]
    pub fn moved(&self, by_m: Point) -> Segment {
        Segment::new(add(self.from_m, by_m), add(self.to_m, by_m))
    }

    /// Distance to a point.
    #[must_use]
    pub fn distance_to_point_m(&self, point: Point) -> f64 {
        let along = sub(self.to_m, self.from_m);
        let length_squared = dot(along, along);
        let to_point = sub(point, self.from_m);
        let share = if length_squared > 0.0 {
            (dot(to_point, along) / length_squared).clamp(0.0, 1.0)
        } else {
            0.0
        };
        norm(sub(to_point, [along[0] * share, along[1] * share]))
    }

    /// Whether the bounding box is further than `than_m` from a point: a cheap test that rules out most walls.
    pub(super) fn is_further_m(&self, point: Point, than_m: f64) -> bool {
        (0..2).any(|axis| {
            let (a, b, p) = (self.from_m[axis], self.to_m[axis], point[axis]);
            a.min(b) - p > than_m || p - a.max(b) > than_m
        })
    }

    /// Distance to another segment, 0 where they cross.
    #[must_use]
    pub fn distance_to_segment_m(&self, other: &Segment) -> f64 {
        if self.crosses(other) {
            return 0.0;
        }
        self.distance_to_point_m(other.from_m)
            .min(self.distance_to_point_m(other.to_m))
            .min(other.distance_to_point_m(self.from_m))
            .min(other.distance_to_point_m(self.to_m))
    }

    /// The two cross in a point inside both; mere touching is left to the distances of the ends.
    fn crosses(&self, other: &Segment) -> bool {
        let side = |s: &Segment, p: Point| cross(sub(s.to_m, s.from_m), sub(p, s.from_m));
        side(self, other.from_m) * side(self, other.to_m) < 0.0
            && side(other, self.from_m) * side(other, self.to_m) < 0.0
    }

    /// How far a ray from `origin` along the unit vector `direction` travels until it hits.
    #[must_use]
    pub fn ray_hit_m(&self, origin: Point, direction: Point) -> Option<f64> {
        self.seen_from(origin).ray_hit_m(direction)
    }

    /// How it lies to a point from which several rays leave.
    pub(super) fn seen_from(&self, origin: Point) -> SeenSegment {
        let (along, to_start) = (sub(self.to_m, self.from_m), sub(self.from_m, origin));
        SeenSegment {
            along,
            to_start,
            area: cross(to_start, along),
        }
    }
}

/// A segment as it is seen from a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenSegment {
    along: Point,
    to_start: Point,
    /// Twice that of the triangle between the point and the segment.
    area: f64,
}

impl SeenSegment {
    /// How far a ray along a unit vector travels until it hits.
    #[inline]
    pub(super) fn ray_hit_m(&self, direction: Point) -> Option<f64> {
        let denominator = cross(direction, self.along);
        let numerator = cross(self.to_start, direction);
        // Their quotient, how far along the segment it hits, is between 0 and 1: known without a division.
        let inside = numerator.abs() <= denominator.abs()
            && (numerator == 0.0 || (numerator < 0.0) == (denominator < 0.0));
        if !inside || denominator == 0.0 {
            return None;
        }
        let distance = self.area / denominator;
        (distance >= 0.0).then_some(distance)
    }

    /// Both ends are on the left (+1) or right (−1) of a ray.
    pub(super) fn is_beside(&self, direction: Point, side: f64) -> bool {
        side * cross(direction, self.to_start) > 0.0
            && side * cross(direction, add(self.to_start, self.along)) > 0.0
    }
}

/// How far a ray travels until it enters the disc; 0 from inside.
#[must_use]
pub fn ray_hit_disc_m(
    centre_m: Point,
    radius_m: f64,
    origin: Point,
    direction: Point,
) -> Option<f64> {
    let to_centre = sub(centre_m, origin);
    let outside = dot(to_centre, to_centre) - radius_m * radius_m;
    if outside <= 0.0 {
        return Some(0.0);
    }
    let along = dot(to_centre, direction);
    let discriminant = along * along - outside;
    (along > 0.0 && discriminant >= 0.0).then(|| along - discriminant.sqrt())
}

/// The rectangle a robot covers, measured from `base_link`; all four are positive outwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footprint {
    /// To the front edge.
    pub front_m: f64,
    /// To the rear edge.
    pub rear_m: f64,
    /// To the left edge.
    pub left_m: f64,
    /// To the right edge.
    pub right_m: f64,
}

impl Footprint {
    /// The footprint of something at `pose`.
    #[must_use]
    pub fn at(&self, pose: &Pose) -> Rectangle {
        Rectangle {
            corners_m: pose.transform_all([
                [self.front_m, self.left_m],
                [-self.rear_m, self.left_m],
                [-self.rear_m, -self.right_m],
                [self.front_m, -self.right_m],
            ]),
        }
    }

    /// Radius of the smallest circle around `base_link` that holds the footprint.
    #[must_use]
    pub fn reach_m(&self) -> f64 {
        let x = self.front_m.abs().max(self.rear_m.abs());
        let y = self.left_m.abs().max(self.right_m.abs());
        x.hypot(y)
    }
}

/// A placed rectangle; corners in counter-clockwise order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    /// The four corners.
    pub corners_m: [Point; 4],
}

impl Rectangle {
    /// A rectangle of the given size centred on `pose`, its length along the heading.
    #[must_use]
    pub fn centred(pose: &Pose, length_m: f64, width_m: f64) -> Rectangle {
        let (x, y) = (0.5 * length_m, 0.5 * width_m);
        Footprint {
            front_m: x,
            rear_m: x,
            left_m: y,
            right_m: y,
        }
        .at(pose)
    }

    /// Its four edges.
    #[must_use]
    pub fn edges(&self) -> [Segment; 4] {
        let c = &self.corners_m;
        std::array::from_fn(|i| Segment::new(c[i], c[(i + 1) % 4]))
    }

    /// The point is inside or on the border.
    #[must_use]
    pub fn contains(&self, point: Point) -> bool {
        self.edges()
            .iter()
            .all(|e| cross(sub(e.to_m, e.from_m), sub(point, e.from_m)) >= 0.0)
    }

    /// Distance to a segment, 0 where it touches or lies inside.
    pub fn distance_to_segment_m(&self, segment: &Segment) -> f64 {
        if self.contains(segment.from_m) || self.contains(segment.to_m) {
            return 0.0;
        }
        self.edges()
            .iter()
            .map(|edge| edge.distance_to_segment_m(segment))
            .fold(f64::INFINITY, f64::min)
    }

    /// Distance to a disc, 0 where they touch or overlap.
    pub fn distance_to_disc_m(&self, centre_m: Point, radius_m: f64) -> f64 {
        if self.contains(centre_m) {
            return 0.0;
        }
        let nearest = self
            .edges()
            .iter()
            .map(|edge| edge.distance_to_point_m(centre_m))
            .fold(f64::INFINITY, f64::min);
        (nearest - radius_m).max(0.0)
    }

    /// Distance to another rectangle, 0 where they touch or overlap.
    pub fn distance_to_rectangle_m(&self, other: &Rectangle) -> f64 {
        if other.contains(self.corners_m[0]) {
            return 0.0;
        }
        other
            .edges()
            .iter()
            .map(|edge| self.distance_to_segment_m(edge))
            .fold(f64::INFINITY, f64::min)
    }
}

pub(crate) fn add(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1]]
}

pub(crate) fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

pub(crate) fn norm(a: Point) -> f64 {
    (a[0] * a[0] + a[1] * a[1]).sqrt()
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    const SQUARE: Footprint = Footprint {
        front_m: 0.5,
        rear_m: 0.5,
        left_m: 0.5,
        right_m: 0.5,
    };

    #[test]
    fn distances_of_a_unit_square() {
        let square = SQUARE.at(&Pose::default());
        let wall = Segment::new([1.5, -3.0], [1.5, 3.0]);
        assert!((square.distance_to_segment_m(&wall) - 1.0).abs() < 1e-12);
        let corner = Segment::new([0.5, 1.5], [1.5, 0.5]);
        assert!((square.distance_to_segment_m(&corner) - 0.5f64.sqrt()).abs() < 1e-12);
        let through = Segment::new([-2.0, 0.1], [2.0, 0.2]);
        assert_eq!(square.distance_to_segment_m(&through), 0.0);
        let inside = Segment::new([-0.1, 0.1], [0.1, 0.2]);
        assert_eq!(square.distance_to_segment_m(&inside), 0.0);
        assert!((square.distance_to_disc_m([2.0, 0.0], 0.5) - 1.0).abs() < 1e-12);
        assert_eq!(square.distance_to_disc_m([0.2, 0.0], 0.01), 0.0);
        let other = SQUARE.at(&Pose::new(2.0, 0.0, FRAC_PI_2));
        assert!((square.distance_to_rectangle_m(&other) - 1.0).abs() < 1e-12);
        let around = Rectangle::centred(&Pose::default(), 10.0, 10.0);
        assert_eq!(square.distance_to_rectangle_m(&around), 0.0);
        assert_eq!(around.distance_to_rectangle_m(&square), 0.0);
    }

    #[test]
    fn rays_are_exact() {
        let wall = Segment::new([3.0, -1.0], [3.0, 1.0]);
        assert_eq!(wall.ray_hit_m([0.0, 0.0], [1.0, 0.0]), Some(3.0));
        assert_eq!(wall.ray_hit_m([0.0, 0.0], [-1.0, 0.0]), None);
        assert_eq!(wall.ray_hit_m([0.0, 2.0], [1.0, 0.0]), None);
        let diagonal = std::f64::consts::FRAC_1_SQRT_2;
        let hit = wall.ray_hit_m([2.5, 0.0], [diagonal, diagonal]).unwrap();
        assert!((hit - 0.5 * 2.0f64.sqrt()).abs() < 1e-12);
        assert_eq!(
            ray_hit_disc_m([5.0, 0.0], 1.0, [0.0, 0.0], [1.0, 0.0]),
            Some(4.0)
        );
        assert_eq!(
            ray_hit_disc_m([5.0, 0.0], 1.0, [0.0, 0.0], [-1.0, 0.0]),
            None
        );
        assert_eq!(
            ray_hit_disc_m([0.5, 0.0], 1.0, [0.0, 0.0], [1.0, 0.0]),
            Some(0.0)
        );
    }

    #[test]
    fn compose_is_a_rigid_motion() {
        let mounted = Pose::new(1.0, 2.0, FRAC_PI_2).compose(&Pose::new(0.28, 0.0, 0.1));
        assert!((mounted.x_m - 1.0).abs() < 1e-12 && (mounted.y_m - 2.28).abs() < 1e-12);
        assert!((mounted.theta_rad - FRAC_PI_2 - 0.1).abs() < 1e-12);
    }
}
