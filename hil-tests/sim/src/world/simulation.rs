//! The world's state and its steps.

use std::cell::LazyCell;
use std::time::Duration;

use super::collision::Collision;
use super::config::WorldConfig;
use super::error::WorldError;
use super::geometry::{Pose, norm, sub};
use super::random::Random;
use super::robot::{Motion, RobotModel};
use super::robot_state::RobotState;
use super::scene::{Obstacle, ObstacleId, Scene, Shape, Target};
use super::truth::{Truth, TruthLog};
use super::walker::{Walk, Walker};
use super::wheel::Mechanics;
use crate::plant::{DriveCommand, DriveFeedback};

/// Length of a step.
pub const STEP: Duration = Duration::from_millis(1);
/// A drive without a command for this time loses its power.
pub const COMMAND_TIMEOUT: Duration = Duration::from_millis(500);

pub(super) const STEP_NS: u64 = STEP.as_nanos() as u64;
const STEP_S: f64 = STEP_NS as f64 * 1e-9;
const STEPS_PER_RECORD: u64 = 20;

/// Walls, obstacles and robots at one time.
#[derive(Debug, Clone)]
pub struct World {
    seed: u64,
    max_catch_up_ns: u64,
    scene: Scene,
    walks: Vec<Walk>,
    walkers_added: u64,
    pub(super) robots: Vec<RobotState>,
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
    ///
    /// # Errors
    /// [`WorldError`] for a model or obstacle that makes no sense, for two robots of one name, and for a robot that
    /// starts in contact with something.
    pub fn new(config: WorldConfig) -> Result<World, WorldError> {
        let mut scene = Scene::default();
        for obstacle in config.obstacles {
            scene.add(obstacle, 0)?;
        }
        let mut robots: Vec<RobotState> = Vec::with_capacity(config.robots.len());
        for (index, model) in config.robots.into_iter().enumerate() {
            model.check()?;
            if robots.iter().any(|other| other.model.id == model.id) {
                let (id, reason) = (model.id, "there are two of this name".to_owned());
                return Err(WorldError::Robot { id, reason });
            }
            let mut random = Random::new(config.seed, index as u64);
            robots.push(RobotState::new(model, &mut random));
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

    /// A copy without the log, for those who look longer than a lock may be held.
    #[must_use]
    pub fn snapshot(&self) -> World {
        World {
            scene: self.scene.clone(),
            walks: self.walks.clone(),
            robots: self.robots.clone(),
            log: TruthLog::new(0),
            ..*self
        }
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

    /// From now on a robot's wheels are like this.
    pub fn wear(&mut self, robot: usize, mechanics: Mechanics) {
        if let Some(robot) = self.robots.get_mut(robot) {
            robot.motion.wear(mechanics);
        }
    }

    /// Somebody lifts a robot, and sets it down somewhere else. What it has done so far is kept.
    ///
    /// # Errors
    /// [`WorldError::Robot`] when it would touch something there; then it stays where it is.
    pub fn carry(&mut self, robot: usize, to: Pose) -> Result<(), WorldError> {
        let Some(own) = self.robots.get_mut(robot) else {
            return Ok(());
        };
        let before = own.clone();
        own.set_down(to);
        if to.is_finite() && self.clearance_below(robot, f64::INFINITY) > 0.0 {
            return Ok(());
        }
        let id = before.model.id.clone();
        self.robots[robot] = before;
        let reason = format!(
            "cannot be put to {}, {}: something is there",
            to.x_m, to.y_m
        );
        Err(WorldError::Robot { id, reason })
    }

    /// Adds an obstacle, now.
    ///
    /// # Errors
    /// [`WorldError::Obstacle`] for numbers that make no sense, or when the world is full.
    pub fn add_obstacle(&mut self, obstacle: Obstacle) -> Result<ObstacleId, WorldError> {
        self.scene.add(obstacle, self.now_ns)
    }

    /// Adds a walker, who sets out now.
    ///
    /// # Errors
    /// [`WorldError::Walker`] for numbers that make no sense, [`WorldError::Obstacle`] when the world is full.
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
    ///
    /// # Errors
    /// [`WorldError::UnknownRobot`], with the names there are.
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
        let clearance_m = if state.in_contact {
            0.0
        } else {
            self.clearance_below(robot, f64::INFINITY)
        };
        Some(state.truth(self.stepped_ns.unwrap_or(0), clearance_m))
    }

    /// The first collisions of a robot, in order of time.
    #[must_use]
    pub fn collisions(&self, robot: usize) -> &[Collision] {
        self.robots
            .get(robot)
            .map_or(&[], |robot| robot.first_collisions.as_slice())
    }

    /// True radii of a robot's left and right wheel; its own configuration has the nominal ones.
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

    /// Total time skipped because the world was not advanced in time.
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
        let past = |ago: u64| state.past(self.steps, ago);
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
        let floors = self.robots.iter().map(RobotState::floor);
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

    /// Moves one robot while the others stand still. Robots move in the order of the configuration, so runs repeat.
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
            if robot.touches(to_ns) {
                self.note_collision(index, &before, &touched, to_ns);
            }
        } else {
            robot.add_way(&before.pose);
        }
        self.robots[index].remember(self.steps);
    }

    /// A contact begins: of the robot as it was `before`, with what touches it at `touched`.
    fn note_collision(&mut self, index: usize, before: &Motion, touched: &Pose, at_ns: u64) {
        let robot = &self.robots[index];
        let footprint = robot.model.footprint;
        let touching = self.scene.touching(&footprint, touched, at_ns);
        let (mut object_m_s, mut middle_m) = touching.unwrap_or((0.0, None));
        let floor = footprint.at(touched);
        for (other_index, other) in self.robots.iter().enumerate() {
            if other_index != index && floor.distance_to_rectangle_m(&other.floor()) <= 0.0 {
                object_m_s = object_m_s.max(other.outline_m_s(&other.motion));
                middle_m = Some(other.middle_m());
            }
        }
        let lidar = touched.compose(&robot.model.lidar);
        let bearing_rad = middle_m.map_or(0.0, |middle_m| {
            let [dx, dy] = sub(middle_m, [lidar.x_m, lidar.y_m]);
            let (sin, cos) = (dy.atan2(dx) - lidar.theta_rad).sin_cos();
            sin.atan2(cos)
        });
        let collision = Collision::new(at_ns, robot.outline_m_s(before), object_m_s, bearing_rad);
        self.robots[index].add_collision(collision);
    }

    /// Clearance of a robot to everything else, or `limit_m` if nothing is closer.
    pub(super) fn clearance_below(&self, index: usize, limit_m: f64) -> f64 {
        let robot = &self.robots[index];
        let at_ns = self.stepped_ns.unwrap_or(self.now_ns);
        // Placed at most once, and only when something is near.
        let floor = LazyCell::new(|| robot.floor());
        let (middle, reach_m) = (robot.middle_m(), robot.reach_m);
        let mut best_m = { &self.scene }.clearance_m(middle, reach_m, &floor, at_ns, limit_m);
        for (other_index, other) in self.robots.iter().enumerate() {
            let apart_m = norm(sub(other.middle_m(), middle));
            if other_index == index || apart_m - (reach_m + other.reach_m) >= best_m {
                continue;
            }
            best_m = best_m.min(floor.distance_to_rectangle_m(&other.floor()));
        }
        best_m
    }
}
