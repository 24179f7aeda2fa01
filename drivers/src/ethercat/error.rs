//! What can go wrong at bring-up and in an exchange.

use super::al::{AlState, AlStatus};
use std::fmt;
use std::io;

/// The steps of bring-up, for messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Counting SubDevices.
    Counting,
    /// Reset, reading the SII, mailbox, INIT to PREOP.
    Initialising,
    /// Reading the process-data layout, setting SyncManagers and FMMUs.
    Mapping,
    /// Setting and checking the watchdog.
    Watchdog,
    /// PREOP to SAFEOP.
    SafeOp,
    /// SAFEOP to OP, with process data running.
    Op,
}

impl fmt::Display for Phase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Phase::Counting => "counting SubDevices",
            Phase::Initialising => "going from INIT to PREOP",
            Phase::Mapping => "mapping process data",
            Phase::Watchdog => "setting the watchdog",
            Phase::SafeOp => "going from PREOP to SAFEOP",
            Phase::Op => "going from SAFEOP to OP",
        })
    }
}

/// Process data by the name that the SubDevice's documents use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProcessData {
    /// MainDevice to SubDevice.
    Outputs,
    /// SubDevice to MainDevice.
    Inputs,
}

impl fmt::Display for ProcessData {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            ProcessData::Outputs => "outputs",
            ProcessData::Inputs => "inputs",
        })
    }
}

/// Why a bus could not be brought to OP. The link is closed; open it again for the next attempt.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum BringUpError {
    /// The link does not carry frames.
    #[error("{link}: {phase}: {}: {source}", explain(source))]
    Link {
        link: String,
        phase: Phase,
        source: io::Error,
    },
    /// No frame came back.
    #[error("{link}: {phase}: no answer to {attempts} frames in {waited_ms} ms; {}", hint(*echoed_frames))]
    NoAnswer {
        link: String,
        phase: Phase,
        attempts: u32,
        waited_ms: u64,
        /// Frames that came back unchanged.
        echoed_frames: u64,
    },
    /// Not the one SubDevice that is supported on a bus.
    #[error("{link}: found {found} SubDevices, expected {expected}")]
    SubDeviceCount {
        link: String,
        expected: u16,
        found: u16,
    },
    /// Another vendor's SubDevice.
    #[error(
        "SubDevice {address:#06x} ({name:?}): vendor id {found:#010x}, expected {expected:#010x}"
    )]
    Vendor {
        address: u16,
        name: String,
        expected: u32,
        found: u32,
    },
    /// Another product.
    #[error(
        "SubDevice {address:#06x} ({name:?}): product code {found:#010x}, expected {}",
        hex_list(expected)
    )]
    Product {
        address: u16,
        name: String,
        expected: Vec<u32>,
        found: u32,
    },
    /// Another process-data layout.
    #[error("SubDevice {address:#06x}: {found} bytes of {direction}, expected {expected}")]
    ProcessDataSize {
        address: u16,
        direction: ProcessData,
        expected: usize,
        found: usize,
    },
    /// No SyncManager carries the outputs.
    #[error(
        "SubDevice {address:#06x}: none of its {sync_managers} SyncManagers carries {expected} bytes of outputs"
    )]
    OutputSyncManager {
        address: u16,
        sync_managers: u8,
        expected: usize,
    },
    /// The SubDevice would go on with old outputs when the MainDevice falls silent.
    #[error(
        "SubDevice {address:#06x}: the watchdog of output SyncManager {sync_manager} does not let itself be armed (control byte \
         {control:#04x}, expected bit 0x40 set): it would keep driving without a MainDevice"
    )]
    WatchdogDisarmed {
        address: u16,
        sync_manager: u8,
        control: u8,
    },
    /// The SubDevice does not take the watchdog time.
    #[error(
        "SubDevice {address:#06x}: process-data watchdog is {found_us} µs, expected {expected_us} µs"
    )]
    WatchdogTime {
        address: u16,
        expected_us: u64,
        found_us: u64,
    },
    /// No SubDevice has such a watchdog time.
    #[error("a process-data watchdog of {watchdog_ms} ms cannot be set, expected 1 to 6553 ms")]
    WatchdogRange { watchdog_ms: u32 },
    /// The SubDevice refused a state.
    #[error("SubDevice {address:#06x} refused {wanted}: it is in {status}")]
    Refused {
        address: u16,
        wanted: AlState,
        status: AlStatus,
    },
    /// In OP, but the process data is not exchanged.
    #[error("SubDevice {address:#06x}: working counter {found} in OP, expected {expected}")]
    WorkingCounter {
        address: u16,
        expected: u16,
        found: u16,
    },
    /// It took too long.
    #[error("{link}: {phase}: not done in {limit_ms} ms; {}", status_text(*status))]
    TimedOut {
        link: String,
        phase: Phase,
        limit_ms: u64,
        /// The SubDevice's state, if it still answers.
        status: Option<AlStatus>,
    },
    /// The SubDevice answered what the protocol does not allow.
    #[error("{link}: {phase}: {source}; {}", status_text(*status))]
    Protocol {
        link: String,
        phase: Phase,
        source: ethercrab::error::Error,
        /// The SubDevice's state, if it still answers.
        status: Option<AlStatus>,
    },
    /// More buses alive in this process than supported.
    #[error("too many EtherCAT buses in one process")]
    TooManyBuses,
}

fn explain(source: &io::Error) -> &'static str {
    match source.kind() {
        io::ErrorKind::ConnectionRefused => "nobody listens on that port",
        io::ErrorKind::HostUnreachable | io::ErrorKind::NetworkUnreachable => {
            "no way to that address"
        }
        io::ErrorKind::NetworkDown => "the interface went down",
        _ => "cannot carry frames",
    }
}

fn hint(echoed_frames: u64) -> &'static str {
    match echoed_frames {
        0 => "is the cable plugged in and the SubDevice powered?",
        _ => "frames come back as they left: is the wire looped without a SubDevice in it?",
    }
}

fn hex_list(codes: &[u32]) -> String {
    let codes: Vec<_> = codes.iter().map(|code| format!("{code:#010x}")).collect();
    codes.join(" or ")
}

fn status_text(status: Option<AlStatus>) -> String {
    match status {
        Some(status) => format!("the SubDevice is in {status}"),
        None => "the SubDevice does not tell its state".to_owned(),
    }
}

/// Why an exchange gave no inputs. What follows is the caller's policy: the bus can be used again in the next cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum ExchangeError {
    /// No answer by the deadline.
    #[error("no answer by the deadline")]
    Lost,
    /// Answered, but the process data was not wholly read and written.
    #[error("working counter {found}, expected {expected}")]
    WorkingCounter { found: u16, expected: u16 },
    /// The SubDevice has left OP; only bringing the bus up again helps.
    #[error("SubDevice {address:#06x} has left OP: it is in {status}")]
    NotOperational {
        address: u16,
        /// Where it is, and why if that could be read before the deadline.
        status: AlStatus,
    },
    /// The link refused; it should be opened again.
    #[error("link: {kind} (system error {os_error:?})")]
    Io {
        kind: io::ErrorKind,
        os_error: Option<i32>,
    },
    /// The caller's buffer does not have the size of the process data.
    #[error("{found} bytes of {direction} given, the SubDevice has {expected}")]
    ImageSize {
        direction: ProcessData,
        expected: usize,
        found: usize,
    },
    /// The answer cannot be understood.
    #[error("protocol: {0}")]
    Protocol(ethercrab::error::Error),
}
