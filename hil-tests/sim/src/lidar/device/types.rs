//! How the sensor is set up and what it emits.

/// The bit rates the sensor's serial line knows.
pub const BIT_RATES: [u32; 6] = [19_200, 57_600, 115_200, 250_000, 500_000, 750_000];

/// Which language the sensor speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Protocol {
    /// Old firmware's after power-up, with the laser on.
    Scip11,
    /// After `SCIP2.0`, or from the start.
    Scip20,
}

/// How the sensor powers up.
#[derive(Debug, Clone, PartialEq)]
pub struct DeviceOptions {
    /// Bit rate after power-up and reset, one of [`BIT_RATES`].
    pub bit_rate: u32,
    /// Language after power-up.
    pub protocol: Protocol,
    /// Already streaming full scans in SCIP 2.0, as after a crash of its host.
    pub streaming: bool,
    /// Serial number.
    pub serial: String,
    /// Reading of its timer at power-up, to test the 24-bit wrap.
    pub timer_ms: u32,
    /// Rate error of its timer, positive when too fast.
    pub timer_drift_ppm: f64,
}

impl Default for DeviceOptions {
    /// SCIP 1.1 at 19200 bit/s, silent, with a perfect timer.
    fn default() -> DeviceOptions {
        DeviceOptions {
            bit_rate: BIT_RATES[0],
            protocol: Protocol::Scip11,
            streaming: false,
            serial: "H0000001".to_owned(),
            timer_ms: 0,
            timer_drift_ppm: 0.0,
        }
    }
}

/// What an emission is part of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The answer to a command, a requested scan included.
    Reply,
    /// A scan of a stream.
    Scan,
}

/// Bytes the sensor sends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Emission {
    /// The bytes.
    pub bytes: Vec<u8>,
    /// What they are part of.
    pub kind: Kind,
    /// The line's bit rate after the last of them.
    pub bit_rate_after: Option<u32>,
}

impl Emission {
    /// A reply after which the bit rate stays.
    pub(super) fn reply(bytes: Vec<u8>) -> Emission {
        Emission {
            bytes,
            kind: Kind::Reply,
            bit_rate_after: None,
        }
    }
}
