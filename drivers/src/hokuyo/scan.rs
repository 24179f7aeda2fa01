//! A scan as it leaves the driver.

/// Most beams of one scan: steps 0 to 767.
pub const MAX_BEAMS: usize = 768;

/// Readings below this many millimetres are codes, not lengths.
pub const FIRST_LENGTH_MM: u16 = 20;

/// One turn of the sensor, as raw readings.
///
/// Beam `i` looks along step `first_step + i × cluster`; [`super::Parameters::step_angle_rad`] gives its angle.
/// A reading below [`FIRST_LENGTH_MM`] is a code of the device, passed on unchanged: see [`Reading`].
#[derive(Debug, Clone)]
pub struct Scan {
    /// Readings; only the first `count` are valid.
    pub ranges_mm: [u16; MAX_BEAMS],
    /// Number of valid readings.
    pub count: usize,
    /// Step of the first reading.
    pub first_step: u16,
    /// Steps from one reading to the next, at least 1.
    pub cluster: u16,
    /// When the first reading was taken: nanoseconds of CLOCK_BOOTTIME.
    pub stamp_ns: u64,
    /// The device's own time at the start of the turn, continued over its 24-bit wrap.
    pub device_ms: u64,
    /// Number of this scan among those delivered on this connection, from 0.
    pub sequence: u64,
}

impl Scan {
    /// A scan without readings.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            ranges_mm: [0; MAX_BEAMS],
            count: 0,
            first_step: 0,
            cluster: 1,
            stamp_ns: 0,
            device_ms: 0,
            sequence: 0,
        }
    }

    /// The valid readings.
    #[must_use]
    pub fn ranges_mm(&self) -> &[u16] {
        &self.ranges_mm[..self.count.min(MAX_BEAMS)]
    }
}

impl Default for Scan {
    fn default() -> Self {
        Self::new()
    }
}

/// What a raw reading means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reading {
    /// Nothing in sight, up to the device's largest range.
    NothingInSight,
    /// The device could not measure: low reflection, interference, hardware. The code is the device's.
    Unknown {
        /// 1 to 19.
        code: u8,
    },
    /// A distance.
    Millimetres(u16),
}

impl From<u16> for Reading {
    fn from(raw: u16) -> Self {
        match raw {
            0 => Self::NothingInSight,
            1..FIRST_LENGTH_MM => Self::Unknown { code: raw as u8 },
            _ => Self::Millimetres(raw),
        }
    }
}

/// When a scan arrived, and what was missed before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Received {
    /// When the scan's first line was read, CLOCK_BOOTTIME.
    pub arrival_ns: u64,
    /// When the scan was complete, CLOCK_BOOTTIME.
    pub complete_ns: u64,
    /// Whole turns of the device between the scan before and this one that did not arrive.
    pub missed: u32,
}

/// What has happened since the connection was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LidarCounters {
    /// Scans delivered.
    pub scans: u64,
    /// Scans dropped: a checksum did not hold.
    pub checksum: u64,
    /// Scans dropped: bytes were missing.
    pub truncated: u64,
    /// Stretches of bytes that belong to no scan.
    pub garbage: u64,
    /// Scans that the device replaced by an error status.
    pub device_errors: u64,
    /// Times the stream was found again after dropped bytes.
    pub resynchronisations: u64,
    /// Turns that never arrived, by the device's clock.
    pub missed: u64,
    /// Times the device's clock jumped (a restart) and its mapping started again.
    pub clock_jumps: u64,
    /// 1 once the delay of scans has changed by more than drift explains: the connection is of no use any more.
    pub untrusted: u64,
    /// Bytes read.
    pub bytes: u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_stay_distinct() {
        assert_eq!(Reading::from(0), Reading::NothingInSight);
        assert_eq!(Reading::from(6), Reading::Unknown { code: 6 });
        assert_eq!(Reading::from(19), Reading::Unknown { code: 19 });
        assert_eq!(Reading::from(20), Reading::Millimetres(20));
    }
}
