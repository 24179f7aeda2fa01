//! The sensor's firmware: SCIP 1.1 and 2.0 as a state machine without I/O and without a clock of its own.
//!
//! Commands are answered at once. A turn's readings are handed in when it has been measured; what becomes of them
//! depends on the laser, a running stream and a waiting request.

use super::codec::{checksum, encode, summed_line};
use super::command::{Command, OK, STRING_TOO_LONG, Section, Status, UNDEFINED, parse};
use super::measurement::Measurement;
use super::reports;
use crate::world::RANGE_STEPS;

mod scip11;
mod types;

pub use types::{BIT_RATES, DeviceOptions, Emission, Kind, Protocol};

const INITIAL_RPM: u32 = 600;
const RPM_PER_LEVEL: u32 = 6;
const TIMER_BITS: u32 = 24;
/// Longer than any command; what is longer cannot become one.
const MAX_LINE: usize = 64;

#[derive(Debug, Clone)]
struct Stream {
    /// The echo up to the number of scans, and what follows it.
    echo: Vec<u8>,
    string: Vec<u8>,
    section: Section,
    skip: u32,
    skipped: u32,
    /// Scans still to send; `None` for ever.
    remaining: Option<u32>,
    since_ns: u64,
}

/// The state machine.
#[derive(Debug, Clone)]
pub struct Device {
    options: DeviceOptions,
    protocol: Protocol,
    laser: bool,
    adjusting_time: bool,
    stream: Option<Stream>,
    /// A GD, GS or G that waits for the first turn: its echo and section.
    request: Option<(Vec<u8>, Section)>,
    latest: Option<Box<Measurement>>,
    bit_rate: u32,
    speed_level: u32,
    timer_ms: u32,
    timer_zero_ns: u64,
    line: Vec<u8>,
    line_too_long: bool,
    dropped_scans: u64,
}

impl Device {
    /// Powers up. A bit rate it does not know becomes the slowest.
    pub fn new(options: DeviceOptions, now_ns: u64) -> Device {
        let bit_rate = *BIT_RATES
            .iter()
            .find(|rate| **rate == options.bit_rate)
            .unwrap_or(&BIT_RATES[0]);
        let protocol = if options.streaming {
            Protocol::Scip20
        } else {
            options.protocol
        };
        let mut device = Device {
            protocol,
            laser: protocol == Protocol::Scip11,
            adjusting_time: false,
            stream: None,
            request: None,
            latest: None,
            bit_rate,
            speed_level: 0,
            timer_ms: options.timer_ms,
            timer_zero_ns: now_ns,
            line: Vec::with_capacity(MAX_LINE),
            line_too_long: false,
            dropped_scans: 0,
            options,
        };
        if device.options.streaming {
            // The acknowledgement went to the host that is gone.
            device.receive(b"MD0044072501000\n", now_ns, &mut Vec::new());
        }
        device.options.bit_rate = bit_rate;
        device
    }

    /// The laser is on: every turn is to be measured.
    pub fn is_measuring(&self) -> bool {
        self.laser
    }

    /// A stream runs.
    pub fn is_streaming(&self) -> bool {
        self.stream.is_some()
    }

    /// The language it speaks.
    pub fn protocol(&self) -> Protocol {
        self.protocol
    }

    /// The bit rate it will have when everything emitted so far is sent.
    pub fn bit_rate(&self) -> u32 {
        self.bit_rate
    }

    /// Duration of a turn at the present motor speed.
    pub fn turn_ns(&self) -> u64 {
        60_000_000_000 / u64::from(self.rpm())
    }

    /// Scans of a stream that a busy line had no room for.
    pub fn dropped_scans(&self) -> u64 {
        self.dropped_scans
    }

    /// The timer, in ms.
    pub fn timer_ms(&self, at_ns: u64) -> u32 {
        let age_ns = at_ns.saturating_sub(self.timer_zero_ns);
        let drift_ns = age_ns as f64 * self.options.timer_drift_ppm * 1e-6;
        let age_ms = age_ns.saturating_add_signed(drift_ns as i64) / 1_000_000;
        (age_ms.wrapping_add(u64::from(self.timer_ms)) & ((1 << TIMER_BITS) - 1)) as u32
    }

    /// Takes bytes from the host.
    pub fn receive(&mut self, bytes: &[u8], now_ns: u64, out: &mut Vec<Emission>) {
        for byte in bytes {
            match byte {
                b'\n' | b'\r' => {
                    let line = std::mem::take(&mut self.line);
                    let too_long = std::mem::take(&mut self.line_too_long);
                    if !line.is_empty() {
                        self.answer(&line, too_long, now_ns, out);
                    }
                }
                _ if self.line.len() < MAX_LINE => self.line.push(*byte),
                _ => self.line_too_long = true,
            }
        }
    }

    /// The line broke off in the middle of a character: what was received of a command is lost.
    pub fn framing_error(&mut self) {
        self.line.clear();
        self.line_too_long = false;
    }

    /// Takes the readings of a turn that has been measured. With `line_busy` a stream's scan is dropped and counted.
    pub fn turn_measured(
        &mut self,
        turn_start_ns: u64,
        readings_mm: &[u16; RANGE_STEPS],
        line_busy: bool,
        out: &mut Vec<Emission>,
    ) {
        if !self.laser {
            return;
        }
        let measurement = Box::new(Measurement {
            device_ms: self.timer_ms(turn_start_ns),
            readings_mm: *readings_mm,
        });
        if let Some((echo, section)) = self.request.take() {
            out.push(self.scan_reply(&echo, &section, &measurement));
        }
        self.stream_scan(turn_start_ns, &measurement, line_busy, out);
        if self.laser {
            self.latest = Some(measurement);
        }
    }

    fn stream_scan(
        &mut self,
        turn_start_ns: u64,
        measurement: &Measurement,
        line_busy: bool,
        out: &mut Vec<Emission>,
    ) {
        let Some(stream) = &mut self.stream else {
            return;
        };
        if turn_start_ns < stream.since_ns {
            return;
        }
        if stream.skipped > 0 {
            stream.skipped -= 1;
            return;
        }
        if line_busy {
            self.dropped_scans += 1;
            return;
        }
        stream.skipped = stream.skip;
        let remaining = stream.remaining.map(|scans| scans.saturating_sub(1));
        stream.remaining = remaining;
        let mut bytes = stream.echo.clone();
        bytes.extend_from_slice(format!("{:02}", remaining.unwrap_or(0)).as_bytes());
        bytes.extend_from_slice(&stream.string);
        bytes.push(b'\n');
        summed_line(b"99", &mut bytes);
        measurement.write(&stream.section, &mut bytes);
        out.push(Emission {
            bytes,
            kind: Kind::Scan,
            bit_rate_after: None,
        });
        if remaining == Some(0) {
            self.laser_off();
        }
    }

    fn answer(&mut self, line: &[u8], too_long: bool, now_ns: u64, out: &mut Vec<Emission>) {
        let emission = match self.protocol {
            Protocol::Scip11 => self.answer_scip11(line),
            Protocol::Scip20 if too_long => Some(refusal(line, STRING_TOO_LONG)),
            Protocol::Scip20 => match parse(line) {
                Ok(command) => self.execute(command, line, now_ns),
                Err(_) if self.adjusting_time => Some(refusal(line, UNDEFINED)),
                Err(status) => Some(refusal(line, status)),
            },
        };
        out.extend(emission);
    }

    /// `None` if the reply has to wait for a measurement.
    fn execute(&mut self, command: Command, line: &[u8], now_ns: u64) -> Option<Emission> {
        if self.adjusting_time && !matches!(command, Command::Time(_)) {
            return Some(refusal(line, UNDEFINED));
        }
        let mut rate_after = None;
        let mut report = Vec::new();
        let status = match command {
            Command::Version => {
                reports::version(&self.options.serial, &mut report);
                OK
            }
            Command::Parameters => {
                reports::parameters(&mut report);
                OK
            }
            Command::State => {
                reports::state(&self.state(now_ns), &mut report);
                OK
            }
            Command::LaserOn if self.laser => *b"02",
            Command::LaserOn => {
                self.laser = true;
                OK
            }
            Command::Quit => {
                self.laser_off();
                OK
            }
            Command::Reset => {
                self.laser_off();
                self.speed_level = 0;
                (self.timer_ms, self.timer_zero_ns) = (0, now_ns);
                self.bit_rate = self.options.bit_rate;
                rate_after = Some(self.bit_rate);
                OK
            }
            Command::Time(b'1') if self.adjusting_time => {
                let mut stamp = Vec::with_capacity(4);
                encode(self.timer_ms(now_ns), 4, &mut stamp);
                summed_line(&stamp, &mut report);
                OK
            }
            Command::Time(code) => self.adjust_time(code),
            Command::BitRate(rate) => {
                let status = self.change_bit_rate(rate);
                rate_after = (status == OK).then_some(self.bit_rate);
                status
            }
            Command::MotorSpeed(level) => self.change_speed(level),
            Command::Get(_) if !self.laser => *b"10",
            Command::Get(_) if self.request.is_some() => *b"0B",
            Command::Get(section) => {
                let Some(latest) = &self.latest else {
                    self.request = Some((line.to_vec(), section));
                    return None;
                };
                return Some(self.scan_reply(line, &section, latest));
            }
            Command::Stream {
                section,
                skip,
                count,
            } => {
                self.start_stream(line, section, skip, count, now_ns);
                OK
            }
        };
        let mut bytes = status_lines(line, status);
        bytes.extend_from_slice(&report);
        bytes.push(b'\n');
        Some(Emission {
            bytes,
            kind: Kind::Reply,
            bit_rate_after: rate_after,
        })
    }

    fn scan_reply(&self, line: &[u8], section: &Section, measurement: &Measurement) -> Emission {
        if self.protocol == Protocol::Scip11 {
            return scip11::scan_reply(line, section, measurement);
        }
        let mut bytes = status_lines(line, OK);
        measurement.write(section, &mut bytes);
        reply(bytes)
    }

    fn start_stream(&mut self, line: &[u8], section: Section, skip: u32, count: u32, now_ns: u64) {
        // Symbol, start, end, cluster and skip are 13 characters; the number of scans two more.
        self.laser = true;
        self.stream = Some(Stream {
            echo: line[..13].to_vec(),
            string: line[15..].to_vec(),
            section,
            skip,
            skipped: 0,
            remaining: (count > 0).then_some(count),
            since_ns: now_ns,
        });
    }

    fn adjust_time(&mut self, code: u8) -> Status {
        match (code, self.adjusting_time) {
            (b'0', false) => {
                self.laser_off();
                self.adjusting_time = true;
                OK
            }
            (b'2', true) => {
                self.adjusting_time = false;
                OK
            }
            (b'0', true) => *b"02",
            (b'2', false) => *b"03",
            (b'1', _) => *b"04",
            _ => *b"01",
        }
    }

    fn change_bit_rate(&mut self, rate: Option<u32>) -> Status {
        match rate {
            None => *b"01",
            Some(rate) if rate == self.bit_rate => *b"03",
            Some(rate) if BIT_RATES.contains(&rate) => {
                self.bit_rate = rate;
                OK
            }
            Some(38_400) => *b"04",
            Some(_) => *b"02",
        }
    }

    fn change_speed(&mut self, level: Option<u32>) -> Status {
        let level = match level {
            None => return *b"01",
            Some(99) => 0,
            Some(level) if level <= 10 => level,
            Some(_) => return *b"02",
        };
        if level == self.speed_level {
            return *b"03";
        }
        self.speed_level = level;
        OK
    }

    fn laser_off(&mut self) {
        self.laser = false;
        self.stream = None;
        self.request = None;
        self.latest = None;
    }

    fn rpm(&self) -> u32 {
        INITIAL_RPM - RPM_PER_LEVEL * self.speed_level
    }

    fn state(&self, now_ns: u64) -> reports::State {
        reports::State {
            laser: self.laser,
            streaming: self.stream.is_some(),
            rpm: self.rpm(),
            speed_level: self.speed_level,
            bit_rate: self.bit_rate,
            bit_rate_changed: self.bit_rate != self.options.bit_rate,
            device_ms: self.timer_ms(now_ns),
        }
    }
}

/// The echo of a command and its status.
fn status_lines(line: &[u8], status: Status) -> Vec<u8> {
    let mut bytes = line.to_vec();
    bytes.push(b'\n');
    bytes.extend_from_slice(&status);
    bytes.push(checksum(&status));
    bytes.push(b'\n');
    bytes
}

fn refusal(line: &[u8], status: Status) -> Emission {
    let mut bytes = status_lines(line, status);
    bytes.push(b'\n');
    reply(bytes)
}

fn reply(bytes: Vec<u8>) -> Emission {
    Emission {
        bytes,
        kind: Kind::Reply,
        bit_rate_after: None,
    }
}

#[cfg(test)]
mod tests;
