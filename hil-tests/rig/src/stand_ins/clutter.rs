//! `clutter`: a corridor with boxes that no map knows, people who walk about, and another robot that comes the other way.

use config::{FsmConfig, SiteConfig};
use sim::world::{
    Body, Obstacle, Point, Pose, Random, Rectangle, Route, Segment, Shape, Truth, Walker, World,
    WorldError,
};

use crate::judge::Figures;
use crate::judge::Rules;
use crate::one_robot::trial::Scenario;

/// Boxes stand, and people walk, in this part of the corridor.
const FROM_M: Point = [3.4, -1.4];
const TO_M: Point = [8.0, 1.4];
/// Boxes: how many, and the size of a side.
const MOST_BOXES: u64 = 5;
const FEWEST_BOXES: u64 = 2;
const BOX_M: [f64; 2] = [0.10, 0.45];
/// People: how many, how big, how fast.
const PEOPLE: u64 = 2;
const PERSON_RADIUS_M: [f64; 2] = [0.15, 0.25];
const PERSON_M_S: [f64; 2] = [0.2, 1.0];
const LONGEST_REST_S: f64 = 3.0;
/// People do not walk into the back of a robot, which has no eyes there; those before and beside it see nothing.
const HEED_BEHIND_M: f64 = 0.5;
/// The other robot.
const OTHER_M_S: [f64; 2] = [0.2, 0.4];
const OTHER_HEEDS_M: f64 = 0.4;
/// Clear floor that is left around a way past the boxes, to either side of the robot's middle.
const WAY_M: f64 = 0.40;
/// The way lies this near to the lane at y = -0.5.
const LANE_Y_M: f64 = -0.5;
const BESIDE_M: f64 = 0.6;
const CLUTTER_STREAM: u64 = 0x434C_5554;

/// The end of the corridor: area 3 of the site.
const END_X_M: f64 = 8.5;

/// The scenario.
#[derive(Clone, Debug)]
pub struct Clutter {
    /// Longest time.
    pub patience_s: f64,
    /// Whether people heed a robot in front of them, and from how far; 0 for people who see nothing.
    pub people_heed_m: f64,
}

impl Scenario for Clutter {
    fn name(&self) -> &'static str {
        "clutter"
    }

    fn rules(&self) -> Rules {
        Rules {
            may_be_run_into: true,
            pose: false,
        }
    }

    fn furnish(&self, world: &mut World, seed: u64) -> Result<(), WorldError> {
        let mut random = Random::new(seed, CLUTTER_STREAM);
        let walls: Vec<Segment> = world
            .obstacles()
            .filter_map(|(_, shape)| match shape {
                Shape::Wall(wall) => Some(wall),
                _ => None,
            })
            .collect();
        for floor in boxes(&mut random, &walls) {
            world.add_obstacle(Obstacle::fixed(floor))?;
        }
        let between =
            |random: &mut Random, [low, high]: [f64; 2]| low + random.unit() * (high - low);
        for _ in 0..PEOPLE {
            let start_m = [0, 1].map(|axis| between(&mut random, [FROM_M[axis], TO_M[axis]]));
            let radius_m = between(&mut random, PERSON_RADIUS_M);
            world.add_walker(Walker {
                body: Body::Disc { radius_m },
                start_m,
                route: Route::Wander {
                    min_m: FROM_M,
                    max_m: TO_M,
                },
                slowest_m_s: PERSON_M_S[0],
                fastest_m_s: PERSON_M_S[1],
                longest_rest_s: LONGEST_REST_S,
                heed_m: self.people_heed_m,
                heed_behind_m: HEED_BEHIND_M,
            })?;
        }
        let speed_m_s = between(&mut random, OTHER_M_S);
        world.add_walker(Walker {
            body: Body::Box {
                length_m: 0.4,
                width_m: 0.3,
            },
            start_m: [9.4, 0.6],
            route: Route::Path(vec![[0.5, 0.6]]),
            slowest_m_s: speed_m_s,
            fastest_m_s: speed_m_s,
            longest_rest_s: 0.0,
            heed_m: OTHER_HEEDS_M,
            heed_behind_m: OTHER_HEEDS_M,
        })?;
        Ok(())
    }

    fn withholds_leave(&self) -> bool {
        false
    }

    fn patience_s(&self) -> f64 {
        self.patience_s
    }

    fn is_done(
        &self,
        _site: &SiteConfig,
        _fsm: &FsmConfig,
        _figures: &Figures,
        truth: &Truth,
    ) -> bool {
        truth.pose.x_m >= END_X_M
    }

    fn missing(&self, _site: &SiteConfig, _fsm: &FsmConfig, figures: &Figures) -> String {
        let last = figures.states.last().map_or("none", String::as_str);
        format!("the end of the corridor was not reached; it ended in state {last}")
    }

    fn least_done_share(&self) -> f64 {
        0.95
    }
}

/// Random boxes that leave a way along the lane; boxes that would close it are drawn again.
fn boxes(random: &mut Random, walls: &[Segment]) -> Vec<Shape> {
    let wanted = FEWEST_BOXES + random.bits() % (MOST_BOXES - FEWEST_BOXES + 1);
    let mut boxes: Vec<Shape> = Vec::new();
    // A drawing of several hundred boxes always ends; a corridor that is full gets fewer.
    for _ in 0..400 {
        if boxes.len() as u64 == wanted {
            break;
        }
        let side = |random: &mut Random| BOX_M[0] + random.unit() * (BOX_M[1] - BOX_M[0]);
        let place = |random: &mut Random, axis: usize| {
            FROM_M[axis] + random.unit() * (TO_M[axis] - FROM_M[axis])
        };
        boxes.push(Shape::Box {
            pose: Pose::new(
                place(random, 0),
                place(random, 1),
                random.symmetric(std::f64::consts::PI),
            ),
            length_m: side(random),
            width_m: side(random),
        });
        if !leaves_way(&boxes, walls) {
            boxes.pop();
        }
    }
    boxes
}

/// Whether a disc of the width of the way gets from before the boxes to behind them, near the lane, without turning back.
fn leaves_way(boxes: &[Shape], walls: &[Segment]) -> bool {
    const STEP_M: f64 = 0.05;
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
            .all(|floor| floor.distance_to_disc_m(at, 0.0) > WAY_M)
            && walls
                .iter()
                .all(|wall| wall.distance_to_point_m(at) > WAY_M)
    };
    let lanes = (2.0 * BESIDE_M / STEP_M) as usize + 1;
    let y = |lane: usize| LANE_Y_M - BESIDE_M + lane as f64 * STEP_M;
    let steps = ((TO_M[0] - FROM_M[0] + 1.6) / STEP_M) as usize;
    let mut reached: Vec<bool> = vec![true; lanes];
    for step in 0..=steps {
        let x = FROM_M[0] - 0.8 + step as f64 * STEP_M;
        let free: Vec<bool> = (0..lanes).map(|lane| is_free([x, y(lane)])).collect();
        // Sideways by at most half of what is driven ahead: the tubes bend no further.
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
        assert!(leaves_way(&[], &corridor()));
        assert!(leaves_way(
            &[bin(5.0, -1.3, 0.4), bin(6.0, 0.8, 0.4)],
            &corridor()
        ));
        assert!(!leaves_way(&[bin(5.0, -0.5, 1.0)], &corridor()));
    }

    #[test]
    fn every_seed_gives_its_own_clutter_with_a_way_through() {
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
            let clutter = Clutter {
                patience_s: 1.0,
                people_heed_m: 0.0,
            };
            clutter.furnish(&mut world, seed).expect("furnished");
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
            assert_eq!(discs.count() as u64, PEOPLE);
            let boxes: Vec<Shape> = shapes
                .iter()
                .copied()
                .filter(|shape| matches!(shape, Shape::Box { .. }))
                .take(shapes.len() - 3 - PEOPLE as usize)
                .collect();
            assert!(boxes.len() >= FEWEST_BOXES as usize && leaves_way(&boxes, &corridor()));
        }
    }
}
