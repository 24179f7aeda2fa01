//! How a lidar is served, and why it cannot be.

use std::io;
use std::path::PathBuf;

use crate::lidar::device::{BIT_RATES, DeviceOptions};
use crate::world::{RangeModel, WorldError};

/// How a lidar is served.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LidarOptions {
    /// The sensor.
    pub device: DeviceOptions,
    /// How well it measures; for [`LidarServer::start`](crate::lidar::LidarServer::start).
    pub range: RangeModel,
    /// A symbolic link to the terminal, made again after a replug.
    pub link: Option<PathBuf>,
    /// SCHED_FIFO priority of the thread, if permitted.
    pub priority: Option<u8>,
    /// Decides garbled and random bytes.
    pub seed: u64,
}

/// Why a lidar cannot be served.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum LidarError {
    /// The sensor has no such bit rate.
    #[error("lidar: bit rate {found}, expected one of {BIT_RATES:?}")]
    BitRate { found: u32 },
    /// No pseudo-terminal could be had.
    #[error("lidar: no pseudo-terminal: {0}")]
    Terminal(#[source] io::Error),
    /// The symbolic link could not be made.
    #[error("lidar: {0}")]
    Link(String),
    /// The thread could not be started.
    #[error("lidar: cannot start its thread: {0}")]
    Thread(#[source] io::Error),
    /// The robot is not in the world.
    #[error("lidar: {0}")]
    World(#[from] WorldError),
}
