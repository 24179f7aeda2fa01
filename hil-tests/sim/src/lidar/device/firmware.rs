//! Bytes and turns in, bytes out.
//!
//! Commands are answered at once. A turn's readings are handed in when it has been measured; what becomes of them
//! depends on the laser, a running stream and a waiting request.

use super::sensor::Device;
use super::types::{BIT_RATES, DeviceOptions, Emission, Kind, Protocol};
use super::{scip11, scip20};
use crate::lidar::codec::summed_line;
use crate::lidar::measurement::Measurement;
use crate::range_source::RANGE_STEPS;

/// Longest line kept; no command is longer.
pub(super) const MAX_LINE: usize = 64;

impl Device {
    /// Powers up. A bit rate it does not know becomes the slowest.
    #[must_use]
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
            unwell: false,
            options,
        };
        if device.options.streaming {
            // The acknowledgement went to the host that is gone.
            device.receive(b"MD0044072501000\n", now_ns, &mut Vec::new());
        }
        device.options.bit_rate = bit_rate;
        device
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

    /// From now on it says of itself that it does not work well, or that it does.
    pub fn be_unwell(&mut self, unwell: bool) {
        self.unwell = unwell;
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
            out.push(match self.protocol {
                Protocol::Scip11 => scip11::scan_reply(&echo, &section, &measurement),
                Protocol::Scip20 => scip20::scan_reply(&echo, &section, &measurement),
            });
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
            Protocol::Scip20 => self.answer_scip20(line, too_long, now_ns),
        };
        out.extend(emission);
    }
}
