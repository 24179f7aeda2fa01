//! How deep a robot is in an area, or how far from it.

use config::Rect;
use sim::world::Rectangle;

use crate::shapes::region;

/// Where a floor is relative to an area.
pub(super) struct Overlap {
    /// How deep the floor is in the area, or the area in the floor; 0 without contact.
    pub(super) depth_m: f64,
    /// How far apart they are; 0 in contact.
    pub(super) distance_m: f64,
}

impl Overlap {
    /// Of a floor and an area.
    pub(super) fn of(floor: &Rectangle, area: &Rect) -> Self {
        let distance_m = floor.distance_to_rectangle_m(&region(area));
        if distance_m > 0.0 {
            return Self {
                depth_m: 0.0,
                distance_m,
            };
        }
        // Shrinks the area until they part: exact to half a millimetre, and only in contact.
        let (mut low_m, mut high_m) = (0.0, 1.0);
        while high_m - low_m > 5e-4 {
            let middle_m: f64 = (low_m + high_m) / 2.0;
            let smaller = Rect {
                min_m: area.min_m.map(|value| value + middle_m),
                max_m: area.max_m.map(|value| value - middle_m),
            };
            let empty = (0..2).any(|axis| smaller.min_m[axis] >= smaller.max_m[axis]);
            if empty || floor.distance_to_rectangle_m(&region(&smaller)) > 0.0 {
                high_m = middle_m;
            } else {
                low_m = middle_m;
            }
        }
        Self {
            depth_m: low_m,
            distance_m: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::world::{Footprint, Pose};

    #[test]
    fn depth_and_distance_are_measured() {
        let body = Footprint {
            front_m: 0.32,
            rear_m: 0.08,
            left_m: 0.15,
            right_m: 0.15,
        };
        let area = Rect {
            min_m: [2.0, -1.0],
            max_m: [4.0, 1.0],
        };
        let at = |x_m: f64| Overlap::of(&body.at(&Pose::new(x_m, 0.0, 0.0)), &area);
        let before = at(1.5);
        assert!((before.distance_m - 0.18).abs() < 1e-9 && before.depth_m == 0.0);
        let inside = at(1.78);
        assert!((inside.depth_m - 0.10).abs() < 1e-3 && inside.distance_m == 0.0);
    }
}
