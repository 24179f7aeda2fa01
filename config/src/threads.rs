//! The thread table: which activity runs where, when, and how urgently.

use std::fmt;
use std::time::Duration;

/// The activities of a robot's process.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ActivityKind {
    /// Exchanges wheel setpoints and encoders with the drive.
    Drive,
    /// Dead reckoning from the encoders.
    Proprioception,
    /// Motion command to wheel setpoints.
    Control,
    /// Receives scans.
    Lidar,
    /// Perception, pose, controllers, monitors, the robot's state machine.
    Navigation,
    /// Keeps the command inside free space.
    MotionTube,
    /// The network.
    Communication,
}

impl ActivityKind {
    /// All of them, in the order in which data flows.
    pub const ALL: [ActivityKind; 7] = [
        ActivityKind::Drive,
        ActivityKind::Proprioception,
        ActivityKind::Control,
        ActivityKind::Lidar,
        ActivityKind::Navigation,
        ActivityKind::MotionTube,
        ActivityKind::Communication,
    ];

    /// The name in files.
    pub const fn name(self) -> &'static str {
        match self {
            ActivityKind::Drive => "drive",
            ActivityKind::Proprioception => "proprioception",
            ActivityKind::Control => "control",
            ActivityKind::Lidar => "lidar",
            ActivityKind::Navigation => "navigation",
            ActivityKind::MotionTube => "motion-tube",
            ActivityKind::Communication => "communication",
        }
    }
}

impl fmt::Display for ActivityKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What wakes a thread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trigger {
    /// Absolute times, this far apart.
    Period(Duration),
    /// Bytes from the lidar.
    Lidar,
    /// Each new scan, and at least this often without one.
    Scan {
        /// Longest sleep.
        at_least: Duration,
    },
    /// An asynchronous run time.
    Async,
}

/// How the operating system schedules a thread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheduling {
    /// SCHED_FIFO with this priority, 1 to 99.
    Fifo(u8),
    /// Like any other program.
    Normal,
}

/// Where a thread may run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Core {
    /// Anywhere.
    Any,
    /// On the fast cores of a big.LITTLE machine; elsewhere anywhere.
    Big,
    /// On the slow cores of a big.LITTLE machine; elsewhere anywhere.
    Little,
    /// On exactly this one; an error where it does not exist.
    Number(usize),
}

/// `[threads.<name>]`
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ThreadConfig {
    /// Also the thread's name in the operating system: at most 15 bytes.
    pub name: String,
    /// What it runs, in this order.
    pub activities: Vec<ActivityKind>,
    /// What wakes it.
    pub trigger: Trigger,
    /// How it is scheduled.
    pub scheduling: Scheduling,
    /// Where it may run.
    pub core: Core,
}
