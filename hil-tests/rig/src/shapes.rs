//! What the users' files describe, as shapes of the simulated world.

use config::{Rect, RobotConfig, Wall};
use sim::world::{Footprint, Rectangle, Segment};

/// A region of the floor.
#[must_use]
pub fn region(rect: &Rect) -> Rectangle {
    let [low, high] = [rect.min_m, rect.max_m];
    Rectangle {
        corners_m: [high, [low[0], high[1]], low, [high[0], low[1]]],
    }
}

/// A wall.
#[must_use]
pub fn segment(wall: &Wall) -> Segment {
    Segment::new(wall.from_m, wall.to_m)
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
        let rectangle = region(&Rect {
            min_m: [1.0, 2.0],
            max_m: [3.0, 5.0],
        });
        assert!(rectangle.contains([2.0, 3.0]) && !rectangle.contains([0.9, 3.0]));
    }
}
