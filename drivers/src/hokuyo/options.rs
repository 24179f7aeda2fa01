//! What the driver is asked to do, and whether the line can carry it.

use std::time::Duration;

use super::codec::Encoding;
use super::error::ConnectError;
use description::robot::{BIT_RATES, scan_bit_s, scan_bytes};

use super::identity::Parameters;
use super::scan::MAX_BEAMS;

/// The bit rates of [`BIT_RATES`] in the order in which a silent device is tried: the most likely ones first.
pub(super) const LIKELY_BIT_RATES: [u32; 7] =
    [115_200, 19_200, 750_000, 500_000, 250_000, 57_600, 38_400];

/// How to connect and what to measure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Options {
    /// Bit rate to switch the line to, one of [`BIT_RATES`]. USB has none of its own and takes any of them.
    pub bit_rate: u32,
    /// First step; by default the first that the device measures.
    pub first_step: Option<u16>,
    /// Last step; by default the last that the device measures.
    pub last_step: Option<u16>,
    /// Steps joined into one reading, of which the device reports the shortest; 0 and 1 join none, at most 99.
    pub cluster: u8,
    /// Turns left out between two scans, at most 9.
    pub skip: u8,
    /// Characters per reading.
    pub encoding: Encoding,
    /// Limit for connecting.
    pub connect_timeout: Duration,
    /// Limit for one reply.
    pub reply_timeout: Duration,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            bit_rate: 750_000,
            first_step: None,
            last_step: None,
            cluster: 1,
            skip: 0,
            encoding: Encoding::Three,
            connect_timeout: Duration::from_secs(3),
            reply_timeout: Duration::from_millis(400),
        }
    }
}

impl Options {
    /// Checks what can be checked without a device.
    ///
    /// # Errors
    /// [`ConnectError::Option`], naming the option.
    pub fn check(&self) -> Result<(), ConnectError> {
        let wrong = |option, expected: &str, found: String| {
            Err(ConnectError::Option {
                option,
                expected: expected.into(),
                found,
            })
        };
        if !BIT_RATES.contains(&self.bit_rate) {
            return wrong(
                "bit_rate",
                &format!("one of {BIT_RATES:?}"),
                self.bit_rate.to_string(),
            );
        }
        if self.cluster > 99 {
            return wrong("cluster", "0 to 99", self.cluster.to_string());
        }
        if self.skip > 9 {
            return wrong("skip", "0 to 9", self.skip.to_string());
        }
        if self.reply_timeout.is_zero() {
            return wrong("reply_timeout", "more than zero", "0".into());
        }
        if self.connect_timeout < self.reply_timeout {
            return wrong(
                "connect_timeout",
                "at least reply_timeout",
                format!("{:?}", self.connect_timeout),
            );
        }
        Ok(())
    }

    /// Checks these options against a device.
    ///
    /// # Errors
    /// Steps that the device does not measure; scans that do not fit through the line, with advice.
    pub fn format(&self, device: &Parameters) -> Result<ScanFormat, ConnectError> {
        self.check()?;
        let wrong = |option, expected: String, found: u16| ConnectError::Option {
            option,
            expected,
            found: found.to_string(),
        };
        let first_step = self.first_step.unwrap_or(device.amin);
        let last_step = self.last_step.unwrap_or(device.amax);
        if last_step > device.amax || last_step < device.amin {
            let expected = format!("a step of the device, {} to {}", device.amin, device.amax);
            return Err(wrong("last_step", expected, last_step));
        }
        if first_step < device.amin || first_step > last_step {
            let expected = format!("{} to {last_step}", device.amin);
            return Err(wrong("first_step", expected, first_step));
        }
        let format = ScanFormat {
            first_step,
            last_step,
            cluster: self.cluster.max(1),
            skip: self.skip,
            encoding: self.encoding,
        };
        if format.beams() > MAX_BEAMS && self.last_step.is_none() {
            return Err(ConnectError::TooManyBeams {
                model: device.model.clone(),
                beams: format.beams(),
                most: MAX_BEAMS,
            });
        }
        if format.beams() > MAX_BEAMS {
            let expected = format!("a number of beams up to {MAX_BEAMS}");
            return Err(wrong("last_step", expected, last_step));
        }
        format.check_fits(self.bit_rate, device.scan_hz())?;
        Ok(format)
    }
}

/// The shape of one scan on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScanFormat {
    /// Step of the first reading.
    pub first_step: u16,
    /// Last step that goes into a reading; not below `first_step`.
    pub last_step: u16,
    /// Steps per reading, at least 1.
    pub cluster: u8,
    /// Turns left out between two scans.
    pub skip: u8,
    /// Characters per reading.
    pub encoding: Encoding,
}

impl ScanFormat {
    /// Readings per scan.
    #[must_use]
    pub fn beams(&self) -> usize {
        let steps = usize::from(self.last_step.saturating_sub(self.first_step)) + 1;
        steps.div_ceil(usize::from(self.cluster.max(1)))
    }

    /// Data characters per scan, without checksums.
    #[must_use]
    pub fn data_bytes(&self) -> usize {
        self.beams() * self.encoding.characters()
    }

    /// All bytes of one scan: echo, status, time stamp, data lines and the empty line.
    #[must_use]
    pub fn wire_bytes(&self) -> usize {
        scan_bytes(self.beams(), self.encoding.characters())
    }

    /// Bit/s that the stream needs, with start and stop bits, at `scan_hz` turns per second.
    #[must_use]
    pub fn bit_s(&self, scan_hz: f64) -> f64 {
        scan_bit_s(self.wire_bytes(), scan_hz, self.skip.into())
    }

    /// Refuses a stream that the line cannot carry, and says what it could.
    ///
    /// # Errors
    /// [`ConnectError::TooSlow`].
    pub fn check_fits(&self, bit_rate: u32, scan_hz: f64) -> Result<(), ConnectError> {
        if self.bit_s(scan_hz) <= f64::from(bit_rate) {
            return Ok(());
        }
        Err(ConnectError::TooSlow {
            beams: self.beams(),
            rate_hz: scan_hz / f64::from(self.skip + 1),
            needed_bit_s: self.bit_s(scan_hz).ceil() as u32,
            bit_rate,
            advice: self.advice(bit_rate, scan_hz),
        })
    }

    /// For each option, the smallest change that by itself makes the stream fit.
    fn advice(&self, bit_rate: u32, scan_hz: f64) -> String {
        let fits = |format: &Self, rate: u32| format.bit_s(scan_hz) <= f64::from(rate);
        let mut ways = Vec::new();
        let cluster = (self.cluster..=99).find(|n| {
            fits(
                &Self {
                    cluster: *n,
                    ..*self
                },
                bit_rate,
            )
        });
        ways.extend(cluster.map(|n| format!("cluster = {n}")));
        let skip = (self.skip..=9).find(|n| fits(&Self { skip: *n, ..*self }, bit_rate));
        ways.extend(skip.map(|n| format!("skip = {n}")));
        let rate = BIT_RATES.into_iter().filter(|rate| fits(self, *rate)).min();
        ways.extend(rate.map(|rate| format!("bit_rate = {rate}")));
        if ways.is_empty() {
            ways.push("fewer steps".into());
        }
        ways.join(" or ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_rate_is_tried() {
        let mut tried = LIKELY_BIT_RATES;
        tried.sort_unstable();
        assert_eq!(tried, BIT_RATES);
    }

    const FULL: ScanFormat = ScanFormat {
        first_step: 44,
        last_step: 725,
        cluster: 1,
        skip: 0,
        encoding: Encoding::Three,
    };

    #[test]
    fn a_full_scan_has_the_known_size() {
        use crate::hokuyo::codec::{LINE_DATA_BYTES, STREAM_COMMAND_BYTES};
        use description::robot::{URG_04LX_HZ, URG_04LX_STEPS};
        assert_eq!(FULL.beams(), URG_04LX_STEPS as usize);
        assert_eq!(Parameters::urg_04lx().scan_hz(), URG_04LX_HZ);
        assert_eq!((STREAM_COMMAND_BYTES, LINE_DATA_BYTES), (15, 64));
        assert_eq!(FULL.data_bytes(), 2046);
        assert_eq!(FULL.wire_bytes(), 16 + 4 + 6 + 2046 + 64 + 1);
        assert_eq!(ScanFormat { cluster: 3, ..FULL }.beams(), 228);
        assert!((FULL.bit_s(10.0) - 213_700.0).abs() < 1.0);
    }

    #[test]
    fn says_what_would_fit() {
        FULL.check_fits(250_000, 10.0).unwrap();
        let error = FULL.check_fits(115_200, 10.0).unwrap_err().to_string();
        assert!(
            error.contains("need 213700 bit/s, the line carries 115200"),
            "{error}"
        );
        assert!(
            error.contains("cluster = 2 or skip = 1 or bit_rate = 250000"),
            "{error}"
        );
        ScanFormat { cluster: 2, ..FULL }
            .check_fits(115_200, 10.0)
            .unwrap();
        ScanFormat { skip: 1, ..FULL }
            .check_fits(115_200, 10.0)
            .unwrap();
        let error = FULL.check_fits(19_200, 10.0).unwrap_err().to_string();
        assert!(error.contains("cluster = 13"), "{error}");
        assert!(!error.contains("skip"), "{error}");
    }

    #[test]
    fn options_out_of_range_are_named() {
        let wrong = [
            Options {
                bit_rate: 9600,
                ..Options::default()
            },
            Options {
                cluster: 100,
                ..Options::default()
            },
            Options {
                skip: 10,
                ..Options::default()
            },
            Options {
                connect_timeout: Duration::from_millis(1),
                ..Options::default()
            },
        ];
        for (options, name) in wrong
            .iter()
            .zip(["bit_rate", "cluster", "skip", "connect_timeout"])
        {
            let error = options.check().unwrap_err().to_string();
            assert!(error.contains(name), "{error}");
        }
    }

    #[test]
    fn a_device_of_more_steps_is_named_and_no_option_that_nobody_wrote() {
        let device = Parameters {
            model: "UTM-30LX".into(),
            ares: 1440,
            amin: 0,
            amax: 1080,
            ..Parameters::urg_04lx()
        };
        let error = Options::default().format(&device).unwrap_err().to_string();
        assert!(
            error.contains("UTM-30LX") && error.contains("1081"),
            "{error}"
        );
        assert!(!error.contains("last_step"), "{error}");
    }

    #[test]
    fn steps_must_exist() {
        let device = Parameters::urg_04lx();
        let options = |first, last| Options {
            first_step: Some(first),
            last_step: Some(last),
            ..Options::default()
        };
        assert_eq!(options(44, 725).format(&device).unwrap(), FULL);
        for (first, last, name) in [
            (0, 725, "first_step"),
            (44, 726, "last_step"),
            (400, 300, "first_step"),
        ] {
            let error = options(first, last)
                .format(&device)
                .unwrap_err()
                .to_string();
            assert!(error.contains(name), "{error}");
        }
    }
}
