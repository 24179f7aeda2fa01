//! `[lidar]`: the range sensor.

use std::path::PathBuf;

use super::{DURATION, TIMEOUT_MS};
use crate::geometry::{Footprint, Pose2};
use crate::keys::{Count, Field, KeyError, OFFSET, Page, Pose, Quantity, Source, Text};
use crate::section;

const RANGE: Quantity = Quantity::new("a range", "m").above(0.0).at_most(60.0);

/// The bit rates that SCIP 2.0 devices know (command `SS`).
pub const BIT_RATES: [u32; 7] = [19_200, 38_400, 57_600, 115_200, 250_000, 500_000, 750_000];

/// Steps that a URG-04LX measures in a turn.
pub const URG_04LX_STEPS: u32 = 682;
/// Turns of a URG-04LX in a second.
pub const URG_04LX_HZ: f64 = 10.0;

/// Bytes of one scan on the line (SCIP 2.0, command `MD`): the echo with its line feed, status, time stamp, the data in
/// lines of 64 with checksum and line feed, and the empty line.
#[must_use]
pub const fn scan_bytes(readings: usize, characters: usize) -> usize {
    const HEADER_BYTES: usize = 16 + 4 + 6;
    let data = readings * characters;
    HEADER_BYTES + data + 2 * data.div_ceil(64) + 1
}

/// Bit/s that scans of this size take, start and stop bits included, when `skip` turns are left out between two.
#[must_use]
pub fn scan_bit_s(bytes: usize, turns_hz: f64, skip: u32) -> f64 {
    bytes as f64 * 10.0 * turns_hz / f64::from(skip + 1)
}

/// The rule of a bit rate: one of [`BIT_RATES`].
pub struct BitRate;

section! {
    /// The range sensor.
    pub struct Lidar {
        /// The serial device.
        pub device: PathBuf as Text("a serial device, such as \"/dev/ttyACM0\""),
        /// The bit rate to switch to.
        pub bit_rate: u32 as BitRate,
        /// Where `laser` sits in `base_link`.
        pub mount: Pose2 as Pose(OFFSET),
        /// Nearer readings are unknown.
        pub range_min_m: f64 as RANGE,
        /// Farther readings are free up to here.
        pub range_max_m: f64 as RANGE,
        /// Neighbouring steps merged into one reading (1: none).
        pub cluster: u32 as Count::new("a count", 1, 99) => 1,
        /// Scans left out between two that are sent.
        pub skip: u32 as Count::new("a count", 0, 9) => 0,
        /// Without a valid scan for this long the robot stops.
        pub scan_timeout_ms: u32 as TIMEOUT_MS => 250,
        /// After that, scans must be good for this long before it drives on.
        pub good_scans_s: f64 as DURATION => 2.0,
    }
}

/// Checks that the sensor sits inside the footprint, from where motion tubes are judged.
///
/// # Errors
/// `lidar.mount` otherwise. Coordinates that are not numbers are not judged.
pub fn check_mount(mount: &Pose2, footprint: &Footprint) -> Result<(), KeyError> {
    let outside = mount.x_m > footprint.front_m
        || mount.x_m < -footprint.rear_m
        || mount.y_m > footprint.left_m
        || mount.y_m < -footprint.right_m;
    if outside {
        let found = format!("a sensor at ({:?}, {:?})", mount.x_m, mount.y_m);
        let expected = "a sensor inside the footprint";
        return Err(KeyError::new("lidar.mount", found, expected));
    }
    Ok(())
}

impl BitRate {
    fn expected() -> String {
        let rates: Vec<String> = BIT_RATES.iter().map(u32::to_string).collect();
        format!("one of {} bit/s", rates.join(", "))
    }
}

impl Field<BitRate> for u32 {
    fn read(s: &dyn Source, key: &'static str, _: &BitRate, _: Option<u32>) -> u32 {
        s.one_of(key, &BIT_RATES, &BitRate::expected())
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        _: &BitRate,
        _: Option<u32>,
        about: &'static str,
    ) {
        page.key(key, BitRate::expected(), None, about);
    }
}
