//! A robot's lidar in memory: the simulated sensor, and lines to it.

use std::collections::VecDeque;
use std::io;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use drivers::Clock;
use drivers::hokuyo::{ConnectError, Gone, SerialLine, Wait};
use onboard::activities::lidar::OpenLine;
use sim::lidar::{DeviceOptions, Disturbance, Sensor};
use sim::world::{Random, RangeModel, RobotHandle};

use super::thread::ThreadClock;
use super::work::of_a_device;

/// What the system keeps of what nobody has read yet.
const MAX_UNREAD: usize = 4000;
/// A sensor's phase comes from the seed,
const PHASE_STREAM: u64 = 0x4C49_4441;
/// and is part of a turn of this length.
const TURN_NS: f64 = 100e6;

/// A lidar; it outlives the processes of its robot.
#[derive(Clone)]
pub(super) struct Lidar {
    wire: Arc<Mutex<Wire>>,
}

struct Wire {
    sensor: Sensor,
    plugged: bool,
    /// What it sends arrives this much later,
    delay_ns: u64,
    /// and later and later since this time, by this share of the time that passes,
    growth: Option<(u64, f64)>,
    /// and is on its way until then.
    delayed: VecDeque<(u64, Vec<u8>)>,
    /// Share of scans that break.
    broken_share: f64,
    random: Random,
    /// The process that has opened the line.
    host: Option<Host>,
    /// How often it was opened.
    opened: u64,
}

struct Host {
    /// Tells it from those before.
    number: u64,
    bit_rate: u32,
    received: VecDeque<u8>,
}

impl Lidar {
    /// A lidar that has had power for a part of a turn.
    pub(super) fn new(robot: &RobotHandle, seed: u64, now_ns: u64) -> Self {
        let mut random = Random::new(seed, PHASE_STREAM + robot.index() as u64);
        let source = robot.range_source(RangeModel::default());
        let since_ns = now_ns.saturating_sub((random.unit() * TURN_NS) as u64);
        let options = DeviceOptions::default();
        let wire = Wire {
            sensor: Sensor::new(Box::new(source), options, seed, since_ns),
            plugged: true,
            delay_ns: 0,
            growth: None,
            delayed: VecDeque::new(),
            broken_share: 0.0,
            random,
            host: None,
            opened: 0,
        };
        Self {
            wire: Arc::new(Mutex::new(wire)),
        }
    }

    /// What goes on in a step: turns, and what is sent while nobody listens.
    pub(super) fn cycle(&self, now_ns: u64) {
        let wire = &mut *lock(&self.wire);
        if wire.plugged {
            wire.turn(now_ns);
            if wire.host.is_none() {
                wire.speak(now_ns);
            }
        }
    }

    /// From now on this share of scans breaks.
    pub(super) fn break_scans(&self, share: f64) {
        lock(&self.wire).broken_share = share;
    }

    /// From now on what it sends arrives this much later.
    pub(super) fn delay(&self, by_ns: u64) {
        lock(&self.wire).delay_ns = by_ns;
    }

    /// From now on what it sends arrives later and later, by this share of the time that passes; 0 ends that.
    pub(super) fn delay_more_and_more(&self, share: f64, now_ns: u64) {
        lock(&self.wire).growth = (share > 0.0).then_some((now_ns, share));
    }

    /// When the turn began that it measures now, or waits to end.
    pub(super) fn turn_start_ns(&self) -> u64 {
        lock(&self.wire).sensor.turn_start_ns()
    }

    /// Disturbs it, once.
    pub(super) fn disturb(&self, disturbance: Disturbance, now_ns: u64) {
        lock(&self.wire).sensor.disturb(disturbance, now_ns);
    }

    /// Somebody pulls its cable, through which it also gets its power.
    pub(super) fn unplug(&self) {
        let wire = &mut *lock(&self.wire);
        wire.plugged = false;
        wire.delayed.clear();
        wire.sensor.power_off();
    }

    /// Somebody plugs it in again.
    pub(super) fn plug_in(&self, now_ns: u64) {
        let wire = &mut *lock(&self.wire);
        if !std::mem::replace(&mut wire.plugged, true) {
            wire.sensor.power_on(now_ns);
        }
    }

    /// The process that has opened the line is gone, without a farewell.
    pub(super) fn hang_up(&self) {
        lock(&self.wire).host = None;
    }

    /// How a robot's process opens its line at a bit rate; `path` names it.
    pub(super) fn opener(&self, clock: &Arc<ThreadClock>, path: &Path, bit_rate: u32) -> OpenLine {
        let (wire, clock) = (Arc::clone(&self.wire), Arc::clone(clock));
        let path = path.to_owned();
        Box::new(move || {
            let inside = &mut *lock(&wire);
            if !inside.plugged {
                return Err(ConnectError::Disconnected { path: path.clone() });
            }
            inside.opened += 1;
            inside.host = Some(Host {
                number: inside.opened,
                bit_rate,
                received: VecDeque::new(),
            });
            Ok(Box::new(MemoryLine {
                wire: Arc::clone(&wire),
                number: inside.opened,
                clock: Arc::clone(&clock),
            }))
        })
    }
}

fn lock(wire: &Mutex<Wire>) -> MutexGuard<'_, Wire> {
    wire.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Wire {
    fn turn(&mut self, now_ns: u64) {
        if now_ns >= self.sensor.measured_ns() {
            if self.broken_share > 0.0 && self.random.unit() < self.broken_share {
                let broken = if self.random.unit() < 0.5 {
                    Disturbance::CorruptScans { scans: 1 }
                } else {
                    Disturbance::TruncateScans { scans: 1 }
                };
                self.sensor.disturb(broken, now_ns);
            }
            self.sensor.turn(now_ns);
        }
    }

    /// Hands the host what has arrived by now.
    fn speak(&mut self, now_ns: u64) {
        let (host, sensor) = (&mut self.host, &mut self.sensor);
        let grown_ns = self.growth.map_or(0.0, |(since_ns, share)| {
            now_ns.saturating_sub(since_ns) as f64 * share
        });
        let delay_ns = self.delay_ns + grown_ns as u64;
        let delayed = &mut self.delayed;
        let bit_rate = host.as_ref().map_or(0, |host| host.bit_rate);
        let spoken = sensor.speak(now_ns, bit_rate, |bytes| {
            // What nobody listens to is lost.
            let Some(host) = host else {
                return Ok(bytes.len());
            };
            if delay_ns > 0 || !delayed.is_empty() {
                delayed.push_back((now_ns + delay_ns, bytes.to_vec()));
                return Ok(bytes.len());
            }
            let room = MAX_UNREAD.saturating_sub(host.received.len());
            let bytes = &bytes[..bytes.len().min(room)];
            host.received.extend(bytes);
            Ok(bytes.len())
        });
        if let Some(host) = host {
            while self
                .delayed
                .front()
                .is_some_and(|(at_ns, _)| *at_ns <= now_ns)
            {
                let arrived = self.delayed.pop_front();
                host.received
                    .extend(arrived.iter().flat_map(|(_, bytes)| bytes));
            }
        } else {
            self.delayed.clear();
        }
        debug_assert!(spoken.is_ok(), "memory takes everything");
    }
}

#[derive(Debug)]
struct MemoryLine {
    wire: Arc<Mutex<Wire>>,
    number: u64,
    clock: Arc<ThreadClock>,
}

impl std::fmt::Debug for Wire {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a lidar in memory")
    }
}

impl MemoryLine {
    /// What is at the other end, as of now.
    fn with<R>(&self, use_it: impl FnOnce(&mut Sensor, &mut Host) -> R) -> Result<R, Gone> {
        of_a_device(|| self.at_the_end(use_it))
    }

    fn at_the_end<R>(&self, use_it: impl FnOnce(&mut Sensor, &mut Host) -> R) -> Result<R, Gone> {
        let wire = &mut *lock(&self.wire);
        if wire.plugged {
            wire.speak(self.clock.world_ns());
        }
        let host = { wire.host.as_mut() }.filter(|host| host.number == self.number);
        match host {
            // Bytes that came before it was unplugged are still read.
            Some(host) if wire.plugged || !host.received.is_empty() => {
                Ok(use_it(&mut wire.sensor, host))
            }
            _ => Err(Gone),
        }
    }
}

impl SerialLine for MemoryLine {
    fn set_bit_rate(&mut self, bit_rate: u32) -> io::Result<()> {
        self.with(|_, host| host.bit_rate = bit_rate)
            .map_err(|Gone| io::ErrorKind::BrokenPipe.into())
    }

    fn clear(&mut self) {
        // A line that is gone says so when it is read next.
        let _ = self.with(|_, host| host.received.clear());
    }

    fn wait(&mut self, deadline_ns: u64) -> Result<Wait, Gone> {
        loop {
            if self.with(|_, host| !host.received.is_empty())? {
                return Ok(Wait::Ready);
            }
            if self.clock.now_ns() >= deadline_ns {
                return Ok(Wait::TimedOut);
            }
            self.clock.wait_a_step(deadline_ns);
        }
    }

    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Gone> {
        self.with(|_, host| {
            let count = host.received.len().min(buffer.len());
            for (place, byte) in buffer.iter_mut().zip(host.received.drain(..count)) {
                *place = byte;
            }
            count
        })
    }

    fn write(&mut self, bytes: &[u8], _deadline_ns: u64) -> Result<bool, Gone> {
        let now_ns = self.clock.world_ns();
        self.with(|sensor, host| {
            sensor.hear(&mut bytes.to_vec(), host.bit_rate, now_ns);
            true
        })
    }

    fn unsent_bytes(&self) -> u32 {
        0
    }

    fn clock(&self) -> Arc<dyn Clock> {
        Arc::clone(&self.clock) as _
    }
}

impl Drop for MemoryLine {
    fn drop(&mut self) {
        let wire = &mut *lock(&self.wire);
        if wire
            .host
            .as_ref()
            .is_some_and(|host| host.number == self.number)
        {
            wire.host = None;
        }
    }
}
