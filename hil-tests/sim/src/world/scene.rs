//! What stands and moves in the world besides robots.

use std::cell::LazyCell;

use super::error::WorldError;
use super::geometry::{Footprint, Point, Pose, Rectangle, Segment, add, norm, sub};

/// Most obstacles in one world.
pub const MAX_OBSTACLES: usize = 4096;

/// The outline of an obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A wall, seen from both sides.
    Wall(Segment),
    /// A pillar, a person's leg, a bin.
    Disc {
        /// Centre.
        centre_m: Point,
        /// Radius.
        radius_m: f64,
    },
    /// A box, centred on a pose.
    Box {
        /// Centre and heading.
        pose: Pose,
        /// Size along the heading.
        length_m: f64,
        /// Size across the heading.
        width_m: f64,
    },
}

/// Something a robot can see and hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Obstacle {
    /// Its outline when it is added.
    pub shape: Shape,
    /// Its constant velocity; obstacles pass through each other and through robots, who suffer a collision.
    pub velocity_m_s: Point,
}

impl Obstacle {
    /// An obstacle at rest.
    #[must_use]
    pub const fn fixed(shape: Shape) -> Obstacle {
        Obstacle {
            shape,
            velocity_m_s: [0.0, 0.0],
        }
    }

    /// A wall at rest.
    #[must_use]
    pub const fn wall(from_m: Point, to_m: Point) -> Obstacle {
        Obstacle::fixed(Shape::Wall(Segment::new(from_m, to_m)))
    }

    /// A disc at rest.
    #[must_use]
    pub const fn disc(centre_m: Point, radius_m: f64) -> Obstacle {
        Obstacle::fixed(Shape::Disc { centre_m, radius_m })
    }

    fn check(&self) -> Result<(), WorldError> {
        let [vx, vy] = self.velocity_m_s;
        let finite = |p: Point| p[0].is_finite() && p[1].is_finite();
        let size = |x: f64| x.is_finite() && x > 0.0;
        let valid = match self.shape {
            Shape::Wall(s) => finite(s.from_m) && finite(s.to_m),
            Shape::Disc { centre_m, radius_m } => finite(centre_m) && size(radius_m),
            Shape::Box {
                pose,
                length_m,
                width_m,
            } => pose.is_finite() && size(length_m) && size(width_m),
        };
        if valid && vx.is_finite() && vy.is_finite() {
            Ok(())
        } else {
            Err(WorldError::Obstacle(format!(
                "{self:?}: expected finite numbers and positive sizes"
            )))
        }
    }
}

/// Names an obstacle until it is removed; never reused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ObstacleId(u64);

#[derive(Debug, Clone)]
struct Placed {
    id: ObstacleId,
    obstacle: Obstacle,
    placed_ns: u64,
    /// Its velocity until then.
    before_m_s: Point,
}

impl Placed {
    /// How far it has moved by `at_ns`, also before it was placed.
    fn displacement_m(&self, at_ns: u64) -> Point {
        let [vx, vy] = if at_ns < self.placed_ns {
            self.before_m_s
        } else {
            self.obstacle.velocity_m_s
        };
        if [vx, vy] == [0.0, 0.0] {
            return [0.0, 0.0];
        }
        let age_s = at_ns as f64 * 1e-9 - self.placed_ns as f64 * 1e-9;
        [vx * age_s, vy * age_s]
    }

    /// How fast it came to where it is at `at_ns`: one whose last step has touched a robot may stand by now.
    fn speed_before_m_s(&self, at_ns: u64) -> f64 {
        norm(if at_ns <= self.placed_ns {
            self.before_m_s
        } else {
            self.obstacle.velocity_m_s
        })
    }

    /// How it moves from `at_ns` on.
    fn course(&self, at_ns: u64) -> Course {
        let velocity_m_s = self.obstacle.velocity_m_s;
        if at_ns >= self.placed_ns || self.before_m_s == velocity_m_s {
            return Course {
                until_s: f64::INFINITY,
                first_m_s: velocity_m_s,
                then_m_s: velocity_m_s,
            };
        }
        Course {
            until_s: (self.placed_ns - at_ns) as f64 * 1e-9,
            first_m_s: self.before_m_s,
            then_m_s: velocity_m_s,
        }
    }
}

/// Straight on, with at most one change of velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Course {
    until_s: f64,
    first_m_s: Point,
    then_m_s: Point,
}

impl Course {
    /// Displacement after `age_s`.
    pub(super) fn way_m(&self, age_s: f64) -> Point {
        let first_s = age_s.min(self.until_s);
        let then_s = age_s - first_s;
        [0, 1].map(|axis| self.first_m_s[axis] * first_s + self.then_m_s[axis] * then_s)
    }
}

/// A piece of outline as a ray sees it, and how it moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Target {
    pub(super) outline: Outline,
    pub(super) course: Course,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Outline {
    Segment(Segment),
    Disc { centre_m: Point, radius_m: f64 },
}

#[derive(Debug, Clone, Default)]
pub(super) struct Scene {
    obstacles: Vec<Placed>,
    next_id: u64,
}

impl Scene {
    pub(super) fn add(
        &mut self,
        obstacle: Obstacle,
        now_ns: u64,
    ) -> Result<ObstacleId, WorldError> {
        obstacle.check()?;
        if self.obstacles.len() >= MAX_OBSTACLES {
            return Err(WorldError::Obstacle(format!(
                "there are {MAX_OBSTACLES} already, the most this world holds"
            )));
        }
        let id = ObstacleId(self.next_id);
        self.next_id += 1;
        self.obstacles.push(Placed {
            id,
            obstacle,
            placed_ns: now_ns,
            before_m_s: obstacle.velocity_m_s,
        });
        Ok(id)
    }

    /// Where the middle of a disc or box is.
    pub(super) fn position_m(&self, id: ObstacleId, at_ns: u64) -> Option<Point> {
        let placed = self.obstacles.iter().find(|placed| placed.id == id)?;
        match moved(&placed.obstacle.shape, placed.displacement_m(at_ns)) {
            Shape::Disc { centre_m, .. } => Some(centre_m),
            Shape::Box { pose, .. } => Some([pose.x_m, pose.y_m]),
            Shape::Wall(_) => None,
        }
    }

    /// Gives a disc or box another velocity, from `at_m` at `now_ns` on.
    pub(super) fn redirect(
        &mut self,
        id: ObstacleId,
        now_ns: u64,
        at_m: Point,
        heading_rad: Option<f64>,
        velocity_m_s: Point,
    ) {
        let Some(placed) = self.obstacles.iter_mut().find(|placed| placed.id == id) else {
            return;
        };
        match &mut placed.obstacle.shape {
            Shape::Disc { centre_m, .. } => *centre_m = at_m,
            Shape::Box { pose, .. } => {
                *pose = Pose::new(at_m[0], at_m[1], heading_rad.unwrap_or(pose.theta_rad));
            }
            Shape::Wall(_) => return,
        }
        placed.before_m_s = placed.obstacle.velocity_m_s;
        placed.obstacle.velocity_m_s = velocity_m_s;
        placed.placed_ns = now_ns;
    }

    /// Speed and middle of the fastest obstacle that a footprint touches; walls have none.
    pub(super) fn touching(
        &self,
        footprint: &Footprint,
        pose: &Pose,
        at_ns: u64,
    ) -> Option<(f64, Option<Point>)> {
        let rectangle = footprint.at(pose);
        self.obstacles
            .iter()
            .filter_map(|placed| {
                let shape = moved(&placed.obstacle.shape, placed.displacement_m(at_ns));
                let middle_m = match &shape {
                    Shape::Wall(_) => None,
                    Shape::Disc { centre_m, .. } => Some(*centre_m),
                    Shape::Box { pose, .. } => Some([pose.x_m, pose.y_m]),
                };
                (distance_m(&rectangle, &shape) <= 0.0)
                    .then(|| (placed.speed_before_m_s(at_ns), middle_m))
            })
            .max_by(|a, b| a.0.total_cmp(&b.0))
    }

    pub(super) fn remove(&mut self, id: ObstacleId) -> bool {
        let before = self.obstacles.len();
        self.obstacles.retain(|placed| placed.id != id);
        self.obstacles.len() < before
    }

    /// The clock jumps from `from_ns` to `to_ns` while nothing moves.
    pub(super) fn skip(&mut self, from_ns: u64, to_ns: u64) {
        for placed in &mut self.obstacles {
            placed.placed_ns += to_ns.saturating_sub(from_ns);
        }
    }

    /// Every obstacle as it is at `at_ns`.
    pub(super) fn at(&self, at_ns: u64) -> impl Iterator<Item = (ObstacleId, Shape)> + '_ {
        self.obstacles.iter().map(move |placed| {
            let by_m = placed.displacement_m(at_ns);
            (placed.id, moved(&placed.obstacle.shape, by_m))
        })
    }

    /// Smallest distance of a floor to any obstacle at `at_ns`, or `limit_m` if none is nearer. The floor lies within
    /// `reach_m` of `middle`.
    pub(super) fn clearance_m<F: FnOnce() -> Rectangle>(
        &self,
        middle: Point,
        reach_m: f64,
        floor: &LazyCell<Rectangle, F>,
        at_ns: u64,
        limit_m: f64,
    ) -> f64 {
        let mut best_m = limit_m;
        for (_, shape) in self.at(at_ns) {
            let from_middle_m = match &shape {
                Shape::Wall(wall) if wall.is_further_m(middle, best_m + reach_m) => continue,
                Shape::Wall(wall) => wall.distance_to_point_m(middle),
                Shape::Disc { centre_m, radius_m } => norm(sub(*centre_m, middle)) - radius_m,
                Shape::Box {
                    pose,
                    length_m,
                    width_m,
                } => norm(sub([pose.x_m, pose.y_m], middle)) - 0.5 * length_m.hypot(*width_m),
            };
            if from_middle_m - reach_m >= best_m {
                continue;
            }
            best_m = best_m.min(distance_m(floor, &shape));
        }
        best_m
    }

    /// Collects every outline within `reach_m` of a point, as it is at `at_ns`.
    pub(super) fn targets(
        &self,
        from_m: Point,
        reach_m: f64,
        at_ns: u64,
        targets: &mut Vec<Target>,
    ) {
        for placed in &self.obstacles {
            let course = placed.course(at_ns);
            let mut push = |outline: Outline| {
                let distance_m = match &outline {
                    Outline::Segment(segment) => segment.distance_to_point_m(from_m),
                    Outline::Disc { centre_m, radius_m } => norm(sub(*centre_m, from_m)) - radius_m,
                };
                if distance_m <= reach_m {
                    targets.push(Target { outline, course });
                }
            };
            match moved(&placed.obstacle.shape, placed.displacement_m(at_ns)) {
                Shape::Wall(wall) => push(Outline::Segment(wall)),
                Shape::Disc { centre_m, radius_m } => push(Outline::Disc { centre_m, radius_m }),
                Shape::Box {
                    pose,
                    length_m,
                    width_m,
                } => Rectangle::centred(&pose, length_m, width_m)
                    .edges()
                    .into_iter()
                    .for_each(|edge| push(Outline::Segment(edge))),
            }
        }
    }
}

fn distance_m(rectangle: &Rectangle, shape: &Shape) -> f64 {
    match shape {
        Shape::Wall(wall) => rectangle.distance_to_segment_m(wall),
        Shape::Disc { centre_m, radius_m } => rectangle.distance_to_disc_m(*centre_m, *radius_m),
        Shape::Box {
            pose,
            length_m,
            width_m,
        } => rectangle.distance_to_rectangle_m(&Rectangle::centred(pose, *length_m, *width_m)),
    }
}

fn moved(shape: &Shape, by_m: Point) -> Shape {
    match *shape {
        Shape::Wall(wall) => Shape::Wall(wall.moved(by_m)),
        Shape::Disc { centre_m, radius_m } => Shape::Disc {
            centre_m: add(centre_m, by_m),
            radius_m,
        },
        Shape::Box {
            pose,
            length_m,
            width_m,
        } => Shape::Box {
            pose: Pose::new(pose.x_m + by_m[0], pose.y_m + by_m[1], pose.theta_rad),
            length_m,
            width_m,
        },
    }
}
