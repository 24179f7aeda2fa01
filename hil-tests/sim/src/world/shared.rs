//! One world for the threads of several simulated devices.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::config::WorldConfig;
use super::error::WorldError;
use super::range_finder::{RangeFinder, RangeModel};
use super::simulation::World;
use super::truth::Truth;
use crate::plant::{DriveCommand, DriveFeedback, Plant};
use crate::range_source::{RANGE_STEPS, RangeSource, STEPS_PER_TURN};

/// A world that threads share. It is locked for microseconds at a time.
#[derive(Debug, Clone)]
pub struct SharedWorld {
    world: Arc<Mutex<World>>,
}

impl SharedWorld {
    /// Builds and shares a world.
    ///
    /// # Errors
    /// [`WorldError`], as for [`World::new`].
    pub fn new(config: WorldConfig) -> Result<SharedWorld, WorldError> {
        World::new(config).map(SharedWorld::from)
    }

    /// Locks the world. Hold the guard briefly: simulated buses wait for it.
    pub fn lock(&self) -> MutexGuard<'_, World> {
        // A world is valid after every statement, so a panic elsewhere does not spoil it.
        self.world.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A robot by name.
    ///
    /// # Errors
    /// [`WorldError::UnknownRobot`], with the names there are.
    pub fn robot(&self, id: &str) -> Result<RobotHandle, WorldError> {
        let robot = self.lock().robot_index(id)?;
        Ok(RobotHandle {
            world: self.clone(),
            robot,
        })
    }
}

impl From<World> for SharedWorld {
    fn from(world: World) -> SharedWorld {
        SharedWorld {
            world: Arc::new(Mutex::new(world)),
        }
    }
}

/// One robot of a shared world: the plant of its drive, and the view of its lidar.
#[derive(Debug, Clone)]
pub struct RobotHandle {
    world: SharedWorld,
    robot: usize,
}

impl RobotHandle {
    /// Its index in the world's configuration.
    #[must_use]
    pub fn index(&self) -> usize {
        self.robot
    }

    /// The world it lives in.
    #[must_use]
    pub fn world(&self) -> &SharedWorld {
        &self.world
    }

    /// The truth about it as of the last step.
    #[must_use]
    pub fn truth(&self) -> Truth {
        let truth = self.world.lock().truth(self.robot);
        truth.expect("a handle is only made for a robot that exists, and robots are never removed")
    }

    /// What its lidar measures.
    #[must_use]
    pub fn range_source(&self, model: RangeModel) -> WorldRangeSource {
        WorldRangeSource {
            finder: RangeFinder::new(&self.world.lock(), self.robot, model),
            world: self.world.clone(),
        }
    }
}

impl Plant for RobotHandle {
    fn exchange(&mut self, now_ns: u64, command: &DriveCommand) -> DriveFeedback {
        self.world.lock().exchange(self.robot, now_ns, command)
    }
}

/// A lidar's optics in a shared world.
#[derive(Debug, Clone)]
pub struct WorldRangeSource {
    world: SharedWorld,
    finder: RangeFinder,
}

impl RangeSource for WorldRangeSource {
    fn measure(&mut self, turn_start_ns: u64, turn_ns: u64, readings_mm: &mut [u16; RANGE_STEPS]) {
        let measuring_ns = turn_ns / STEPS_PER_TURN as u64 * RANGE_STEPS as u64;
        {
            let mut world = self.world.lock();
            world.advance_to(turn_start_ns + measuring_ns);
            self.finder.capture(&world, turn_start_ns, turn_ns);
        }
        self.finder.cast(readings_mm);
    }
}
