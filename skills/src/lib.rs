//! Pure algorithms of one robot: no device, no file, no thread, no clock of their own. They make of encoders and scans a
//! pose, of a pose and a map a motion, and of a motion wheel speeds.
//!
//! * [`odometry`], [`history`]: dead reckoning from wheel and pivot encoders, and its recent past;
//! * [`drive`]: motion commands to wheel setpoints;
//! * [`scan`]: range scans, aligned to the motion during the sensor's turn;
//! * [`perception`]: corridor, lane end and walls, found in scans;
//! * [`localisation`]: the pose in `map`;
//! * [`control`], [`monitors`]: control laws, and the conditions that raise events;
//! * [`borders`]: how far the robot may go until its footprint enters an area that is not allowed;
//! * [`map`], [`schedule`]: the semantic map, and what runs in each state of the robot's machine;
//! * [`tubes`]: whether the floor is free that the robot is about to sweep;
//! * [`navigator`]: pose, perception, monitors, machine and controller as one step.
//!
//! **Real time.** Constructors may allocate. Every step afterwards does not allocate, lock, log, wait or make a system
//! call, takes a bounded time, and does not panic on any input.
//!
//! **Units and frames.** Metres, radians, seconds, or as the name says (`_ns`, `_mm`, `_1_m` for a curvature). Frames are
//! those of ROS REP 105: `map`, `odom`, `base_link` (x forward, y left) and `laser`.
//!
//! # Example
//! A scan shows a wall 1.5 m ahead of a robot that wants to drive at 0.4 m/s; its motion tubes slow it down.
//! ```
//! use description::geometry::{Footprint, MotionCommand, Pose2, Twist2};
//! use skills::history::OdometryHistory;
//! use skills::scan::{AlignedScan, ScanGeometry};
//! use description::robot::{AdaptPolicy, Tubes};
//! use skills::tubes::{MotionTubes, StopRules, TubeSet, Verdict};
//!
//! let footprint = Footprint { front_m: 0.32, rear_m: 0.08, left_m: 0.15, right_m: 0.15 };
//! let sensor = ScanGeometry::urg_04lx(Pose2::new(0.28, 0.0, 0.0), 4.0);
//! let (set, report) = TubeSet::generate(&Tubes::default(), &footprint, &sensor)?;
//! assert!(report.tubes > 100);
//! let mut tubes = MotionTubes::new(set, AdaptPolicy::default(), StopRules::default())?;
//!
//! // A wall across the way, 1.5 m from `base_link`: its range in millimetres for every beam; 0 is out of range.
//! let wall_mm = |beam| {
//!     let ahead = sensor.beam_angle_rad(beam).cos();
//!     let range_m = if ahead > 0.1 { (1.5 - sensor.mount.x_m) / ahead } else { 9.0 };
//!     if range_m < 4.0 { (range_m * 1e3) as u16 } else { 0 }
//! };
//! let raw_mm: Vec<u16> = (0..sensor.beams).map(wall_mm).collect();
//!
//! // Without noise it would be taken for one that is frozen.
//! let mut scan = AlignedScan::new(sensor)?.without_frozen_check();
//! let mut history = OdometryHistory::default();
//! let wanted = MotionCommand::new(0.4, 0.0);
//! let mut answer = Default::default();
//! for tenth in 1..30 {
//!     let now_ns = tenth * 100_000_000;
//!     history.push(now_ns, Pose2::IDENTITY, Twist2::default())?;
//!     if tenth > 1 {
//!         scan.align(&raw_mm, now_ns - sensor.duration_ns(), &history)?;
//!         tubes.observe(&scan, now_ns)?;
//!     }
//!     answer = tubes.adapt(wanted, Twist2::default(), now_ns);
//! }
//! assert_eq!(answer.verdict, Verdict::Slowed);
//! assert!(answer.command.speed_m_s > 0.1 && answer.command.speed_m_s < 0.4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod borders;
pub mod control;
mod direction;
pub mod drive;
pub mod history;
pub mod localisation;
pub mod map;
pub mod monitors;
pub mod navigator;
pub mod odometry;
pub mod perception;
pub mod scan;
pub mod schedule;
pub mod tubes;
