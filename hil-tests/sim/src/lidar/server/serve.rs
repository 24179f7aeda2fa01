//! The thread that gives a device its time, its turns and its terminal.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::JoinHandle;

use super::options::{LidarError, LidarOptions};
use super::port::Port;
use super::run::Runner;
use crate::lidar::device::BIT_RATES;
use crate::lidar::faults::{Counters, FaultHandle, Shared, lock};
use crate::range_source::RangeSource;
use crate::rt::{Granted, monotonic_ns, promote};
use crate::world::SharedWorld;

/// A lidar at work until it is stopped or dropped.
#[derive(Debug)]
pub struct LidarServer {
    shared: Arc<Shared>,
    link: Option<PathBuf>,
    thread: Option<JoinHandle<()>>,
}

impl LidarServer {
    /// Serves the lidar of a robot in a shared world.
    ///
    /// # Errors
    /// As for [`start_with`](Self::start_with), and [`LidarError::World`] when the robot is not in the world.
    pub fn start(
        world: &SharedWorld,
        robot: &str,
        options: LidarOptions,
    ) -> Result<LidarServer, LidarError> {
        let source = world.robot(robot)?.range_source(options.range);
        LidarServer::start_with(Box::new(source), options)
    }

    /// Serves a lidar with readings from anywhere.
    ///
    /// # Errors
    /// [`LidarError`]: a bit rate the sensor does not have, or no terminal, link or thread.
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
    #[must_use]
    pub fn path(&self) -> Option<PathBuf> {
        self.link.clone().or_else(|| self.terminal())
    }

    /// The terminal itself; `None` while unplugged.
    #[must_use]
    pub fn terminal(&self) -> Option<PathBuf> {
        lock(&self.shared.slave).clone()
    }

    /// Injects faults.
    #[must_use]
    pub fn faults(&self) -> FaultHandle {
        FaultHandle::new(self.shared.clone())
    }

    /// What it has done so far.
    #[must_use]
    pub fn counters(&self) -> Counters {
        *lock(&self.shared.counters)
    }

    /// What the thread was granted; `None` before it runs or if nothing was asked for.
    #[must_use]
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
