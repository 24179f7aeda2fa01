//! The world's state and its steps.

use std::time::Duration;

use super::collision::{Cause, Collision, MOST_COLLISIONS};
use super::error::WorldError;
use super::geometry::{Footprint, Pose, norm, sub};
use super::random::Random;
use super::robot::{Motion, RobotModel};
use super::scene::{Obstacle, ObstacleId, Scene, Shape, Target};
use super::truth::{Truth, TruthLog};
use super::walker::{Walk, Walker};
use crate::plant::{DriveCommand, DriveFeedback};

/// Length of a step.
pub const STEP: Duration = Duration::from_millis(1);
/// A drive that has not been heard of for this long has no power any more.
pub const COMMAND_TIMEOUT: Duration = Duration::from_millis(500);

pub(super) const STEP_NS: u64 = STEP.as_nanos() as u64;
const STEP_S: f64 = STEP_NS as f64 * 1e-9;
const STEPS_PER_RECORD: u64 = 20;
const HISTORY_STEPS: usize = 256;
const SAME_COLLISION_NS: u64 = 500_000_000;

/// What a world starts with.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldConfig {
    /// Decides wheel errors and range noise.
    pub seed: u64,
    /// Walls and obstacles that are there from the start.
    pub obstacles: Vec<Obstacle>,
    /// The robots.
    pub robots: Vec<RobotModel>,
    /// Most truth records kept, of all robots together; each robot writes 50 a second.
    pub log_capacity: usize,
    /// A world that nobody advanced for longer than this skips the rest, standing still.
    pub max_catch_up: Duration,
}

impl Default for WorldConfig {
    /// Empty, seed 0, a log for one robot and an hour, at most 1 s of catching up.
    fn default() -> WorldConfig {
        WorldConfig {
            seed: 0,
            obstacles: Vec::new(),
            robots: Vec::new(),
            log_capacity: 180_000,
            max_catch_up: Duration::from_secs(1),
        }
    }
}

#[derive(Debug, Clone)]
struct Robot {
    model: RobotModel,
    motion: Motion,
    command: DriveCommand,
    commanded_ns: u64,
    /// Poses of the last steps; the newest is at `World::steps` modulo the length.
    history: Vec<Pose>,
    min_clearance_m: f64,
    distance_m: f64,
    collisions: u64,
    run_into: u64,
    first_collisions: Vec<Collision>,
    last_contact_ns: Option<u64>,
    in_contact: bool,
}

/// Walls, obstacles and robots at one time.
#[derive(Debug, Clone)]
pub struct World {
    seed: u64,
    max_catch_up_ns: u64,
    scene: Scene,
    walks: Vec<Walk>,
    walkers_added: u64,
    robots: Vec<Robot>,
    log: TruthLog,
    /// Time of the last whole step; `None` before the first call of `advance_to`.
    stepped_ns: Option<u64>,
    /// The latest time asked for, less than a step later.
    now_ns: u64,
    steps: u64,
    skipped_ns: u64,
}

impl World {
    /// A world at rest. Its clock starts with the first call of [`advance_to`](Self::advance_to).
    pub fn new(config: WorldConfig) -> Result<World, WorldError> {
        let mut scene = Scene::default();
        for obstacle in config.obstacles {
            scene.add(obstacle, 0)?;
        }
        let mut robots: Vec<Robot> = Vec::with_capacity(config.robots.len());
        for (index, model) in config.robots.into_iter().enumerate() {
            model.check()?;
            if robots.iter().any(|other| other.model.id == model.id) {
                let (id, reason) = (model.id, "there are two of this name".to_owned());
                return Err(WorldError::Robot { id, reason });
            }
            let motion = Motion::new(&model, &mut Random::new(config.seed, index as u64));
            robots.push(Robot {
                motion,
                command: DriveCommand::OFF,
                commanded_ns: 0,
                history: vec![model.start; HISTORY_STEPS],
                min_clearance_m: f64::INFINITY,
                distance_m: 0.0,
                collisions: 0,
                run_into: 0,
                first_collisions: Vec::new(),
                last_contact_ns: None,
                in_contact: false,
                model,
            });
        }
        let mut world = World {
            seed: config.seed,
            max_catch_up_ns: u64::try_from(config.max_catch_up.as_nanos())
                .unwrap_or(u64::MAX)
                .max(STEP_NS),
            scene,
            walks: Vec::new(),
            walkers_added: 0,
            robots,
            log: TruthLog::new(config.log_capacity),
            stepped_ns: None,
            now_ns: 0,
            steps: 0,
            skipped_ns: 0,
        };
        for index in 0..world.robots.len() {
            let clearance_m = world.clearance_below(index, f64::INFINITY);
            if clearance_m <= 0.0 {
                let id = world.robots[index].model.id.clone();
                let reason =
                    "starts in contact with a wall, an obstacle or another robot".to_owned();
                return Err(WorldError::Robot { id, reason });
            }
            world.robots[index].min_clearance_m = clearance_m;
        }
        Ok(world)
    }

    /// Steps up to `now_ns`, in which every robot holds its last command. A time in the past changes nothing.
    pub fn advance_to(&mut self, now_ns: u64) {
        let Some(mut stepped_ns) = self.stepped_ns else {
            self.skip(0, now_ns);
            for robot in &mut self.robots {
                robot.commanded_ns = now_ns;
            }
            self.stepped_ns = Some(now_ns);
            self.now_ns = now_ns;
            return;
        };
        self.now_ns = self.now_ns.max(now_ns);
        let behind_ns = self.now_ns - stepped_ns;
        if behind_ns > self.max_catch_up_ns {
            let skipped_ns = (behind_ns - self.max_catch_up_ns).div_ceil(STEP_NS) * STEP_NS;
            self.skip(stepped_ns, stepped_ns + skipped_ns);
            stepped_ns += skipped_ns;
            self.skipped_ns += skipped_ns;
        }
        while self.now_ns - stepped_ns >= STEP_NS {
            stepped_ns += STEP_NS;
            self.stepped_ns = Some(stepped_ns);
            self.step(stepped_ns);
        }
        self.stepped_ns = Some(stepped_ns);
    }

    /// Advances, reads a robot's sensors as they are at `now_ns`, and takes a new command for its drive from the
    /// next step on. A robot that does not exist reads as one at rest.
    pub fn exchange(&mut self, robot: usize, now_ns: u64, command: &DriveCommand) -> DriveFeedback {
        self.advance_to(now_ns);
        let ahead_s = self.ahead_s(self.now_ns);
        let Some(robot) = self.robots.get_mut(robot) else {
            return DriveFeedback::default();
        };
        robot.command = *command;
        robot.commanded_ns = self.now_ns;
        robot.motion.feedback(&robot.model, ahead_s)
    }

    /// Adds an obstacle, now.
    pub fn add_obstacle(&mut self, obstacle: Obstacle) -> Result<ObstacleId, WorldError> {
        self.scene.add(obstacle, self.now_ns)
    }

    /// Adds somebody who sets out now.
    pub fn add_walker(&mut self, walker: Walker) -> Result<ObstacleId, WorldError> {
        let number = self.walkers_added;
        let walk = Walk::new(walker, self.seed, number, &mut self.scene, self.now_ns)?;
        let id = walk.obstacle();
        self.walkers_added += 1;
        self.walks.push(walk);
        Ok(id)
    }

    /// Removes an obstacle, or a walker; false if it was not there.
    pub fn remove_obstacle(&mut self, id: ObstacleId) -> bool {
        self.walks.retain(|walk| walk.obstacle() != id);
        self.scene.remove(id)
    }

    /// Every obstacle as it is now, walls included.
    pub fn obstacles(&self) -> impl Iterator<Item = (ObstacleId, Shape)> + '_ {
        self.scene.at(self.now_ns)
    }

    /// Index of a robot in the configuration.
    pub fn robot_index(&self, id: &str) -> Result<usize, WorldError> {
        let found = self.robots.iter().position(|robot| robot.model.id == id);
        found.ok_or_else(|| WorldError::UnknownRobot {
            id: id.to_owned(),
            known: self
                .robots
                .iter()
                .map(|robot| robot.model.id.as_str())
                .collect::<Vec<_>>()
                .join(", "),
        })
    }

    /// The models of all robots, in the order of the configuration.
    pub fn models(&self) -> impl Iterator<Item = &RobotModel> {
        self.robots.iter().map(|robot| &robot.model)
    }

    /// The truth about a robot as of the last step; `None` if there is no such robot.
    #[must_use]
    pub fn truth(&self, robot: usize) -> Option<Truth> {
        let state = self.robots.get(robot)?;
        Some(Truth {
            time_ns: self.stepped_ns.unwrap_or(0),
            pose: state.motion.pose,
            twist: state.motion.twist,
            pivot_rad: state.motion.pivot_rad,
            clearance_m: if state.in_contact {
                0.0
            } else {
                self.clearance_below(robot, f64::INFINITY)
            },
            min_clearance_m: state.min_clearance_m,
            distance_m: state.distance_m,
            collisions: state.collisions,
            run_into: state.run_into,
            in_contact: state.in_contact,
        })
    }

    /// The collisions of a robot, in order of time; of very many the first ones.
    #[must_use]
    pub fn collisions(&self, robot: usize) -> &[Collision] {
        self.robots
            .get(robot)
            .map_or(&[], |robot| robot.first_collisions.as_slice())
    }

    /// True radii of a robot's left and right wheel, which its own configuration only knows nominally.
    #[must_use]
    pub fn wheel_radii_m(&self, robot: usize) -> Option<[f64; 2]> {
        Some(self.robots.get(robot)?.motion.wheel_radii_m())
    }

    /// The log of truths: every robot, 50 times a second.
    #[must_use]
    pub fn log(&self) -> &TruthLog {
        &self.log
    }

    /// The latest time asked for.
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// The seed this world came from.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Time during which the world stood still because nobody advanced it.
    #[must_use]
    pub fn skipped_ns(&self) -> u64 {
        self.skipped_ns
    }

    /// Where a robot was (up to a quarter of a second ago) or will be (at constant speed, within a step).
    #[must_use]
    pub fn pose_at(&self, robot: usize, at_ns: u64) -> Option<Pose> {
        let state = self.robots.get(robot)?;
        let stepped_ns = self.stepped_ns.unwrap_or(0);
        if at_ns >= stepped_ns {
            return Some(state.motion.pose_ahead(self.ahead_s(at_ns)));
        }
        let back_ns = stepped_ns - at_ns;
        let oldest = HISTORY_STEPS as u64 - 1;
        let past = |steps: u64| {
            let index = self.steps.wrapping_sub(steps.min(oldest)) % HISTORY_STEPS as u64;
            state.history[index as usize]
        };
        let whole = back_ns / STEP_NS;
        let share = (back_ns % STEP_NS) as f64 / STEP_NS as f64;
        Some(past(whole).interpolate(&past(whole + 1), share))
    }

    pub(super) fn targets(&self, from: &Pose, reach_m: f64, at_ns: u64, targets: &mut Vec<Target>) {
        let from_m = [from.x_m, from.y_m];
        self.scene.targets(from_m, reach_m, at_ns, targets);
    }

    fn ahead_s(&self, at_ns: u64) -> f64 {
        let ahead_ns = at_ns.saturating_sub(self.stepped_ns.unwrap_or(at_ns));
        ahead_ns.min(STEP_NS) as f64 * 1e-9
    }

    /// The clock jumps without anything moving.
    fn skip(&mut self, from_ns: u64, to_ns: u64) {
        self.scene.skip(from_ns, to_ns);
        for walk in &mut self.walks {
            walk.skip(to_ns.saturating_sub(from_ns));
        }
    }

    fn step(&mut self, to_ns: u64) {
        self.steps += 1;
        let floors = self
            .robots
            .iter()
            .map(|robot| robot.model.footprint.at(&robot.motion.pose));
        for walk in &mut self.walks {
            walk.step(to_ns, self.steps, &mut self.scene, floors.clone());
        }
        for index in 0..self.robots.len() {
            self.move_robot(index, to_ns);
        }
        if self.steps.is_multiple_of(STEPS_PER_RECORD) {
            for index in 0..self.robots.len() {
                if let Some(truth) = self.truth(index) {
                    self.log.push(index, truth);
                }
            }
        }
    }

    /// Moves one robot among the others as they stand: in the order of the configuration, hence repeatable.
    fn move_robot(&mut self, index: usize, to_ns: u64) {
        let robot = &mut self.robots[index];
        let silent_ns = to_ns.saturating_sub(robot.commanded_ns);
        if u128::from(silent_ns) > COMMAND_TIMEOUT.as_nanos() {
            robot.command = DriveCommand::OFF;
        }
        let before = robot.motion;
        robot.motion = before.stepped(&robot.model, &robot.command, STEP_S);
        let limit_m = robot.min_clearance_m.max(f64::MIN_POSITIVE);
        let clearance_m = self.clearance_below(index, limit_m);
        let robot = &mut self.robots[index];
        robot.min_clearance_m = robot.min_clearance_m.min(clearance_m);
        robot.in_contact = clearance_m <= 0.0;
        if robot.in_contact {
            let touched = robot.motion.pose;
            robot.motion = robot.motion.blocked(&before, &robot.model, STEP_S);
            let last_ns = robot.last_contact_ns.replace(to_ns);
            if last_ns.is_none_or(|last_ns| to_ns - last_ns > SAME_COLLISION_NS) {
                self.note_collision(index, &before, &touched, to_ns);
            }
        } else {
            let (from, to) = (before.pose, robot.motion.pose);
            robot.distance_m += norm(sub([to.x_m, to.y_m], [from.x_m, from.y_m]));
        }
        let slot = (self.steps % HISTORY_STEPS as u64) as usize;
        let robot = &mut self.robots[index];
        robot.history[slot] = robot.motion.pose;
    }

    /// A contact begins: of the robot as it was `before`, with what touches it at `touched`.
    fn note_collision(&mut self, index: usize, before: &Motion, touched: &Pose, at_ns: u64) {
        let footprint = self.robots[index].model.footprint;
        let outline_m_s = |footprint: &Footprint, motion: &Motion| {
            motion.twist.v_m_s.abs() + motion.twist.omega_rad_s.abs() * footprint.reach_m()
        };
        let touching = self.scene.touching(&footprint, touched, at_ns);
        let (mut object_m_s, mut middle_m) = touching.unwrap_or((0.0, None));
        let floor = footprint.at(touched);
        for (other_index, other) in self.robots.iter().enumerate() {
            let theirs = other.model.footprint.at(&other.motion.pose);
            if other_index != index && floor.distance_to_rectangle_m(&theirs) <= 0.0 {
                let other_m_s = outline_m_s(&other.model.footprint, &other.motion);
                object_m_s = object_m_s.max(other_m_s);
                middle_m = Some([other.motion.pose.x_m, other.motion.pose.y_m]);
            }
        }
        let lidar = touched.compose(&self.robots[index].model.lidar);
        let bearing_rad = middle_m.map_or(0.0, |middle_m| {
            let [dx, dy] = sub(middle_m, [lidar.x_m, lidar.y_m]);
            let (sin, cos) = (dy.atan2(dx) - lidar.theta_rad).sin_cos();
            sin.atan2(cos)
        });
        let robot_m_s = outline_m_s(&footprint, before);
        let collision = Collision::new(at_ns, robot_m_s, object_m_s, bearing_rad);
        let robot = &mut self.robots[index];
        robot.collisions += 1;
        robot.run_into += u64::from(collision.cause == Cause::RunInto);
        if robot.first_collisions.len() < MOST_COLLISIONS {
            robot.first_collisions.push(collision);
        }
    }

    /// Clearance of a robot to everything else, or `limit_m` if nothing is nearer.
    fn clearance_below(&self, index: usize, limit_m: f64) -> f64 {
        let robot = &self.robots[index];
        let (footprint, pose) = (&robot.model.footprint, &robot.motion.pose);
        let at_ns = self.stepped_ns.unwrap_or(self.now_ns);
        let mut best_m = self.scene.clearance_m(footprint, pose, at_ns, limit_m);
        for (other_index, other) in self.robots.iter().enumerate() {
            let (their_footprint, their_pose) = (&other.model.footprint, &other.motion.pose);
            let apart_m = norm(sub([their_pose.x_m, their_pose.y_m], [pose.x_m, pose.y_m]));
            let reach_m = footprint.reach_m() + their_footprint.reach_m();
            if other_index == index || apart_m - reach_m >= best_m {
                continue;
            }
            let theirs = their_footprint.at(their_pose);
            best_m = best_m.min(footprint.at(pose).distance_to_rectangle_m(&theirs));
        }
        best_m
    }
}
