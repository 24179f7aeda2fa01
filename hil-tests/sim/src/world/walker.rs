//! People and simple robots: bodies that go their own way through the world.
//!
//! A walker goes straight from point to point, through walls and other obstacles. It waits or turns away when a robot
//! is within the distance at which it [heeds](Walker::heed_m) robots, and turns away when it runs into one. The world's
//! seed decides where it goes.

use super::error::WorldError;
use super::geometry::{Point, Pose, Rectangle, add, norm, sub};
use super::random::Random;
use super::scene::{Obstacle, ObstacleId, Scene, Shape};

/// Random streams of walks begin here, apart from those of wheel errors and range noise.
const WALK_STREAM: u64 = 2 << 40;
/// Shortest leg and wait: longer than a turn of the lidar, which then sees at most one change of velocity.
const SHORTEST_NS: u64 = 300_000_000;
/// Steps between two looks for robots ahead.
const LOOK_STEPS: u64 = 10;
/// [`LOOK_STEPS`] in seconds, and one step more.
const LOOK_S: f64 = 0.011;
/// A walker sets out only in a direction with this much free floor.
const SET_OUT_M: f64 = 0.1;
/// Free floor is sampled at this spacing.
const LOOK_M: f64 = 0.05;
/// A walker at a larger angle from a robot's heading, seen from the middle of its front, is behind it.
pub const BEHIND_RAD: f64 = 1.9;
/// Highest speed of a walker.
const FASTEST_M_S: f64 = 5.0;

/// The outline of a walker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Body {
    /// A person.
    Disc {
        /// Radius.
        radius_m: f64,
    },
    /// A vehicle that always faces its direction of travel.
    Box {
        /// Size along its way.
        length_m: f64,
        /// Size across its way.
        width_m: f64,
    },
}

impl Body {
    fn at(&self, at_m: Point, heading_rad: f64) -> Shape {
        match *self {
            Body::Disc { radius_m } => Shape::Disc {
                centre_m: at_m,
                radius_m,
            },
            Body::Box { length_m, width_m } => Shape::Box {
                pose: Pose::new(at_m[0], at_m[1], heading_rad),
                length_m,
                width_m,
            },
        }
    }

    /// It touches a robot when it stands at `at_m`.
    fn touches(&self, robot: &Rectangle, at_m: Point, heading_rad: f64) -> bool {
        match self.at(at_m, heading_rad) {
            Shape::Box {
                pose,
                length_m,
                width_m,
            } => {
                robot.distance_to_rectangle_m(&Rectangle::centred(&pose, length_m, width_m)) <= 0.0
            }
            Shape::Disc { centre_m, radius_m } => {
                robot.distance_to_disc_m(centre_m, radius_m) <= 0.0
            }
            Shape::Wall(_) => false,
        }
    }
}

/// Where a walker goes.
#[derive(Debug, Clone, PartialEq)]
pub enum Route {
    /// From one random point of a region to the next, without end.
    Wander {
        /// Lower left corner.
        min_m: Point,
        /// Upper right corner.
        max_m: Point,
    },
    /// Along these points; at the last one it stands.
    Path(Vec<Point>),
}

/// Somebody or something that walks.
#[derive(Debug, Clone, PartialEq)]
pub struct Walker {
    /// Its outline.
    pub body: Body,
    /// Where its middle is at first.
    pub start_m: Point,
    /// Where it goes.
    pub route: Route,
    /// Slowest speed; each leg draws its own.
    pub slowest_m_s: f64,
    /// Fastest speed.
    pub fastest_m_s: f64,
    /// Longest rest between two legs; each draws its own from 0 on.
    pub longest_rest_s: f64,
    /// It waits, or goes elsewhere, when a robot is in its way within this distance. With 0 it ignores robots.
    pub heed_m: f64,
    /// The same for robots that it approaches from behind, [`BEHIND_RAD`] or more from their heading: a robot cannot
    /// avoid what it does not see.
    pub heed_behind_m: f64,
}

impl Walker {
    fn check(&self) -> Result<(), WorldError> {
        let finite = |p: Point| p[0].is_finite() && p[1].is_finite();
        let route = match &self.route {
            Route::Wander { min_m, max_m } => {
                finite(*min_m)
                    && finite(*max_m)
                    && min_m[0] <= max_m[0]
                    && min_m[1] <= max_m[1]
                    && norm(sub(*max_m, *min_m)) > 0.0
            }
            Route::Path(points) => !points.is_empty() && points.iter().all(|&point| finite(point)),
        };
        let speeds = self.slowest_m_s > 0.0
            && self.slowest_m_s <= self.fastest_m_s
            && self.fastest_m_s <= FASTEST_M_S;
        let bounded = |value: f64| (0.0..=3600.0).contains(&value);
        if route
            && speeds
            && finite(self.start_m)
            && bounded(self.longest_rest_s)
            && bounded(self.heed_m)
            && bounded(self.heed_behind_m)
        {
            return Ok(());
        }
        Err(WorldError::Walker(format!(
            "{self:?}: expected finite points, a region or path that is not empty, 0 < slowest <= fastest <= {FASTEST_M_S} m/s"
        )))
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    Walking {
        to_m: Point,
        speed_m_s: f64,
        arrives_ns: u64,
    },
    Resting {
        until_ns: u64,
    },
    Waiting {
        to_m: Point,
        speed_m_s: f64,
        until_ns: u64,
    },
    Ended,
}

/// A walker under way.
#[derive(Debug, Clone)]
pub(super) struct Walk {
    walker: Walker,
    random: Random,
    obstacle: ObstacleId,
    phase: Phase,
    next: usize,
    heading_rad: f64,
}

impl Walk {
    /// Puts a walker into the scene; it sets out at once.
    pub(super) fn new(
        walker: Walker,
        seed: u64,
        number: u64,
        scene: &mut Scene,
        now_ns: u64,
    ) -> Result<Walk, WorldError> {
        walker.check()?;
        let heading_rad = match &walker.route {
            Route::Path(points) => heading_of(sub(points[0], walker.start_m)).unwrap_or(0.0),
            Route::Wander { .. } => 0.0,
        };
        let shape = walker.body.at(walker.start_m, heading_rad);
        let obstacle = scene.add(Obstacle::fixed(shape), now_ns)?;
        Ok(Walk {
            random: Random::new(seed, WALK_STREAM + number),
            walker,
            obstacle,
            phase: Phase::Resting { until_ns: now_ns },
            next: 0,
            heading_rad,
        })
    }

    pub(super) fn obstacle(&self) -> ObstacleId {
        self.obstacle
    }

    /// The clock jumps without anything moving.
    pub(super) fn skip(&mut self, by_ns: u64) {
        match &mut self.phase {
            Phase::Walking { arrives_ns, .. } => *arrives_ns += by_ns,
            Phase::Resting { until_ns } | Phase::Waiting { until_ns, .. } => *until_ns += by_ns,
            Phase::Ended => {}
        }
    }

    /// One step of the world. `robots` are the floor that robots cover.
    pub(super) fn step(
        &mut self,
        now_ns: u64,
        steps: u64,
        scene: &mut Scene,
        robots: impl Iterator<Item = Rectangle> + Clone,
    ) {
        match self.phase {
            Phase::Ended => {}
            Phase::Resting { until_ns } if now_ns >= until_ns => {
                self.set_out(now_ns, scene, robots);
            }
            Phase::Walking {
                to_m, arrives_ns, ..
            } if now_ns >= arrives_ns => {
                scene.redirect(self.obstacle, now_ns, to_m, None, [0.0; 2]);
                let rest_s = self.random.unit() * self.walker.longest_rest_s;
                let rest_ns = ((rest_s * 1e9) as u64).max(SHORTEST_NS);
                self.phase = Phase::Resting {
                    until_ns: now_ns + rest_ns,
                };
            }
            Phase::Walking {
                to_m, speed_m_s, ..
            } if steps.is_multiple_of(LOOK_STEPS) => {
                let at_m = scene.position_m(self.obstacle, now_ns).unwrap_or(to_m);
                let hit = robots
                    .clone()
                    .any(|robot| self.walker.body.touches(&robot, at_m, self.heading_rad));
                if hit || self.is_blocked(at_m, to_m, robots) {
                    // Do not pass through a robot: go back to the position at the last look.
                    let back_m = if hit { speed_m_s * LOOK_S } else { 0.0 };
                    let (sin, cos) = self.heading_rad.sin_cos();
                    let at_m = [at_m[0] - back_m * cos, at_m[1] - back_m * sin];
                    scene.redirect(self.obstacle, now_ns, at_m, None, [0.0; 2]);
                    self.wait(to_m, speed_m_s, now_ns);
                }
            }
            Phase::Waiting {
                to_m,
                speed_m_s,
                until_ns,
            } if now_ns >= until_ns => match self.walker.route {
                Route::Wander { .. } => self.set_out(now_ns, scene, robots),
                Route::Path(_) => self.walk(to_m, speed_m_s, now_ns, scene, robots),
            },
            Phase::Resting { .. } | Phase::Walking { .. } | Phase::Waiting { .. } => {}
        }
    }

    fn wait(&mut self, to_m: Point, speed_m_s: f64, now_ns: u64) {
        self.phase = Phase::Waiting {
            to_m,
            speed_m_s,
            until_ns: now_ns + SHORTEST_NS,
        };
    }

    /// Chooses where to go next, and how fast.
    fn set_out(
        &mut self,
        now_ns: u64,
        scene: &mut Scene,
        robots: impl Iterator<Item = Rectangle> + Clone,
    ) {
        let (slowest, fastest) = (self.walker.slowest_m_s, self.walker.fastest_m_s);
        let speed_m_s = slowest + self.random.unit() * (fastest - slowest);
        let to_m = match &self.walker.route {
            Route::Wander { min_m, max_m } => {
                let mut draw =
                    |axis: usize| min_m[axis] + self.random.unit() * (max_m[axis] - min_m[axis]);
                [draw(0), draw(1)]
            }
            Route::Path(points) => match points.get(self.next) {
                Some(point) => {
                    self.next += 1;
                    *point
                }
                None => {
                    self.phase = Phase::Ended;
                    return;
                }
            },
        };
        self.walk(to_m, speed_m_s, now_ns, scene, robots);
    }

    fn walk(
        &mut self,
        to_m: Point,
        speed_m_s: f64,
        now_ns: u64,
        scene: &mut Scene,
        robots: impl Iterator<Item = Rectangle> + Clone,
    ) {
        let at_m = scene.position_m(self.obstacle, now_ns).unwrap_or(to_m);
        let way_m = sub(to_m, at_m);
        let length_m = norm(way_m);
        if (length_m / speed_m_s * 1e9) < SHORTEST_NS as f64 {
            self.phase = Phase::Resting {
                until_ns: now_ns + SHORTEST_NS,
            };
            return;
        }
        if self.is_blocked(at_m, to_m, robots.clone())
            || self.is_blocked_within(at_m, to_m, [SET_OUT_M; 2], robots)
        {
            self.wait(to_m, speed_m_s, now_ns);
            return;
        }
        self.heading_rad = heading_of(way_m).unwrap_or(self.heading_rad);
        let velocity_m_s = way_m.map(|part| part / length_m * speed_m_s);
        let heading_rad = Some(self.heading_rad);
        scene.redirect(self.obstacle, now_ns, at_m, heading_rad, velocity_m_s);
        self.phase = Phase::Walking {
            to_m,
            speed_m_s,
            arrives_ns: now_ns + (length_m / speed_m_s * 1e9) as u64,
        };
    }

    /// A robot stands in the way and is heeded.
    fn is_blocked(
        &self,
        at_m: Point,
        to_m: Point,
        robots: impl Iterator<Item = Rectangle> + Clone,
    ) -> bool {
        let heeds_m = [self.walker.heed_m, self.walker.heed_behind_m];
        self.is_blocked_within(at_m, to_m, heeds_m, robots)
    }

    /// The same with other distances: for robots that face it, and for those that do not.
    fn is_blocked_within(
        &self,
        at_m: Point,
        to_m: Point,
        [facing_m, behind_m]: [f64; 2],
        robots: impl Iterator<Item = Rectangle> + Clone,
    ) -> bool {
        let way_m = sub(to_m, at_m);
        let Some(heading_rad) = heading_of(way_m) else {
            return false;
        };
        let length_m = norm(way_m);
        let farthest_m = facing_m.max(behind_m) + 3.0;
        robots
            .filter(|robot| norm(sub(robot.corners_m[0], at_m)) < farthest_m)
            .any(|robot| {
                let heeds_m = if is_behind(&robot, at_m) {
                    behind_m
                } else {
                    facing_m
                };
                let looks = (heeds_m / LOOK_M).ceil() as u32;
                (1..=looks).any(|look| {
                    let share = f64::from(look) * LOOK_M / length_m;
                    let ahead_m = add(at_m, way_m.map(|part| part * share));
                    self.walker.body.touches(&robot, ahead_m, heading_rad)
                })
            })
    }
}

/// A point is behind a robot, whose corners begin at its front left.
fn is_behind(robot: &Rectangle, at_m: Point) -> bool {
    let [front_left, rear_left, _, front_right] = robot.corners_m;
    let front_m = [0, 1].map(|axis| 0.5 * (front_left[axis] + front_right[axis]));
    let ahead = sub(front_left, rear_left);
    let to = sub(at_m, front_m);
    let cosine = (ahead[0] * to[0] + ahead[1] * to[1]) / (norm(ahead) * norm(to)).max(1e-9);
    cosine < BEHIND_RAD.cos()
}

fn heading_of(way_m: Point) -> Option<f64> {
    (norm(way_m) > 0.0).then(|| way_m[1].atan2(way_m[0]))
}
