//! A sensor at work: firmware, turns, line, and what goes wrong with them.
//!
//! Pure: times and bytes go in, bytes come out; nothing here waits or reads a clock. Whoever carries the bytes calls
//! [`Sensor::turn`] and [`Sensor::speak`] every millisecond or so, and [`Sensor::hear`] when the host has sent something.

use std::io;

use super::device::{Device, DeviceOptions, Emission, Kind};
use super::disturbance::Disturbance;
use super::faults::Counters;
use super::line::Line;
use crate::range_source::{RANGE_STEPS, RangeSource, STEPS_PER_TURN};
use crate::world::Random;

const GARBAGE_STREAM: u64 = 2 << 32;
/// One that repeats its scans again and again measures for so many turns each time that its laser is switched on.
const MEASURES_TURNS: u32 = 10;
/// Most random bytes sent at once.
const MAX_GARBAGE: usize = 32 * 1024;

/// A sensor at work.
pub struct Sensor {
    source: Box<dyn RangeSource>,
    options: DeviceOptions,
    device: Device,
    line: Line,
    random: Random,
    turn_start_ns: u64,
    readings_mm: Box<[u16; RANGE_STEPS]>,
    emissions: Vec<Emission>,
    truncate_scans: u32,
    corrupt_scans: u32,
    frozen: bool,
    covered: bool,
    repeats: bool,
    repeats_again: bool,
    /// Measured since the laser was switched on.
    turns: u32,
    unwell: bool,
    silent_until_ns: u64,
    counters: Counters,
    /// Of the devices before the last power-up.
    earlier_dropped_scans: u64,
    earlier_lost_bytes: u64,
}

impl Sensor {
    /// A sensor that powers up now; its first turn begins now.
    #[must_use]
    pub fn new(
        source: Box<dyn RangeSource>,
        options: DeviceOptions,
        seed: u64,
        now_ns: u64,
    ) -> Sensor {
        let device = Device::new(options.clone(), now_ns);
        Sensor {
            source,
            line: Line::new(device.bit_rate()),
            device,
            random: Random::new(seed, GARBAGE_STREAM),
            options,
            turn_start_ns: now_ns,
            readings_mm: Box::new([0; RANGE_STEPS]),
            emissions: Vec::new(),
            truncate_scans: 0,
            corrupt_scans: 0,
            frozen: false,
            covered: false,
            repeats: false,
            repeats_again: false,
            turns: 0,
            unwell: false,
            silent_until_ns: 0,
            counters: Counters::default(),
            earlier_dropped_scans: 0,
            earlier_lost_bytes: 0,
        }
    }

    /// Power goes: what was to be sent is gone.
    pub fn power_off(&mut self) {
        self.line.clear();
    }

    /// Power comes back.
    pub fn power_on(&mut self, now_ns: u64) {
        self.earlier_dropped_scans += self.device.dropped_scans();
        self.earlier_lost_bytes += self.line.lost_bytes();
        let options = DeviceOptions {
            streaming: false,
            ..self.options.clone()
        };
        self.device = Device::new(options, now_ns);
        self.device.be_unwell(self.unwell);
        self.line = Line::new(self.device.bit_rate());
        self.turn_start_ns = now_ns;
        (self.frozen, self.repeats, self.turns) = (false, false, 0);
    }

    /// Something goes wrong.
    pub fn disturb(&mut self, disturbance: Disturbance, now_ns: u64) {
        match disturbance {
            Disturbance::Garbage { bytes } => {
                let count = bytes.min(MAX_GARBAGE);
                let bytes = (0..count).map(|_| self.random.byte()).collect();
                let garbage = Emission {
                    bytes,
                    kind: Kind::Reply,
                    bit_rate_after: None,
                };
                self.line.push(garbage, now_ns);
            }
            Disturbance::TruncateScans { scans } => self.truncate_scans = scans,
            Disturbance::CorruptScans { scans } => self.corrupt_scans = scans,
            Disturbance::Freeze { frozen } => self.frozen = frozen,
            Disturbance::Cover { covered } => self.covered = covered,
            Disturbance::Repeat { repeats } => self.repeats = repeats,
            Disturbance::RepeatAgain { repeats } => {
                (self.repeats, self.repeats_again) = (repeats, repeats);
            }
            Disturbance::Unwell { unwell } => {
                self.unwell = unwell;
                self.device.be_unwell(unwell);
            }
            Disturbance::Silence { duration } => {
                let duration_ns = u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX);
                self.silent_until_ns = now_ns.saturating_add(duration_ns);
            }
        }
    }

    /// Whether it neither receives nor sends.
    #[must_use]
    pub fn is_frozen(&self) -> bool {
        self.frozen
    }

    /// Nothing waits to be sent.
    #[must_use]
    pub fn is_silent(&self) -> bool {
        self.line.is_idle()
    }

    /// When the present turn began.
    #[must_use]
    pub fn turn_start_ns(&self) -> u64 {
        self.turn_start_ns
    }

    /// When the last step of the present turn has been measured.
    #[must_use]
    pub fn measured_ns(&self) -> u64 {
        self.turn_start_ns + self.device.turn_ns() / STEPS_PER_TURN as u64 * RANGE_STEPS as u64
    }

    /// Takes what the host has sent at its bit rate. At another one it arrives as noise and broken characters.
    pub fn hear(&mut self, bytes: &mut [u8], host_bit_rate: u32, now_ns: u64) {
        if bytes.is_empty() || self.frozen {
            return;
        }
        let garbled = host_bit_rate != self.line.bit_rate();
        if garbled {
            bytes.fill_with(|| self.random.byte());
            self.counters.garbled_bytes += bytes.len() as u64;
        }
        self.device.receive(bytes, now_ns, &mut self.emissions);
        if garbled {
            self.device.framing_error();
        }
        if !self.device.is_measuring() {
            (self.repeats, self.turns) = (false, 0);
        }
        self.queue_emissions(now_ns);
    }

    /// Measures the present turn when its last step is over.
    pub fn turn(&mut self, now_ns: u64) {
        if now_ns < self.measured_ns() {
            return;
        }
        let turn_ns = self.device.turn_ns();
        let late_turns = now_ns.saturating_sub(self.measured_ns()) / turn_ns;
        self.counters.missed_turns += late_turns;
        self.turn_start_ns += late_turns * turn_ns;
        if self.device.is_measuring() && !self.frozen {
            let (start_ns, readings_mm) = (self.turn_start_ns, &mut *self.readings_mm);
            self.repeats |= self.repeats_again && self.turns >= MEASURES_TURNS;
            self.turns = self.turns.saturating_add(1);
            if !self.repeats {
                self.source.measure(start_ns, turn_ns, readings_mm);
            }
            if self.covered {
                readings_mm.fill(0);
            }
            self.counters.measured_turns += 1;
            let busy = self.line.is_busy();
            self.device
                .turn_measured(start_ns, readings_mm, busy, &mut self.emissions);
            self.queue_emissions(now_ns);
        }
        self.turn_start_ns += turn_ns;
    }

    /// Gives `write` what may have arrived by now at a host of this bit rate; garbled if the rates differ, and swallowed
    /// while the wire is silent. `write` returns how many bytes it took.
    ///
    /// # Errors
    /// Those of `write`.
    pub fn speak(
        &mut self,
        now_ns: u64,
        host_bit_rate: u32,
        mut write: impl FnMut(&[u8]) -> io::Result<usize>,
    ) -> io::Result<()> {
        if self.frozen {
            return Ok(());
        }
        let silent = now_ns < self.silent_until_ns;
        loop {
            let garbled = self.line.bit_rate() != host_bit_rate;
            let ready = self.line.ready(now_ns);
            if ready.is_empty() {
                return Ok(());
            }
            if silent {
                let swallowed = ready.len();
                self.line.advance(swallowed);
                continue;
            }
            let written = if garbled {
                let noise: Vec<u8> = ready.iter().map(|_| self.random.byte()).collect();
                write(&noise)?
            } else {
                write(ready)?
            };
            if written == 0 {
                return Ok(());
            }
            if self.line.ends_scan(written) {
                self.counters.scan_ended_ns = now_ns;
            }
            self.counters.bytes += written as u64;
            self.counters.garbled_bytes += if garbled { written as u64 } else { 0 };
            self.line.advance(written);
        }
    }

    /// What it has done so far; what concerns its cable and its host is left at its defaults.
    #[must_use]
    pub fn counters(&self) -> Counters {
        Counters {
            measuring: self.device.is_measuring(),
            streaming: self.device.is_streaming(),
            bit_rate: self.line.bit_rate(),
            dropped_scans: self.earlier_dropped_scans + self.device.dropped_scans(),
            lost_bytes: self.earlier_lost_bytes + self.line.lost_bytes(),
            ..self.counters
        }
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
}

/// Flips a bit of the first data character, which stays in SCIP's alphabet and so only shows in the checksum.
fn corrupt(bytes: &mut [u8]) {
    if let Some(byte) = bytes.iter_mut().find(|byte| (0x30..0x70).contains(*byte)) {
        *byte = ((*byte - 0x30) ^ 1) + 0x30;
    }
}
