//! The thread that gives a device its time, its turns and its terminal.

use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::JoinHandle;

use super::RangeSource;
use super::device::{BIT_RATES, DeviceOptions};
use super::faults::{Counters, FaultHandle, Shared, lock};
use crate::rt::{Granted, monotonic_ns, promote};
use crate::world::{RangeModel, SharedWorld, WorldError};

mod port;
mod run;

use port::Port;
use run::Runner;

/// How a lidar is served.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LidarOptions {
    /// The sensor.
    pub device: DeviceOptions,
    /// How well it measures; for [`LidarServer::start`].
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
pub enum LidarError {
    /// The sensor has no such bit rate.
    #[error("lidar: bit rate {found}, expected one of {BIT_RATES:?}")]
    BitRate {
        /// What was asked for.
        found: u32,
    },
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

/// A lidar at work until it is stopped or dropped.
#[derive(Debug)]
pub struct LidarServer {
    shared: Arc<Shared>,
    link: Option<PathBuf>,
    thread: Option<JoinHandle<()>>,
}

impl LidarServer {
    /// Serves the lidar of a robot in a shared world.
    pub fn start(
        world: &SharedWorld,
        robot: &str,
        options: LidarOptions,
    ) -> Result<LidarServer, LidarError> {
        let source = world.robot(robot)?.range_source(options.range);
        LidarServer::start_with(Box::new(source), options)
    }

    /// Serves a lidar with readings from anywhere.
    pub fn start_with(
        source: Box<dyn RangeSource>,
        options: LidarOptions,
    ) -> Result<LidarServer, LidarError> {
        if !BIT_RATES.contains(&options.device.bit_rate) {
            return Err(LidarError::BitRate {
                found: options.device.bit_rate,
            });
        }
        let shared = Arc::new(Shared::default());
        let port = Port::new(options.link.as_deref(), options.device.bit_rate)?;
        *lock(&shared.slave) = Some(port.path().to_owned());
        let link = options.link.clone();
        let priority = options.priority;
        let runner = Runner::new(shared.clone(), source, options, port, monotonic_ns());
        let body = {
            let shared = shared.clone();
            move || {
                let granted = priority.map(promote);
                *lock(&shared.granted) = granted;
                runner.run();
            }
        };
        let thread = std::thread::Builder::new()
            .name("sim-lidar".to_owned())
            .spawn(body)
            .map_err(LidarError::Thread)?;
        Ok(LidarServer {
            shared,
            link,
            thread: Some(thread),
        })
    }

    /// Where a host finds the serial port: the link if there is one, else the terminal, if it is plugged in.
    pub fn path(&self) -> Option<PathBuf> {
        self.link.clone().or_else(|| self.terminal())
    }

    /// The terminal itself; `None` while unplugged.
    pub fn terminal(&self) -> Option<PathBuf> {
        lock(&self.shared.slave).clone()
    }

    /// Injects faults.
    pub fn faults(&self) -> FaultHandle {
        FaultHandle::new(self.shared.clone())
    }

    /// What it has done so far.
    pub fn counters(&self) -> Counters {
        *lock(&self.shared.counters)
    }

    /// What the thread was granted; `None` before it runs or if nothing was asked for.
    pub fn granted(&self) -> Option<Granted> {
        lock(&self.shared.granted).clone()
    }

    /// Hangs up, removes the link and waits for the thread.
    pub fn stop(mut self) {
        self.join();
    }

    fn join(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has already printed itself; there is nothing left to stop.
            let _ = thread.join();
        }
    }
}

impl Drop for LidarServer {
    fn drop(&mut self) {
        self.join();
    }
}

#[cfg(test)]
mod tests;
