//! The server's loop: requests, input, turns, output.

use std::io;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::options::LidarOptions;
use super::port::Port;
use crate::lidar::device::{Device, DeviceOptions, Emission, Kind};
use crate::lidar::faults::{Counters, Request, Shared, lock};
use crate::lidar::line::Line;
use crate::range_source::{RANGE_STEPS, RangeSource, STEPS_PER_TURN};
use crate::rt::monotonic_ns;
use crate::world::Random;

/// Longest wait when idle; injected faults take effect within this time.
const IDLE_WAIT_NS: u64 = 5_000_000;
/// Longest wait while bytes are being sent.
const SENDING_WAIT_NS: u64 = 1_000_000;
const GARBAGE_STREAM: u64 = 2 << 32;
/// Most random bytes sent at once.
const MAX_GARBAGE: usize = 32 * 1024;

pub(super) struct Runner {
    shared: Arc<Shared>,
    source: Box<dyn RangeSource>,
    options: LidarOptions,
    port: Option<Port>,
    device: Device,
    line: Line,
    random: Random,
    turn_start_ns: u64,
    readings_mm: Box<[u16; RANGE_STEPS]>,
    emissions: Vec<Emission>,
    truncate_scans: u32,
    corrupt_scans: u32,
    frozen: bool,
    silent_until_ns: u64,
    counters: Counters,
    /// Of the devices before the last power-up.
    earlier_dropped_scans: u64,
    earlier_lost_bytes: u64,
}

impl Runner {
    pub(super) fn new(
        shared: Arc<Shared>,
        source: Box<dyn RangeSource>,
        options: LidarOptions,
        port: Port,
        now_ns: u64,
    ) -> Runner {
        let device = Device::new(options.device.clone(), now_ns);
        Runner {
            shared,
            source,
            port: Some(port),
            line: Line::new(device.bit_rate()),
            device,
            random: Random::new(options.seed, GARBAGE_STREAM),
            options,
            turn_start_ns: now_ns,
            readings_mm: Box::new([0; RANGE_STEPS]),
            emissions: Vec::new(),
            truncate_scans: 0,
            corrupt_scans: 0,
            frozen: false,
            silent_until_ns: 0,
            counters: Counters::default(),
            earlier_dropped_scans: 0,
            earlier_lost_bytes: 0,
        }
    }

    pub(super) fn run(mut self) {
        while !self.shared.stop.load(Ordering::Relaxed) {
            let now_ns = monotonic_ns();
            self.handle_requests(now_ns);
            if let Err(error) = self
                .listen(now_ns)
                .and_then(|()| self.turn_and_send(now_ns))
            {
                self.report(format!("terminal failed: {error}"));
                self.unplug();
            }
            self.publish();
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
                Some(Request::Garbage { bytes }) => {
                    let count = bytes.min(MAX_GARBAGE);
                    let bytes = (0..count).map(|_| self.random.byte()).collect();
                    let garbage = Emission {
                        bytes,
                        kind: Kind::Reply,
                        bit_rate_after: None,
                    };
                    self.line.push(garbage, now_ns);
                }
                Some(Request::TruncateScans { scans }) => self.truncate_scans = scans,
                Some(Request::CorruptScans { scans }) => self.corrupt_scans = scans,
                Some(Request::Freeze { frozen }) => self.frozen = frozen,
                Some(Request::Silence { duration }) => {
                    let duration_ns = u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX);
                    self.silent_until_ns = now_ns.saturating_add(duration_ns);
                }
            }
        }
    }

    /// Takes what the host has sent. At another bit rate it arrives as noise and broken characters.
    fn listen(&mut self, now_ns: u64) -> io::Result<()> {
        let Some(port) = &self.port else {
            return Ok(());
        };
        let mut buffer = [0; 512];
        let count = port.pty().read(&mut buffer)?;
        if count == 0 || self.frozen {
            return Ok(());
        }
        let bytes = &mut buffer[..count];
        if port.pty().host_bit_rate() == self.line.bit_rate() {
            self.device.receive(bytes, now_ns, &mut self.emissions);
        } else {
            bytes.fill_with(|| self.random.byte());
            self.counters.garbled_bytes += count as u64;
            self.device.receive(bytes, now_ns, &mut self.emissions);
            self.device.framing_error();
        }
        self.queue_emissions(now_ns);
        Ok(())
    }

    fn turn_and_send(&mut self, now_ns: u64) -> io::Result<()> {
        if self.port.is_some() && now_ns >= self.measured_ns() {
            self.turn(now_ns);
        }
        let Some(port) = &mut self.port else {
            return Ok(());
        };
        if self.frozen {
            return Ok(());
        }
        let silent = now_ns < self.silent_until_ns;
        let sent = port.send(&mut self.line, now_ns, silent, &mut self.random)?;
        self.counters.bytes += sent.bytes;
        self.counters.garbled_bytes += sent.garbled;
        self.counters.unread_bytes += sent.unread;
        Ok(())
    }

    /// When the last step of the present turn has been measured.
    fn measured_ns(&self) -> u64 {
        self.turn_start_ns + self.device.turn_ns() / STEPS_PER_TURN as u64 * RANGE_STEPS as u64
    }

    fn turn(&mut self, now_ns: u64) {
        let turn_ns = self.device.turn_ns();
        let late_turns = now_ns.saturating_sub(self.measured_ns()) / turn_ns;
        self.counters.missed_turns += late_turns;
        self.turn_start_ns += late_turns * turn_ns;
        if self.device.is_measuring() && !self.frozen {
            let (start_ns, readings_mm) = (self.turn_start_ns, &mut *self.readings_mm);
            self.source.measure(start_ns, turn_ns, readings_mm);
            self.counters.measured_turns += 1;
            let busy = self.line.is_busy();
            self.device
                .turn_measured(start_ns, readings_mm, busy, &mut self.emissions);
            self.queue_emissions(now_ns);
        }
        self.turn_start_ns += turn_ns;
    }

    fn queue_emissions(&mut self, now_ns: u64) {
        for mut emission in self.emissions.drain(..) {
            if emission.kind == Kind::Scan {
                self.counters.scans += 1;
                let middle = emission.bytes.len() / 2;
                if self.truncate_scans > 0 {
                    self.truncate_scans -= 1;
                    emission.bytes.truncate(middle);
                } else if self.corrupt_scans > 0 {
                    self.corrupt_scans -= 1;
                    corrupt(&mut emission.bytes[middle..]);
                }
            }
            self.line.push(emission, now_ns);
        }
    }

    fn unplug(&mut self) {
        self.port = None;
        self.line.clear();
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
            }
            Err(error) => return self.report(error.to_string()),
        }
        self.earlier_dropped_scans += self.device.dropped_scans();
        self.earlier_lost_bytes += self.line.lost_bytes();
        let options = DeviceOptions {
            streaming: false,
            ..self.options.device.clone()
        };
        self.device = Device::new(options, now_ns);
        self.line = Line::new(self.device.bit_rate());
        self.turn_start_ns = now_ns;
        self.frozen = false;
    }

    fn report(&self, error: String) {
        *lock(&self.shared.error) = Some(error);
    }

    fn publish(&mut self) {
        let c = &mut self.counters;
        c.plugged = self.port.is_some();
        c.measuring = c.plugged && self.device.is_measuring();
        c.streaming = c.plugged && self.device.is_streaming();
        c.bit_rate = self.line.bit_rate();
        c.host_bit_rate = self
            .port
            .as_ref()
            .map_or(0, |port| port.pty().host_bit_rate());
        c.dropped_scans = self.earlier_dropped_scans + self.device.dropped_scans();
        c.lost_bytes = self.earlier_lost_bytes + self.line.lost_bytes();
        *lock(&self.shared.counters) = *c;
    }

    /// Sleeps until the host sends, the next turn is measured, or bytes may leave.
    fn wait(&self, now_ns: u64) {
        let wait_ns = if self.port.is_none() || self.frozen {
            IDLE_WAIT_NS
        } else {
            let until_turn_ns = self.measured_ns().saturating_sub(now_ns);
            let idle = self.line.is_idle();
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

/// Flips a bit of the first data character, which stays in SCIP's alphabet and so only shows in the checksum.
fn corrupt(bytes: &mut [u8]) {
    if let Some(byte) = bytes.iter_mut().find(|byte| (0x30..0x70).contains(*byte)) {
        *byte = ((*byte - 0x30) ^ 1) + 0x30;
    }
}
