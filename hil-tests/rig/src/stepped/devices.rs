//! The devices of one robot in memory: they outlive its process.

use std::sync::Arc;

use description::threads::ActivityKind;
use onboard::cli::Failure;
use onboard::composition::compose;
use onboard::composition::plan::Plan;
use sim::ethercat::FaultHandle;
use sim::kelo::{DriveHandle, DriveStatistics};
use sim::lidar::Disturbance;
use sim::world::SharedWorld;

use super::bus::Bus;
use super::lidar::Lidar;
use super::thread::ThreadClock;
use crate::testbed::simulated_drive;

/// The devices of one robot.
pub struct Devices {
    pub(super) bus: Bus,
    pub(super) lidar: Lidar,
}

impl Devices {
    /// The devices of a robot of `world`, which power up now.
    ///
    /// # Errors
    /// [`Failure::Refused`] when the world has no such robot.
    pub fn new(world: &SharedWorld, plan: &Plan, now_ns: u64) -> Result<Self, Failure> {
        Self::of(world, &plan.robot.identity.id, plan, now_ns)
    }

    /// The same of the body with this name.
    pub(super) fn of(
        world: &SharedWorld,
        body: &str,
        plan: &Plan,
        now_ns: u64,
    ) -> Result<Self, Failure> {
        let robot = world.robot(body).map_err(Failure::refused)?;
        let seed = world.lock().seed();
        let seed_of_bus = seed.wrapping_add(robot.index() as u64);
        Ok(Self {
            lidar: Lidar::new(&robot, seed, now_ns),
            bus: Bus::new(simulated_drive(Box::new(robot), &plan.robot), seed_of_bus),
        })
    }

    /// One step of the devices: turns of the lidar, what runs on them, watchdogs and wheels.
    pub fn step(&self, now_ns: u64, what_runs: impl FnOnce()) {
        self.lidar.cycle(now_ns);
        what_runs();
        self.bus.cycle(now_ns);
    }

    /// The process that used them is gone, without a farewell.
    pub fn hang_up(&self) {
        self.lidar.hang_up();
    }

    /// Faults of the bus.
    #[must_use]
    pub fn bus_faults(&self) -> &FaultHandle {
        &self.bus.faults
    }

    /// From now on the network interface of the bus refuses this share of frames, for want of room.
    pub fn refuse_frames(&self, share: f64) {
        self.bus.refuse(share);
    }

    /// From now on the network interface of the bus is gone, or there.
    pub fn lose_interface(&self, gone: bool) {
        self.bus.lose_interface(gone);
    }

    /// Faults of the drive.
    #[must_use]
    pub fn drive_faults(&self) -> &DriveHandle {
        &self.bus.drive
    }

    /// What the drive has received.
    #[must_use]
    pub fn drive(&self) -> DriveStatistics {
        self.bus.drive.statistics()
    }

    /// Disturbs the lidar.
    pub fn disturb_lidar(&self, disturbance: Disturbance, now_ns: u64) {
        self.lidar.disturb(disturbance, now_ns);
    }

    /// From now on what the lidar sends arrives later and later, by this share of the time that passes; 0 ends that.
    pub fn delay_lidar_more_and_more(&self, share: f64, now_ns: u64) {
        self.lidar.delay_more_and_more(share, now_ns);
    }

    /// When the lidar's present turn truly began.
    #[must_use]
    pub fn lidar_turn_start_ns(&self) -> u64 {
        self.lidar.turn_start_ns()
    }

    /// Somebody pulls the lidar's cable.
    pub fn unplug_lidar(&self) {
        self.lidar.unplug();
    }

    /// Somebody plugs it in again.
    pub fn plug_in_lidar(&self, now_ns: u64) {
        self.lidar.plug_in(now_ns);
    }

    /// The ways to them, for the threads with these clocks.
    pub(super) fn ways(
        &self,
        plan: &Plan,
        clock_of: impl Fn(ActivityKind) -> Arc<ThreadClock>,
    ) -> Result<compose::Devices, Failure> {
        let settings = plan.lidar_settings().map_err(Failure::refused)?;
        let (bus_clock, lidar_clock) =
            (clock_of(ActivityKind::Drive), clock_of(ActivityKind::Lidar));
        let (path, bit_rate) = (&settings.device, settings.options.bit_rate);
        Ok(compose::Devices {
            bus: (self.bus.opener(&bus_clock), bus_clock),
            lidar: (self.lidar.opener(&lidar_clock, path, bit_rate), lidar_clock),
        })
    }
}
