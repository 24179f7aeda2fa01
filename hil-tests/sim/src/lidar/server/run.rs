//! The server's loop: requests, input, turns, output.

use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::options::LidarOptions;
use super::port::Port;
use crate::lidar::faults::{Request, Shared, lock};
use crate::lidar::sensor::Sensor;
use crate::range_source::RangeSource;
use crate::rt::monotonic_ns;

/// Longest wait when idle; injected faults take effect within this time.
const IDLE_WAIT_NS: u64 = 5_000_000;
/// Longest wait while bytes are being sent.
const SENDING_WAIT_NS: u64 = 1_000_000;

pub(super) struct Runner {
    shared: Arc<Shared>,
    options: LidarOptions,
    port: Option<Port>,
    sensor: Sensor,
    unread_bytes: u64,
}

impl Runner {
    pub(super) fn new(
        shared: Arc<Shared>,
        source: Box<dyn RangeSource>,
        options: LidarOptions,
        port: Port,
        now_ns: u64,
    ) -> Runner {
        Runner {
            shared,
            port: Some(port),
            sensor: Sensor::new(source, options.device.clone(), options.seed, now_ns),
            options,
            unread_bytes: 0,
        }
    }

    pub(super) fn run(mut self) {
        while !self.shared.stop.load(Ordering::Relaxed) {
            let now_ns = monotonic_ns();
            self.handle_requests(now_ns);
            // The kernel is asked once a round.
            let host_bit_rate = { self.port.as_ref() }.map_or(0, |port| port.pty().host_bit_rate());
            if let Err(error) = self
                .listen(host_bit_rate, now_ns)
                .and_then(|()| self.turn_and_send(host_bit_rate, now_ns))
            {
                self.report(format!("terminal failed: {error}"));
                self.unplug();
            }
            self.publish(host_bit_rate);
            self.wait(now_ns);
        }
        self.unplug();
    }

    fn handle_requests(&mut self, now_ns: u64) {
        loop {
            let request = lock(&self.shared.requests).pop_front();
            match request {
                None => return,
                Some(Request::Unplug) => self.unplug(),
                Some(Request::Replug) => self.replug(now_ns),
                Some(Request::Disturb(disturbance)) => self.sensor.disturb(disturbance, now_ns),
            }
        }
    }

    /// Takes what the host has sent.
    fn listen(&mut self, host_bit_rate: u32, now_ns: u64) -> io::Result<()> {
        let Some(port) = &self.port else {
            return Ok(());
        };
        let mut buffer = [0; 512];
        let count = port.pty().read(&mut buffer)?;
        self.sensor
            .hear(&mut buffer[..count], host_bit_rate, now_ns);
        Ok(())
    }

    fn turn_and_send(&mut self, host_bit_rate: u32, now_ns: u64) -> io::Result<()> {
        let Some(port) = &mut self.port else {
            return Ok(());
        };
        self.sensor.turn(now_ns);
        self.unread_bytes += port.send(&mut self.sensor, host_bit_rate, now_ns)?;
        Ok(())
    }

    fn unplug(&mut self) {
        self.port = None;
        self.sensor.power_off();
        *lock(&self.shared.slave) = None;
    }

    fn replug(&mut self, now_ns: u64) {
        if self.port.is_some() {
            return;
        }
        match Port::new(self.options.link.as_deref(), self.options.device.bit_rate) {
            Ok(port) => {
                *lock(&self.shared.slave) = Some(port.path().to_owned());
                self.port = Some(port);
                self.sensor.power_on(now_ns);
            }
            Err(error) => self.report(error.to_string()),
        }
    }

    fn report(&self, error: String) {
        *lock(&self.shared.error) = Some(error);
    }

    fn publish(&mut self, host_bit_rate: u32) {
        let mut counters = self.sensor.counters();
        counters.plugged = self.port.is_some();
        counters.measuring &= counters.plugged;
        counters.streaming &= counters.plugged;
        counters.host_bit_rate = if counters.plugged { host_bit_rate } else { 0 };
        counters.unread_bytes = self.unread_bytes;
        *lock(&self.shared.counters) = counters;
    }

    /// Sleeps until the host sends, the next turn is measured, or bytes may leave.
    fn wait(&self, now_ns: u64) {
        let wait_ns = if self.port.is_none() || self.sensor.is_frozen() {
            IDLE_WAIT_NS
        } else {
            let until_turn_ns = self.sensor.measured_ns().saturating_sub(now_ns);
            let idle = self.sensor.is_silent();
            until_turn_ns.min(if idle { IDLE_WAIT_NS } else { SENDING_WAIT_NS })
        };
        let timeout = Timespec {
            tv_sec: 0,
            tv_nsec: wait_ns as _,
        };
        // An interrupted or failed wait only starts the next round earlier.
        let _ = match &self.port {
            Some(port) => {
                let mut fds = [PollFd::from_borrowed_fd(port.pty().fd(), PollFlags::IN)];
                poll(&mut fds, Some(&timeout))
            }
            None => poll(&mut [], Some(&timeout)),
        };
    }
}
