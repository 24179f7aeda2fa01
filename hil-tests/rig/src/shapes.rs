//! What the users' files describe, as shapes of the simulated world.

use config::RobotConfig;
use description::geometry::Rect;
use description::site::Wall;
use sim::world::{Footprint, Rectangle, Segment};

/// A region of the floor.
#[must_use]
pub fn region(rect: &Rect) -> Rectangle {
    let [low, high] = [rect.min.xy_m(), rect.max.xy_m()];
    Rectangle {
        corners_m: [high, [low[0], high[1]], low, [high[0], low[1]]],
    }
}

/// Two floors touch or overlap. Bounding boxes that are apart rule that out at little cost: it is asked of all areas at each look.
#[must_use]
pub fn touch(one: &Rectangle, other: &Rectangle) -> bool {
    let are_apart = (0..2).any(|axis| {
        let [(least, most), (other_least, other_most)] = [one, other].map(|rectangle| {
            let along_m = { rectangle.corners_m.iter() }.map(|corner_m| corner_m[axis]);
            along_m.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), at_m| {
                (least.min(at_m), most.max(at_m))
            })
        });
        most < other_least || other_most < least
    });
    !are_apart && one.distance_to_rectangle_m(other) <= 0.0
}

/// A wall.
#[must_use]
pub fn segment(wall: &Wall) -> Segment {
    Segment::new(wall.line.a.xy_m(), wall.line.b.xy_m())
}

/// A robot's outline.
#[must_use]
pub fn footprint(robot: &RobotConfig) -> Footprint {
    let own = &robot.footprint;
    Footprint {
        front_m: own.front_m,
        rear_m: own.rear_m,
        left_m: own.left_m,
        right_m: own.right_m,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::world::Pose;
    use std::f64::consts::FRAC_PI_4;

    #[test]
    fn only_what_touches_touches() {
        let at =
            |x_m, y_m, turned_rad| Rectangle::centred(&Pose::new(x_m, y_m, turned_rad), 1.0, 1.0);
        let square = at(0.0, 0.0, 0.0);
        for touching in [
            at(0.9, 0.9, 0.0),
            at(1.0, 0.3, 0.0),
            at(0.0, 0.0, FRAC_PI_4),
        ] {
            assert!(touch(&square, &touching) && touch(&touching, &square));
        }
        // Of the second only the bounding box touches.
        for apart in [
            at(0.0, -1.1, 0.0),
            at(1.0, 1.0, FRAC_PI_4),
            at(3.0, 3.0, 1.0),
        ] {
            assert!(!touch(&square, &apart) && !touch(&apart, &square));
        }
    }

    #[test]
    fn regions_are_rectangles_with_an_inside() {
        let rectangle = region(&Rect::new([1.0, 2.0].into(), [3.0, 5.0].into()));
        assert!(rectangle.contains([2.0, 3.0]) && !rectangle.contains([0.9, 3.0]));
    }
}
