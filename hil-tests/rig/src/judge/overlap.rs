//! How deep a robot is in an area, or how far from it.

use description::geometry::Rect;
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
            let smaller = area.grown(-middle_m);
            if smaller.is_empty() || floor.distance_to_rectangle_m(&region(&smaller)) > 0.0 {
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
        let area = Rect::new([2.0, -1.0].into(), [4.0, 1.0].into());
        let at = |x_m: f64| Overlap::of(&body.at(&Pose::new(x_m, 0.0, 0.0)), &area);
        let before = at(1.5);
        assert!((before.distance_m - 0.18).abs() < 1e-9 && before.depth_m == 0.0);
        let inside = at(1.78);
        assert!((inside.depth_m - 0.10).abs() < 1e-3 && inside.distance_m == 0.0);
    }
}
