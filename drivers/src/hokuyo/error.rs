//! What can go wrong when connecting, and when reading.

use std::path::PathBuf;

use super::codec::Status;

/// Why a scan was not read. `Copy`: made and returned without allocation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum ReadError {
    /// The deadline passed; a scan may be half read and will be continued by the next call.
    #[error("no scan before the deadline")]
    Timeout,
    /// A line's checksum did not hold; the scan is dropped.
    #[error("scan dropped: a checksum does not hold")]
    Checksum,
    /// A scan ended too early; it is dropped.
    #[error("scan dropped: bytes are missing")]
    Truncated,
    /// Bytes that belong to no scan; the stream is being searched for the next one.
    #[error("bytes that belong to no scan")]
    Garbage,
    /// The port is gone; only a new connection helps.
    #[error("the serial device is gone")]
    Disconnected,
    /// The delay of scans has changed, and with it the time that they are from is not known; only a new connection, which
    /// compares the clocks anew, helps.
    #[error(
        "the delay of its scans has changed by {found_ms} ms beside the drift of its clock; expected at most \
         {expected_ms} ms, beyond which the age of a scan is not known"
    )]
    Untrusted {
        /// Negative when they come earlier than they did.
        found_ms: i64,
        /// Either way.
        expected_ms: i64,
    },
    /// The device reports an error instead of a scan.
    #[error("the device reports status {0} instead of a scan")]
    DeviceError(Status),
}

/// Why no connection was made.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum ConnectError {
    /// The serial device cannot be opened.
    #[error("cannot open {}: {source}", path.display())]
    Open {
        path: PathBuf,
        source: serialport::Error,
    },
    /// Setting up the open port failed.
    #[error("cannot set up {}: {source}", path.display())]
    Setup {
        path: PathBuf,
        source: std::io::Error,
    },
    /// An option is out of its range.
    #[error("option {option}: expected {expected}, found {found}")]
    Option {
        option: &'static str,
        expected: String,
        found: String,
    },
    /// The wanted scans do not fit through the line.
    #[error(
        "scans of {beams} beams at {rate_hz:.1} Hz need {needed_bit_s} bit/s, the line carries {bit_rate}; \
         choose {advice}"
    )]
    TooSlow {
        beams: usize,
        rate_hz: f64,
        /// What they need, start and stop bits counted.
        needed_bit_s: u32,
        bit_rate: u32,
        /// Changes of the options that would fit.
        advice: String,
    },
    /// No device answered at any bit rate.
    #[error(
        "no SCIP device answers on {} at any of {tried:?} bit/s ({heard_bytes} bytes heard, none of them an answer)",
        path.display()
    )]
    NoAnswer {
        path: PathBuf,
        tried: Vec<u32>,
        /// Bytes that came in.
        heard_bytes: u64,
    },
    /// A command got no usable reply in any attempt.
    #[error("no valid reply to {command} at {bit_rate} bit/s")]
    NoReply { command: String, bit_rate: u32 },
    /// The device refused a command.
    #[error("the device refuses {command} with status {status} ({meaning})")]
    Refused {
        command: String,
        status: Status,
        meaning: &'static str,
    },
    /// A reply lacks a field or has one that makes no sense.
    #[error("reply to {command}: field {field}: expected {expected}, found {found:?}")]
    Field {
        command: &'static str,
        field: &'static str,
        expected: &'static str,
        /// What came; empty when it is missing.
        found: String,
    },
    /// The device says that something is wrong with it.
    #[error(
        "the device says of its state (II, STAT) {found:?}, expected \"Sensor works well\": switch it off and on, and replace it \
         if it still says so"
    )]
    Unwell { found: String },
    /// The device is another one.
    #[error(
        "the device {model:?} gives scans of {beams} readings, of which at most {most} can be taken: only the URG-04LX is supported"
    )]
    TooManyBeams {
        model: String,
        beams: usize,
        most: usize,
    },
    /// The device is another one, as its parameters say.
    #[error("{0}")]
    OtherDevice(String),
    /// Its clock could not be read.
    #[error(
        "the device's clock could not be read: of {readings} replies to TM1 none was whole; check the cable, and the bit rate"
    )]
    ClockUnreadable { readings: usize },
    /// Its clock could not be compared with the host's, because replies take too long.
    #[error(
        "the device's clock is known to {found_ms} ms only, because its replies are late; expected {expected_ms} ms"
    )]
    ClockUncertain { found_ms: u64, expected_ms: u64 },
    /// The time for connecting ran out.
    #[error("time for connecting ran out while {during}")]
    OutOfTime { during: &'static str },
    /// The port disappeared while connecting.
    #[error("the serial device {} is gone", path.display())]
    Disconnected { path: PathBuf },
}
