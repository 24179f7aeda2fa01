//! Clones: second robots with the identity of one that is there, as when an image of its disk was written to another robot.
//!
//! A clone has a body, devices, symbols and a session of its own, and its robot's plan and configuration: it believes to stand
//! where its robot starts, until somebody says otherwise. Before its fault begins and after it has ended its body stands in a store,
//! far off the floor, and is switched off. Where the fault gives a pose, and no robot is near, somebody puts it there, and tells it
//! where it stands. What faults do to messages of its robot, they do to the clone's; no other fault concerns it, and nobody else
//! operates it.

use std::collections::VecDeque;

use config::{RobotConfig, SiteConfig};
use onboard::cli::{Failure, Files};
use onboard::composition::plan::Plan;
use onboard::process::ctl::Request;
use sim::world::{Pose, SharedWorld};

use super::apart::is_near_a_robot;
use super::checkpoints::Checkpoints;
use super::devices::Devices;
use super::robot::SteppedRobot;
use super::start::Start;
use crate::folder::Folder;
use crate::scenario::Scenario;
use crate::stand_ins::caretaker::where_it_is;

/// From the floor to the store, and from one clone in it to the next: beyond the reach of every lidar.
const FAR_M: f64 = 10.0;
/// From when one is switched on until somebody speaks to it: its drive answers by then.
const SPEAKS_AFTER_NS: u64 = 1_500_000_000;
/// From one word of his to the next.
const WORDS_NS: u64 = 500_000_000;

/// A clone, or what is to be one.
pub(super) struct ClonedRobot {
    /// Number of its fault in the scenario.
    pub(super) fault: usize,
    /// Number of its body in the world.
    pub(super) body: usize,
    /// Whose identity it has.
    pub(super) of: String,
    /// What its body is made of, with a name of its own.
    pub(super) config: RobotConfig,
    /// Where it stands while it is nobody's clone.
    pub(super) store: Pose,
    /// Where it is switched on, if that is elsewhere.
    pose: Option<Pose>,
    /// Its fault has begun.
    pub(super) begun: bool,
    running: Option<Running>,
}

/// Fields are dropped in this order: the robot first, then what it uses.
struct Running {
    robot: SteppedRobot,
    devices: Devices,
    /// What it is still told of where it stands, and when next.
    words: VecDeque<Request>,
    speaks_ns: u64,
    _folder: Folder,
}

impl ClonedRobot {
    /// Those of a scenario's faults; their bodies have the numbers after the robots'.
    pub(super) fn all(scenario: &Scenario) -> Vec<Self> {
        { scenario.clones().enumerate() }
            .map(|(index, (fault, of))| {
                let mut config = scenario.robots[of].config.clone();
                let identity = config.identity.id.clone();
                config.identity.id = format!("{}, clone {}", config.identity.id, index + 1);
                let pose = scenario.faults[fault].pose;
                Self {
                    fault,
                    body: scenario.robots.len() + index,
                    of: identity,
                    config,
                    store: store(&scenario.site, 0, index),
                    pose: pose.map(|[x_m, y_m, deg]| Pose::new(x_m, y_m, deg.to_radians())),
                    begun: false,
                    running: None,
                }
            })
            .collect()
    }

    /// One step of its devices and of its process, while it is switched on.
    pub(super) fn step(&mut self, now_ns: u64) {
        if let Some(own) = &mut self.running {
            let Running { robot, devices, .. } = own;
            devices.step(now_ns, || robot.step(now_ns));
            if now_ns >= own.speaks_ns
                && let Some(word) = own.words.pop_front()
            {
                robot.ask_unwanted(word);
                own.speaks_ns += WORDS_NS;
            }
        }
    }

    /// It is switched on.
    pub(super) fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// Its process, while it is switched on, and its name.
    pub(super) fn running(&mut self) -> Option<(&mut SteppedRobot, &String)> {
        let running = self.running.as_mut()?;
        Some((&mut running.robot, &self.config.identity.id))
    }

    /// It is put onto the floor and switched on, with what its robot's processes start with; symbols live in the folder.
    ///
    /// # Errors
    /// [`Failure`] when a part of it cannot be built.
    pub(super) fn begin(
        &mut self,
        world: &SharedWorld,
        (files, plan): &(Files, Plan),
        start: Start,
        folder: Folder,
    ) -> Result<&mut SteppedRobot, Failure> {
        let now_ns = start.at_ns;
        let start = Start {
            checkpoints: Checkpoints::default(),
            ..start
        };
        let mut words = VecDeque::new();
        if let Some(pose) = self.pose {
            let mut world = world.lock();
            let is_free = !is_near_a_robot(&world, [pose.x_m, pose.y_m]);
            // Where something else stands nobody can be put.
            if is_free && world.carry(self.body, pose).is_ok() {
                words.push_back(Request::Pause);
                words.extend(where_it_is(&world, self.body));
                words.push_back(Request::Resume);
            }
        }
        let devices = Devices::of(world, &self.config.identity.id, plan, now_ns)?;
        let robot = SteppedRobot::new(plan, files, folder.path(), &devices, start)?;
        self.begun = true;
        let running = self.running.insert(Running {
            robot,
            devices,
            words,
            speaks_ns: now_ns + SPEAKS_AFTER_NS,
            _folder: folder,
        });
        Ok(&mut running.robot)
    }

    /// It is switched off and carried away.
    ///
    /// # Errors
    /// [`Failure`] when something is in the store, where nothing comes.
    pub(super) fn end(&mut self, world: &SharedWorld) -> Result<(), Failure> {
        self.running = None;
        let carried = world.lock().carry(self.body, self.store);
        carried.map_err(Failure::failed)
    }
}

/// A place in the store, by its column and its number there. The store begins off the floor, at its right lower corner.
pub(super) fn store(site: &SiteConfig, column: usize, number: usize) -> Pose {
    let walls = site
        .walls
        .iter()
        .flat_map(|wall| [wall.line.a, wall.line.b]);
    let areas = { site.areas.iter() }.flat_map(|area| [area.region.min, area.region.max]);
    let corners = || {
        walls
            .clone()
            .chain(areas.clone())
            .map(|corner| corner.xy_m())
    };
    let right_m = corners().map(|[x_m, _]| x_m).fold(0.0, f64::max);
    let low_m = corners().map(|[_, y_m]| y_m).fold(0.0, f64::min);
    let [x_m, y_m] = [column + 1, number].map(|place| FAR_M * place as f64);
    Pose::new(right_m + x_m, low_m + y_m, 0.0)
}
