//! The offset between two clocks, bounded from two sides by readings of one between readings of the other.

/// Nanoseconds in a millisecond, the unit of the device's clock.
pub(super) const MS_NS: i64 = 1_000_000;

/// Bounds on the time of the host at the device's time zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ClockBounds {
    bounds: Option<(i64, i64)>,
}

impl ClockBounds {
    /// Takes one reading of the device's clock, made between two times of the host.
    ///
    /// Readings that contradict each other (the clock was stepped) leave the newest one.
    pub fn add(&mut self, device_ms: u32, before_ns: u64, after_ns: u64) {
        let device_ns = i64::from(device_ms) * MS_NS;
        // The device's clock reads `ms` from ms to ms + 1.
        let low = before_ns as i64 - device_ns - MS_NS;
        let high = after_ns as i64 - device_ns;
        self.bounds = match self.bounds {
            Some((least, most)) if low <= most && least <= high => {
                Some((least.max(low), most.min(high)))
            }
            _ => Some((low, high)),
        };
    }

    /// Offset in the middle of the bounds, and how far it may be off.
    pub fn offset_ns(&self) -> Option<(i64, u64)> {
        let (least, most) = self.bounds?;
        let half = (most - least) / 2;
        Some((least + half, half.unsigned_abs()))
    }
}
