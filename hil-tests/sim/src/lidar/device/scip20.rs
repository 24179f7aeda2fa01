//! SCIP 2.0: commands, their statuses and replies, as in Hokuyo's "Communication Protocol Specification for SCIP 2.0".

use super::sensor::{Device, Stream};
use super::types::{BIT_RATES, Emission, Kind};
use crate::lidar::codec::{checksum, encode, summed_line};
use crate::lidar::command::{OK, STRING_TOO_LONG, ScipCommand, Section, Status, UNDEFINED, parse};
use crate::lidar::measurement::Measurement;
use crate::lidar::reports;

impl Device {
    /// `None` if the reply has to wait for a measurement.
    pub(super) fn answer_scip20(
        &mut self,
        line: &[u8],
        too_long: bool,
        now_ns: u64,
    ) -> Option<Emission> {
        if too_long {
            return Some(refusal(line, STRING_TOO_LONG));
        }
        match parse(line) {
            Ok(command) => self.execute(command, line, now_ns),
            Err(_) if self.adjusting_time => Some(refusal(line, UNDEFINED)),
            Err(status) => Some(refusal(line, status)),
        }
    }

    fn execute(&mut self, command: ScipCommand, line: &[u8], now_ns: u64) -> Option<Emission> {
        let allowed = matches!(command, ScipCommand::Time(_) | ScipCommand::Activity);
        if self.adjusting_time && !allowed {
            return Some(refusal(line, UNDEFINED));
        }
        let mut rate_after = None;
        let mut report = Vec::new();
        let status = match command {
            ScipCommand::Version => {
                reports::version(&self.options.serial, &mut report);
                OK
            }
            ScipCommand::Parameters => {
                reports::parameters(&mut report);
                OK
            }
            ScipCommand::State => {
                reports::state(&self.state(now_ns), &mut report);
                OK
            }
            ScipCommand::Activity => {
                summed_line(self.activity(), &mut report);
                OK
            }
            ScipCommand::LaserOn if self.laser => *b"02",
            ScipCommand::LaserOn => {
                self.laser = true;
                OK
            }
            ScipCommand::Quit => {
                self.laser_off();
                OK
            }
            ScipCommand::Reset => {
                self.laser_off();
                self.speed_level = 0;
                (self.timer_ms, self.timer_zero_ns) = (0, now_ns);
                self.bit_rate = self.options.bit_rate;
                rate_after = Some(self.bit_rate);
                OK
            }
            ScipCommand::Time(b'1') if self.adjusting_time => {
                let mut stamp = Vec::with_capacity(4);
                encode(self.timer_ms(now_ns), 4, &mut stamp);
                summed_line(&stamp, &mut report);
                OK
            }
            ScipCommand::Time(code) => self.adjust_time(code),
            ScipCommand::BitRate(rate) => {
                let status = self.change_bit_rate(rate);
                rate_after = (status == OK).then_some(self.bit_rate);
                status
            }
            ScipCommand::MotorSpeed(level) => self.change_speed(level),
            ScipCommand::Get(_) if !self.laser => *b"10",
            ScipCommand::Get(_) if self.request.is_some() => *b"0B",
            ScipCommand::Get(section) => {
                let Some(latest) = &self.latest else {
                    self.request = Some((line.to_vec(), section));
                    return None;
                };
                return Some(scan_reply(line, &section, latest));
            }
            ScipCommand::Stream {
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

    /// Standing by, adjusting its time, measuring on request, or streaming.
    fn activity(&self) -> &'static [u8; 3] {
        match (self.adjusting_time, self.laser, &self.stream) {
            (true, ..) => b"002",
            (_, _, Some(_)) => b"004",
            (_, true, None) => b"003",
            (_, false, None) => b"000",
        }
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
            unwell: self.unwell,
        }
    }
}

pub(super) fn scan_reply(line: &[u8], section: &Section, measurement: &Measurement) -> Emission {
    let mut bytes = status_lines(line, OK);
    measurement.write(section, &mut bytes);
    Emission::reply(bytes)
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
    Emission::reply(bytes)
}
