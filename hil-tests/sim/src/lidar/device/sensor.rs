//! What the firmware keeps: language, laser, stream, motor, timer.

use super::types::{DeviceOptions, Protocol};
use crate::lidar::command::Section;
use crate::lidar::measurement::Measurement;

const INITIAL_RPM: u32 = 600;
const RPM_PER_LEVEL: u32 = 6;
const TIMER_BITS: u32 = 24;

#[derive(Debug, Clone)]
pub(super) struct Stream {
    /// The echo up to the number of scans, and what follows it.
    pub(super) echo: Vec<u8>,
    pub(super) string: Vec<u8>,
    pub(super) section: Section,
    pub(super) skip: u32,
    pub(super) skipped: u32,
    /// Scans still to send; `None`: until stopped.
    pub(super) remaining: Option<u32>,
    pub(super) since_ns: u64,
}

/// The sensor, as its firmware keeps it.
#[derive(Debug, Clone)]
pub struct Device {
    pub(super) options: DeviceOptions,
    pub(super) protocol: Protocol,
    pub(super) laser: bool,
    pub(super) adjusting_time: bool,
    pub(super) stream: Option<Stream>,
    /// A GD, GS or G that waits for the first turn: its echo and section.
    pub(super) request: Option<(Vec<u8>, Section)>,
    pub(super) latest: Option<Box<Measurement>>,
    pub(super) bit_rate: u32,
    pub(super) speed_level: u32,
    pub(super) timer_ms: u32,
    pub(super) timer_zero_ns: u64,
    pub(super) line: Vec<u8>,
    pub(super) line_too_long: bool,
    pub(super) dropped_scans: u64,
    /// It says of itself that it does not work well.
    pub(super) unwell: bool,
}

impl Device {
    /// The laser is on: every turn is to be measured.
    #[must_use]
    pub fn is_measuring(&self) -> bool {
        self.laser
    }

    /// A stream runs.
    #[must_use]
    pub fn is_streaming(&self) -> bool {
        self.stream.is_some()
    }

    /// The language it speaks.
    #[must_use]
    pub fn protocol(&self) -> Protocol {
        self.protocol
    }

    /// The bit rate it will have when everything emitted so far is sent.
    #[must_use]
    pub fn bit_rate(&self) -> u32 {
        self.bit_rate
    }

    /// Duration of a turn at the present motor speed.
    #[must_use]
    pub fn turn_ns(&self) -> u64 {
        60_000_000_000 / u64::from(self.rpm())
    }

    /// Scans of a stream that a busy line had no room for.
    #[must_use]
    pub fn dropped_scans(&self) -> u64 {
        self.dropped_scans
    }

    /// The timer, in ms.
    #[must_use]
    pub fn timer_ms(&self, at_ns: u64) -> u32 {
        let age_ns = at_ns.saturating_sub(self.timer_zero_ns);
        let drift_ns = age_ns as f64 * self.options.timer_drift_ppm * 1e-6;
        let age_ms = age_ns.saturating_add_signed(drift_ns as i64) / 1_000_000;
        (age_ms.wrapping_add(u64::from(self.timer_ms)) & ((1 << TIMER_BITS) - 1)) as u32
    }

    pub(super) fn laser_off(&mut self) {
        self.laser = false;
        self.stream = None;
        self.request = None;
        self.latest = None;
    }

    pub(super) fn rpm(&self) -> u32 {
        INITIAL_RPM - RPM_PER_LEVEL * self.speed_level
    }
}
