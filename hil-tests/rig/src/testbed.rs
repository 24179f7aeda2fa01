//! A world and the devices of its robots, put together from the users' own files.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use config::{RobotConfig, SiteConfig};
use onboard::cli::Failure;
use sim::ethercat::{FaultHandle as BusFaults, ServeOptions, ServerHandle, serve_raw, serve_udp};
use sim::kelo::{DriveHandle, KeloOptions, SimulatedDrive};
use sim::lidar::{DeviceOptions, FaultHandle as LidarFaults, LidarOptions, LidarServer};
use sim::plant::Plant;
use sim::world::{Obstacle, Pose, Random, RangeModel, RobotModel, SharedWorld, World, WorldConfig};

use crate::scenario::Scenario;
use crate::shapes;

/// Priorities of the devices: above the robots', so that a starved simulator is not taken for a lost frame.
const SEGMENT_PRIORITY: u8 = 90;
const LIDAR_PRIORITY: u8 = 85;
/// Largest relative error of a wheel's radius.
const WHEEL_SCALE_ERROR: f64 = 0.01;
/// Truth records that are kept: twenty minutes of four robots.
const LOG_CAPACITY: usize = 240_000;
/// Offset of the true start from the one in the file, drawn from the seed.
const START_OFFSET_M: f64 = 0.05;
const START_OFFSET_RAD: f64 = 0.05;
/// Random stream of start offsets, apart from those of the world.
const START_STREAM: u64 = 0x5354_4152;
/// Random stream of starting times, apart from those of the world.
const DELAY_STREAM: u64 = 0x4445_4c41;
const MAX_CATCH_UP: Duration = Duration::from_secs(1);

/// Where a robot's bus is to be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BusPlace {
    /// Raw frames on a network interface.
    Interface(String),
    /// Datagrams to this address; port 0 for any free one.
    Udp(SocketAddr),
}

/// The devices of one robot, serving.
#[derive(Debug)]
pub struct Devices {
    /// The bus.
    pub bus: ServerHandle,
    /// Injects faults into the bus.
    pub bus_faults: BusFaults,
    /// The drive on the bus: what it received, and its own faults.
    pub drive: DriveHandle,
    /// The lidar.
    pub lidar: LidarServer,
    /// Injects faults into the lidar.
    pub lidar_faults: LidarFaults,
}

/// The world of a site with its robots, for the threads of their devices.
///
/// # Errors
/// [`Failure::Refused`] when the files describe no world.
pub fn world(
    site: &SiteConfig,
    robots: &[(&RobotConfig, Pose)],
    seed: u64,
) -> Result<SharedWorld, Failure> {
    plain_world(site, robots, seed).map(SharedWorld::from)
}

/// The same for one thread alone.
///
/// # Errors
/// [`Failure::Refused`] when the files describe no world.
pub fn plain_world(
    site: &SiteConfig,
    robots: &[(&RobotConfig, Pose)],
    seed: u64,
) -> Result<World, Failure> {
    let obstacles = site
        .walls
        .iter()
        .map(|wall| Obstacle::wall(wall.line.a.xy_m(), wall.line.b.xy_m()))
        .collect();
    let robots = robots
        .iter()
        .map(|(robot, start)| robot_model(robot, *start))
        .collect();
    World::new(WorldConfig {
        seed,
        obstacles,
        robots,
        log_capacity: LOG_CAPACITY,
        max_catch_up: MAX_CATCH_UP,
    })
    .map_err(Failure::refused)
}

/// Where the site file lets a robot start.
///
/// # Errors
/// [`Failure::Refused`] when the site does not know the robot.
pub fn start_pose(site: &SiteConfig, robot_id: &str) -> Result<Pose, Failure> {
    let robot = site.robots.get(robot_id).ok_or_else(|| {
        Failure::refused(format_args!(
            "site `{}` has no robot `{robot_id}`",
            site.name
        ))
    })?;
    Ok(Pose::new(
        robot.start.x_m,
        robot.start.y_m,
        robot.start.theta_rad,
    ))
}

/// The start in the file, with an offset that the robot does not know of.
fn drawn_start(start: Pose, seed: u64) -> Pose {
    let mut random = Random::new(seed, START_STREAM);
    let mut draw = |most: f64| random.symmetric(most);
    Pose::new(
        start.x_m + draw(START_OFFSET_M),
        start.y_m + draw(START_OFFSET_M),
        start.theta_rad + draw(START_OFFSET_RAD),
    )
}

/// The robots of a scenario, and where they truly start: each with an offset of its own.
#[must_use]
pub fn drawn_starts(scenario: &Scenario, seed: u64) -> Vec<(&RobotConfig, Pose)> {
    { scenario.robots.iter().enumerate() }
        .map(|(number, player)| {
            let start = &player.start.start;
            let start = Pose::new(start.x_m, start.y_m, start.theta_rad);
            let seed = seed.wrapping_add(7_919 * number as u64);
            (&player.config, drawn_start(start, seed))
        })
        .collect()
}

/// How long after the beginning each robot of a scenario starts, nanoseconds.
#[must_use]
pub fn start_delays_ns(scenario: &Scenario, seed: u64) -> Vec<u64> {
    let mut random = Random::new(seed, DELAY_STREAM);
    { scenario.robots.iter() }
        .map(|_| (random.unit() * scenario.start_delay_s * 1e9) as u64)
        .collect()
}

fn robot_model(robot: &RobotConfig, start: Pose) -> RobotModel {
    let mount = &robot.lidar.mount;
    RobotModel {
        footprint: shapes::footprint(robot),
        wheelbase_m: robot.drive.geometry.wheelbase_m,
        wheel_diameter_m: robot.drive.geometry.wheel_diameter_m,
        wheel_separation_m: robot.drive.geometry.wheel_separation_m,
        caster_offset_m: robot.drive.geometry.caster_offset_m,
        pivot_zero_rad: robot.drive.pivot_zero_rad,
        lidar: Pose::new(mount.x_m, mount.y_m, mount.theta_rad),
        wheel_scale_error: WHEEL_SCALE_ERROR,
        ..RobotModel::new(robot.identity.id.clone(), start)
    }
}

/// The drive that a robot file expects.
#[must_use]
pub fn simulated_drive(plant: Box<dyn Plant>, robot: &RobotConfig) -> SimulatedDrive {
    let mut options = KeloOptions::default();
    if let Some(product_code) = robot.ethercat.product_codes.first() {
        options.identity.product_code = *product_code;
    }
    if robot.ethercat.vendor_id != 0 {
        options.identity.vendor_id = robot.ethercat.vendor_id;
    }
    SimulatedDrive::new(plant, options)
}

impl Devices {
    /// Starts the devices of one robot.
    ///
    /// # Errors
    /// [`Failure::Refused`] naming the place that is not available.
    pub fn start(
        world: &SharedWorld,
        robot: &RobotConfig,
        place: &BusPlace,
        lidar_link: Option<PathBuf>,
        seed: u64,
    ) -> Result<Self, Failure> {
        let id = &robot.identity.id;
        let plant = world.robot(id).map_err(Failure::refused)?;
        let SimulatedDrive {
            segment,
            faults: bus_faults,
            drive,
            ..
        } = simulated_drive(Box::new(plant), robot);
        let options = ServeOptions {
            priority: Some(SEGMENT_PRIORITY),
        };
        let bus = match place {
            BusPlace::Interface(name) => serve_raw(name, segment, options),
            BusPlace::Udp(address) => serve_udp(*address, segment, options),
        }
        .map_err(Failure::refused)?;
        let lidar = LidarServer::start(
            world,
            id,
            LidarOptions {
                device: DeviceOptions::default(),
                range: RangeModel::default(),
                link: lidar_link,
                priority: Some(LIDAR_PRIORITY),
                seed,
            },
        )
        .map_err(Failure::refused)?;
        let lidar_faults = lidar.faults();
        Ok(Self {
            bus,
            bus_faults,
            drive,
            lidar,
            lidar_faults,
        })
    }
}
