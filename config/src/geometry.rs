//! Poses and rectangles as files state them.

/// A pose in the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseConfig {
    /// Forward (in a robot's frame) or east (in `map`), metres.
    pub x_m: f64,
    /// Left (in a robot's frame) or north (in `map`), metres.
    pub y_m: f64,
    /// Counter-clockwise from the x axis, radians.
    pub theta_rad: f64,
}

/// A rectangle along the axes of `map`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rect {
    /// South-west corner (x, y), metres.
    pub min_m: [f64; 2],
    /// North-east corner (x, y), metres.
    pub max_m: [f64; 2],
}

impl Rect {
    /// Whether the point lies inside or on the border.
    pub fn contains(&self, point_m: [f64; 2]) -> bool {
        (0..2).all(|axis| point_m[axis] >= self.min_m[axis] && point_m[axis] <= self.max_m[axis])
    }

    /// Whether the two share more than a border; slivers under 1 mm do not count.
    pub fn overlaps(&self, other: &Rect) -> bool {
        const SLIVER_M: f64 = 1e-3;
        (0..2).all(|axis| {
            let low = self.min_m[axis].max(other.min_m[axis]);
            let high = self.max_m[axis].min(other.max_m[axis]);
            high - low > SLIVER_M
        })
    }

    /// The part of the segment inside the rectangle, as parameters along it
    /// (0 at `from`, 1 at `to`).
    pub(crate) fn clip(&self, from_m: [f64; 2], to_m: [f64; 2]) -> Option<(f64, f64)> {
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for axis in 0..2 {
            let delta = to_m[axis] - from_m[axis];
            let (low, high) = (
                self.min_m[axis] - from_m[axis],
                self.max_m[axis] - from_m[axis],
            );
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
}

/// Distance from a point to a segment, metres.
pub(crate) fn distance_to_segment(point_m: [f64; 2], from_m: [f64; 2], to_m: [f64; 2]) -> f64 {
    let (dx, dy) = (to_m[0] - from_m[0], to_m[1] - from_m[1]);
    let (px, py) = (point_m[0] - from_m[0], point_m[1] - from_m[1]);
    let length2 = dx * dx + dy * dy;
    let along = if length2 > 0.0 {
        ((px * dx + py * dy) / length2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (px - along * dx).hypot(py - along * dy)
}

/// Whether two segments touch or cross.
pub(crate) fn segments_meet(a: ([f64; 2], [f64; 2]), b: ([f64; 2], [f64; 2])) -> bool {
    fn side(p: [f64; 2], q: [f64; 2], r: [f64; 2]) -> f64 {
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    }
    let crosses = |p: ([f64; 2], [f64; 2]), q: ([f64; 2], [f64; 2])| {
        side(p.0, p.1, q.0) * side(p.0, p.1, q.1) < 0.0
    };
    (crosses(a, b) && crosses(b, a))
        || [a.0, a.1]
            .iter()
            .any(|&point| distance_to_segment(point, b.0, b.1) < 1e-9)
        || [b.0, b.1]
            .iter()
            .any(|&point| distance_to_segment(point, a.0, a.1) < 1e-9)
}
