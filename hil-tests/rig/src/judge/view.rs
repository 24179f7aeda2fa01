//! Which walls of a map a lidar can see, by the world's truth.

use config::SiteConfig;
use description::site::Wall;
use sim::world::{Point, Pose, Rectangle, Segment, Shape, World, ray_hit_disc_m};

use crate::shapes::segment;

/// The view of a URG-04LX.
const HALF_VIEW_RAD: f64 = 2.09;
const STEP_RAD: f64 = 0.025;
const REACH_M: f64 = 4.0;
/// A wall is in view when at least `LEAST_RAYS` of these rays (a quarter of a radian, forty beams) meet it, over at least
/// `LEAST_LENGTH_M`: with less, at the end of the reach, the noise of ranges is as large as what is asked for.
const LEAST_RAYS: usize = 10;
const LEAST_LENGTH_M: f64 = 0.8;

/// Everything that can stop a ray, collected once for each look.
#[derive(Debug, Default)]
pub struct Scenery {
    segments: Vec<Segment>,
    discs: Vec<(Point, f64)>,
}

impl Scenery {
    /// Obstacles and other robots as they are now.
    #[must_use]
    pub fn of(world: &World, robot: usize) -> Self {
        let mut scenery = Self::default();
        for (_, shape) in world.obstacles() {
            match shape {
                Shape::Wall(segment) => scenery.segments.push(segment),
                Shape::Disc { centre_m, radius_m } => scenery.discs.push((centre_m, radius_m)),
                Shape::Box {
                    pose,
                    length_m,
                    width_m,
                } => scenery
                    .segments
                    .extend(Rectangle::centred(&pose, length_m, width_m).edges()),
            }
        }
        for (index, model) in world.models().enumerate() {
            if let Some(truth) = world.truth(index).filter(|_| index != robot) {
                scenery
                    .segments
                    .extend(model.footprint.at(&truth.pose).edges());
            }
        }
        scenery
    }

    fn reach_m(&self, from: Point, direction: Point) -> f64 {
        let walls = self
            .segments
            .iter()
            .filter_map(|segment| segment.ray_hit_m(from, direction));
        let discs = self
            .discs
            .iter()
            .filter_map(|(centre, radius_m)| ray_hit_disc_m(*centre, *radius_m, from, direction));
        walls.chain(discs).fold(f64::INFINITY, f64::min)
    }
}

/// For each wall of the site, whether it is in view of a lidar at `lidar`.
#[must_use]
pub fn walls_in_view(site: &SiteConfig, scenery: &Scenery, lidar: &Pose) -> Vec<bool> {
    let from = [lidar.x_m, lidar.y_m];
    let mut seen: Vec<Seen> = vec![Seen::default(); site.walls.len()];
    let rays = (2.0 * HALF_VIEW_RAD / STEP_RAD) as usize;
    let (step_sin, step_cos) = STEP_RAD.sin_cos();
    let (sin, cos) = (lidar.theta_rad - HALF_VIEW_RAD - STEP_RAD).sin_cos();
    let mut direction = [cos, sin];
    for _ in 0..=rays {
        let [x, y] = direction;
        direction = [step_cos * x - step_sin * y, step_sin * x + step_cos * y];
        let reach_m = scenery.reach_m(from, direction);
        if reach_m > REACH_M {
            continue;
        }
        for (wall, seen) in site.walls.iter().zip(&mut seen) {
            let hit_m = segment(wall).ray_hit_m(from, direction);
            if hit_m.is_some_and(|hit_m| (hit_m - reach_m).abs() < 1e-6) {
                seen.add([
                    from[0] + direction[0] * reach_m,
                    from[1] + direction[1] * reach_m,
                ]);
            }
        }
    }
    seen.iter().map(Seen::is_enough).collect()
}

/// Unit vector across a wall.
#[must_use]
pub fn normal(wall: &Wall) -> Point {
    let along = wall.line.unit();
    [-along.y_m, along.x_m]
}

#[derive(Clone, Debug, Default)]
struct Seen {
    rays: usize,
    first: Option<Point>,
    length_m: f64,
}

impl Seen {
    fn add(&mut self, at: Point) {
        self.rays += 1;
        let first = *self.first.get_or_insert(at);
        let length_m = (at[0] - first[0]).hypot(at[1] - first[1]);
        self.length_m = self.length_m.max(length_m);
    }

    fn is_enough(&self) -> bool {
        self.rays >= LEAST_RAYS && self.length_m >= LEAST_LENGTH_M
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::world::{Obstacle, WorldConfig};

    #[test]
    fn what_is_far_or_hidden_is_not_in_view() {
        let site = crate::testing::site("corridor");
        let walls = |obstacles: Vec<Obstacle>| {
            let mut all: Vec<Obstacle> = site
                .walls
                .iter()
                .map(|wall| Obstacle::wall(wall.line.a.xy_m(), wall.line.b.xy_m()))
                .collect();
            all.extend(obstacles);
            World::new(WorldConfig {
                obstacles: all,
                ..WorldConfig::default()
            })
            .expect("a world")
        };
        let names = |world: &World, x_m: f64| -> Vec<&str> {
            let scenery = Scenery::of(world, 0);
            let view = walls_in_view(&site, &scenery, &Pose::new(x_m, -0.5, 0.0));
            let seen = site.walls.iter().zip(view).filter(|(_, seen)| *seen);
            seen.map(|(wall, _)| wall.id.as_str()).collect()
        };
        let open = walls(vec![]);
        assert_eq!(names(&open, 3.0), ["south", "north"]);
        assert_eq!(names(&open, 7.0), ["south", "north", "east"]);
        let screen = walls(vec![Obstacle::wall([8.0, -1.5], [8.0, 1.5])]);
        assert_eq!(names(&screen, 7.0), ["south", "north"]);
    }
}
