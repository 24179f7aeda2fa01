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

    #[test]
    fn regions_are_rectangles_with_an_inside() {
        let rectangle = region(&Rect::new([1.0, 2.0].into(), [3.0, 5.0].into()));
        assert!(rectangle.contains([2.0, 3.0]) && !rectangle.contains([0.9, 3.0]));
    }
}
