//! Puts boxes, people and vehicles into a world, as a scenario asks for and the seed draws them.

use sim::world::{
    Body, Obstacle, Point, Pose, Random, Rectangle, Route, Segment, Shape, Walker, World,
    WorldError,
};

use crate::scenario::{Boxes, Clutter};

const CLUTTER_STREAM: u64 = 0x434C_5554;

/// Puts what the site file does not know into the world, before its clock starts.
///
/// # Errors
/// [`WorldError`] naming what makes no sense.
pub fn furnish(world: &mut World, clutter: &Clutter, seed: u64) -> Result<(), WorldError> {
    let mut random = Random::new(seed, CLUTTER_STREAM);
    let walls: Vec<Segment> = world
        .obstacles()
        .filter_map(|(_, shape)| match shape {
            Shape::Wall(wall) => Some(wall),
            _ => None,
        })
        .collect();
    for floor in boxes(&mut random, clutter, &walls) {
        world.add_obstacle(Obstacle::fixed(floor))?;
    }
    let people = &clutter.people;
    for _ in 0..people.count {
        let start_m = place(&mut random, clutter);
        let radius_m = between(&mut random, people.radius_m);
        world.add_walker(Walker {
            body: Body::Disc { radius_m },
            start_m,
            route: Route::Wander {
                min_m: clutter.min_m,
                max_m: clutter.max_m,
            },
            slowest_m_s: people.speed_m_s[0],
            fastest_m_s: people.speed_m_s[1],
            longest_rest_s: people.longest_rest_s,
            heed_m: people.heed_m,
            heed_behind_m: people.heed_behind_m,
        })?;
    }
    for vehicle in &clutter.vehicles {
        let speed_m_s = between(&mut random, vehicle.speed_m_s);
        world.add_walker(Walker {
            body: Body::Box {
                length_m: vehicle.length_m,
                width_m: vehicle.width_m,
            },
            start_m: vehicle.from_m,
            route: Route::Path(vec![vehicle.to_m]),
            slowest_m_s: speed_m_s,
            fastest_m_s: speed_m_s,
            longest_rest_s: 0.0,
            heed_m: vehicle.heed_m,
            heed_behind_m: vehicle.heed_m,
        })?;
    }
    Ok(())
}

fn between(random: &mut Random, [low, high]: [f64; 2]) -> f64 {
    low + random.unit() * (high - low)
}

fn place(random: &mut Random, clutter: &Clutter) -> Point {
    [0, 1].map(|axis| between(random, [clutter.min_m[axis], clutter.max_m[axis]]))
}

/// Random boxes that leave a way along the lane; boxes that would close it are drawn again.
fn boxes(random: &mut Random, clutter: &Clutter, walls: &[Segment]) -> Vec<Shape> {
    let [fewest, most] = clutter.boxes.count;
    let wanted = fewest + random.bits() % (most - fewest + 1);
    let mut boxes: Vec<Shape> = Vec::new();
    // A full floor gets fewer boxes: drawing must end.
    for _ in 0..400 {
        if boxes.len() as u64 == wanted {
            break;
        }
        let [x_m, y_m] = place(random, clutter);
        boxes.push(Shape::Box {
            pose: Pose::new(x_m, y_m, random.symmetric(std::f64::consts::PI)),
            length_m: between(random, clutter.boxes.side_m),
            width_m: between(random, clutter.boxes.side_m),
        });
        if !leaves_way(&boxes, clutter, walls) {
            boxes.pop();
        }
    }
    boxes
}

/// Whether a disc as wide as the way can move past all boxes, near the lane, without turning back.
fn leaves_way(boxes: &[Shape], clutter: &Clutter, walls: &[Segment]) -> bool {
    const STEP_M: f64 = 0.05;
    let Boxes {
        lane_y_m,
        beside_m,
        way_m,
        ..
    } = clutter.boxes;
    let (from_m, to_m) = (clutter.min_m[0], clutter.max_m[0]);
    let floors: Vec<Rectangle> = boxes
        .iter()
        .filter_map(|shape| match shape {
            Shape::Box {
                pose,
                length_m,
                width_m,
            } => Some(Rectangle::centred(pose, *length_m, *width_m)),
            _ => None,
        })
        .collect();
    let is_free = |at: Point| {
        floors
            .iter()
            .all(|floor| floor.distance_to_disc_m(at, 0.0) > way_m)
            && walls
                .iter()
                .all(|wall| wall.distance_to_point_m(at) > way_m)
    };
    let lanes = (2.0 * beside_m / STEP_M) as usize + 1;
    let y = |lane: usize| lane_y_m - beside_m + lane as f64 * STEP_M;
    let steps = ((to_m - from_m + 1.6) / STEP_M) as usize;
    let mut reached: Vec<bool> = vec![true; lanes];
    for step in 0..=steps {
        let x = from_m - 0.8 + step as f64 * STEP_M;
        let free: Vec<bool> = (0..lanes).map(|lane| is_free([x, y(lane)])).collect();
        // Sideways by at most half the way ahead: the tubes bend no more.
        let next = (0..lanes).map(|lane| {
            let near = lane.saturating_sub(1)..=(lane + 1).min(lanes - 1);
            let from = if step.is_multiple_of(2) {
                near
            } else {
                lane..=lane
            };
            free[lane] && from.into_iter().any(|other| reached[other])
        });
        reached = next.collect();
    }
    reached.contains(&true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::world::WorldConfig;

    fn clutter() -> Clutter {
        let scenario = crate::testing::scenario("clutter");
        scenario.clutter.expect("it has some")
    }

    fn corridor() -> Vec<Segment> {
        vec![
            Segment::new([0.0, -1.6], [10.0, -1.6]),
            Segment::new([0.0, 1.6], [10.0, 1.6]),
        ]
    }

    fn bin(x_m: f64, y_m: f64, width_m: f64) -> Shape {
        Shape::Box {
            pose: Pose::new(x_m, y_m, 0.0),
            length_m: 0.2,
            width_m,
        }
    }

    #[test]
    fn a_way_is_seen_and_a_closed_one_too() {
        assert!(leaves_way(&[], &clutter(), &corridor()));
        assert!(leaves_way(
            &[bin(5.0, -1.3, 0.4), bin(6.0, 0.8, 0.4)],
            &clutter(),
            &corridor()
        ));
        assert!(!leaves_way(&[bin(5.0, -0.5, 1.0)], &clutter(), &corridor()));
    }

    #[test]
    fn every_seed_gives_its_own_clutter_with_a_way_through() {
        let clutter = clutter();
        let (people, fewest) = (clutter.people.count, clutter.boxes.count[0]);
        let furnished = |seed: u64| {
            let mut world = World::new(WorldConfig {
                seed,
                obstacles: corridor()
                    .iter()
                    .map(|wall| Obstacle::wall(wall.from_m, wall.to_m))
                    .collect(),
                ..WorldConfig::default()
            })
            .expect("a world");
            furnish(&mut world, &clutter, seed).expect("furnished");
            world
                .obstacles()
                .map(|(_, shape)| shape)
                .collect::<Vec<_>>()
        };
        assert_eq!(furnished(1), furnished(1));
        assert_ne!(furnished(1), furnished(2));
        for seed in 0..50 {
            let shapes = furnished(seed);
            let discs = shapes
                .iter()
                .filter(|shape| matches!(shape, Shape::Disc { .. }));
            assert_eq!(discs.count() as u64, people);
            let boxes: Vec<Shape> = shapes
                .iter()
                .copied()
                .filter(|shape| matches!(shape, Shape::Box { .. }))
                .take(shapes.len() - 3 - people as usize)
                .collect();
            assert!(boxes.len() >= fewest as usize && leaves_way(&boxes, &clutter, &corridor()));
        }
    }
}
