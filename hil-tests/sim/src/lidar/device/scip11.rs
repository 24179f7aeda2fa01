//! SCIP 1.1: one status character, no checksums, no streams.

use super::sensor::Device;
use super::types::{BIT_RATES, Emission, Protocol};
use crate::lidar::command::{Section, number, section};
use crate::lidar::measurement::Measurement;
use crate::lidar::reports;

const OK: u8 = b'0';
const BAD_PARAMETER: u8 = b'1';
const UNDEFINED: u8 = b'E';
const LASER_OFF: u8 = b'6';
const BUSY: u8 = b'B';
/// Values have two characters.
const CHARACTERS: u32 = 2;
const LINE_CHARACTERS: usize = 64;

impl Device {
    /// `None` if the reply has to wait for a measurement.
    pub(super) fn answer_scip11(&mut self, line: &[u8]) -> Option<Emission> {
        let mut rate_after = None;
        let mut report = Vec::new();
        let status = match line {
            b"SCIP2.0" => {
                self.laser_off();
                self.protocol = Protocol::Scip20;
                OK
            }
            b"V" => {
                for line in reports::version_lines(&self.options.serial, "SCIP 1.1") {
                    report.extend_from_slice(line.as_bytes());
                    report.push(b'\n');
                }
                OK
            }
            b"L0" => {
                self.laser_off();
                OK
            }
            b"L1" => {
                self.laser = true;
                OK
            }
            // Six digits and seven reserved characters.
            [b'S', digits @ ..] if digits.len() == 6 || digits.len() == 13 => {
                let rate = number(&digits[..6]);
                let known = BIT_RATES.into_iter().find(|known| Some(*known) == rate);
                if let Some(rate) = known {
                    self.bit_rate = rate;
                    rate_after = known;
                    OK
                } else {
                    BAD_PARAMETER
                }
            }
            [b'G', digits @ ..] if digits.len() == 8 => match section(digits, CHARACTERS) {
                Err(_) => BAD_PARAMETER,
                Ok(_) if !self.laser => LASER_OFF,
                Ok(_) if self.request.is_some() => BUSY,
                Ok(section) => {
                    let Some(latest) = &self.latest else {
                        self.request = Some((line.to_vec(), section));
                        return None;
                    };
                    return Some(scan_reply(line, &section, latest));
                }
            },
            _ => UNDEFINED,
        };
        let mut bytes = status_lines(line, status);
        bytes.extend_from_slice(&report);
        bytes.push(b'\n');
        Some(Emission {
            bit_rate_after: rate_after,
            ..Emission::reply(bytes)
        })
    }
}

fn status_lines(line: &[u8], status: u8) -> Vec<u8> {
    let mut bytes = line.to_vec();
    bytes.extend_from_slice(&[b'\n', status, b'\n']);
    bytes
}

pub(super) fn scan_reply(line: &[u8], section: &Section, measurement: &Measurement) -> Emission {
    let mut bytes = status_lines(line, OK);
    for data in measurement.data(section).chunks(LINE_CHARACTERS) {
        bytes.extend_from_slice(data);
        bytes.push(b'\n');
    }
    bytes.push(b'\n');
    Emission::reply(bytes)
}
