//! Simulated devices that speak the real protocols, and the world between them.
//!
//! A robot program finds its fieldbus and its lidar here as it would find the real ones: EtherCAT datagrams on a
//! network interface or over UDP, SCIP on a pseudo-terminal. The crate depends on no other of the workspace, so that
//! any program can be tested against it: a MainDevice or lidar library of somebody else must work unchanged. The world
//! holds the truth about what happened; the robot's own opinion does not count.
//!
//! | module | holds |
//! |---|---|
//! | [`ethercat`] | a line of SubDevices: registers, state machine, process data, faults, servers |
//! | [`kelo`] | the KELO drive as one of these SubDevices |
//! | [`lidar`] | the Hokuyo URG-04LX on a serial line |
//! | [`world`] | walls, obstacles, walkers and robots, what robots see and hit, and the truth about them |
//! | [`plant`] | the seam between a drive and the mechanics it moves |
//! | [`rt`] | real-time priority for the servers' threads |
//!
//! Everything that decides is a value without I/O that is told the time: [`world::World`], [`lidar::Device`],
//! [`ethercat::Segment`]. Servers with threads are thin shells around them.
//!
//! # Real-time contract
//! The servers' threads ask for SCHED_FIFO and should run above the programs under test: a simulator that gets no
//! processor time looks like a faulty device. They allocate and lock. What the kernel granted can be read from the server;
//! a segment also tells its longest gap between two calls.
//!
//! # Units
//! A number carries its unit in its name. Metres and radians in the frames of ROS REP 103 (x forward, y left,
//! counter-clockwise positive); lidar readings in millimetres; times in nanoseconds of `CLOCK_BOOTTIME`.
//!
//! # What is simulated
//! *Supported*: behaves as the device does, and tests hold it. *Partial*: within the limits given. *Planned*: missing.
//!
//! | feature | state | limits |
//! |---|---|---|
//! | EtherCAT commands, FMMUs, SyncManagers, AL states, process-data watchdog | supported | |
//! | SII (EEPROM) | supported | |
//! | distributed clocks | partial | all clocks tick alike; no SYNC0/SYNC1, no latch signals |
//! | mailbox protocols, BOOT, VLAN tags, redundancy, protection of registers | planned | |
//! | faults of the bus: lost, late, duplicated, damaged and foreign frames, cables, power | supported | [`ethercat::FaultHandle`] |
//! | KELO drive, all four modes | partial | electrical values are plausible, not measured |
//! | SCIP 2.0 and 1.1 of the URG-04LX | supported | bit rates are kept; other bit rates give noise |
//! | ranges: noise, lost readings, motion during a turn | supported | one plane |
//! | robots with one steered drive unit | partial | slip, slope, load, brakes and jams by [`world::Mechanics`]; the fixed axle never slips |
//!
//! # Examples
//! A segment answers a frame that reads the AL status of every SubDevice (BRD of register 0x0130):
//!
//! ```
//! use sim::kelo::{KeloOptions, SimulatedDrive};
//! use sim::plant::TestStand;
//!
//! let mut drive = SimulatedDrive::new(Box::new(TestStand::new()), KeloOptions::default());
//! // EtherCAT header (14 bytes of datagrams), then BRD, index 0, position 0, register 0x0130, 2 bytes of data.
//! let mut payload = [14, 0x10, 7, 0, 0, 0, 0x30, 0x01, 2, 0, 0, 0, 0, 0, 0, 0];
//! drive.segment.process_payload(&mut payload, 1_000_000).expect("the frame comes back");
//! let (state, working_counter) = (payload[12], payload[14]);
//! assert_eq!((state, working_counter), (1, 1)); // INIT, one SubDevice
//! ```
//!
//! One turn of a lidar in a world:
//!
//! ```
//! use sim::world::{Obstacle, Pose, RANGE_STEPS, RangeFinder, RangeModel, RobotModel, World, WorldConfig};
//!
//! let mut world = World::new(WorldConfig {
//!     obstacles: vec![Obstacle::wall([3.0, -1.0], [3.0, 1.0])],
//!     robots: vec![RobotModel::new("amr-1", Pose::default())],
//!     ..WorldConfig::default()
//! })?;
//! let (start_ns, turn_ns) = (1_000_000_000, 100_000_000);
//! world.advance_to(start_ns);
//! world.advance_to(start_ns + turn_ns);
//! let mut lidar = RangeFinder::new(&world, 0, RangeModel::default());
//! lidar.capture(&world, start_ns, turn_ns);
//! let mut distances_m = [0.0; RANGE_STEPS];
//! lidar.cast_exact(&mut distances_m);
//! let mount_m = world.models().next().map_or(0.0, |model| model.lidar.x_m);
//! assert!((distances_m[384] - (3.0 - mount_m)).abs() < 1e-9, "step 384 looks ahead");
//! # Ok::<(), sim::world::WorldError>(())
//! ```

pub mod ethercat;
pub mod kelo;
pub mod lidar;
pub mod plant;
mod range_source;
pub mod rt;
pub mod world;
