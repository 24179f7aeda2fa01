//! What is put onto the floor beside robots.

use sim::world::World;

/// People, boxes and clones come no nearer than this to a robot: to its `base_link`.
const APART_M: f64 = 1.0;

/// Whether a robot, or a clone, is near a place.
pub(super) fn is_near_a_robot(world: &World, [x_m, y_m]: [f64; 2]) -> bool {
    { (0..).map_while(|number| world.truth(number)) }
        .any(|truth| (truth.pose.x_m - x_m).hypot(truth.pose.y_m - y_m) < APART_M)
}
