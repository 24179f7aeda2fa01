//! Maps the device's millisecond clock to CLOCK_BOOTTIME.
//!
//! Bytes arrive with an unknown and changing delay; the device's stamps do not. Before streaming, readings of the clock
//! in adjust mode (`TM`) bound the offset between both clocks from two sides ([`ClockBounds`]). While streaming, the
//! smallest delay of the last [`WINDOW`] scans is compared with the smallest delay right after the calibration. The
//! difference is drift, as far as clocks drift: the offset follows it by at most [`DRIFT_NS_PER_MS`]. Where the device's clock has jumped
//! since, the smallest delay is assumed to be the time it takes to measure a turn.
//!
//! A difference that no drift explains is a change of the delay itself, and following it would put old scans into the
//! present. When it lasts, the mapping is not to be trusted any more ([`Untrusted`]): the clocks have to be compared anew.
//! So has a clock that stood still, whose scans look old for ever. A delay that grows by less than clocks drift looks like drift.
//!
//! When the device's clock jumps back (it restarted), the 24-bit wrap would put its scans into the future: the mapping
//! starts again. One that does so once more is not restarted but runs too fast, or jumps by itself, and is not to be trusted either.
//!
//! Real-time: no allocation, no system call.

mod bounds;
#[cfg(test)]
mod tests;

pub use bounds::ClockBounds;
use bounds::MS_NS;

/// Scans over which the smallest delay is sought: 6.4 s at 10 Hz.
pub const WINDOW: usize = 64;
/// The device's clock wraps at 2^24 ms, every 4.66 h.
const WRAP_MS: u64 = 1 << 24;
/// Most that two clocks drift apart, nanoseconds in a millisecond: 200 ppm, twice what a poor crystal drifts.
pub const DRIFT_NS_PER_MS: i64 = 200;
/// Most that the smallest delay of a window may differ from the first one beside drift: jitter of a busy host. At 0.4 m/s
/// a robot drives 3 mm in this time.
pub const TOLERANCE_NS: i64 = 8 * MS_NS;
/// After this many scans in a row that differ by more, the mapping is not trusted.
const MOST_OFF: u32 = WINDOW as u32;
/// Scans that arrive closer together have waited in a queue for the same reason, and count as one.
const TOGETHER_NS: u64 = 20_000_000;
/// A scan that seems to arrive this long before it can have been measured: the device's clock jumped.
const EARLY_NS: i64 = 200 * MS_NS;
/// A device restarts so often without a new connection.
const MOST_JUMPS: u32 = 1;
/// The offset follows drift of no longer a time at once: it was not watched meanwhile.
const MOST_ELAPSED_MS: u64 = 10_000;
/// A scan that arrives this long after the smallest delay has waited in a queue.
const LATE_NS: i64 = 500 * MS_NS;

/// A scan's times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mapped {
    /// Start of the turn, CLOCK_BOOTTIME.
    pub start_ns: u64,
    /// The device's time, continued over its wraps.
    pub device_ms: u64,
    /// Device time since the scan before, 0 for the first one and after a jump.
    pub elapsed_ms: u64,
    /// The device's clock jumped; the mapping starts here.
    pub jumped: bool,
}

/// The delay of the scans has changed by more than drift explains, for longer than a busy host does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Untrusted {
    /// By how much; negative when scans come earlier than they did.
    pub off_ns: i64,
}

/// The running mapping.
#[derive(Debug)]
pub struct DeviceClock {
    /// Assumed smallest delay until one has been observed.
    nominal_delay_ns: i64,
    /// Time of the host at the device's time zero.
    offset_ns: Option<i64>,
    /// The offset was measured and not guessed from the delay of a scan.
    calibrated: bool,
    /// Smallest delay from the start of a turn to its arrival; known once the window is full.
    floor_ns: Option<i64>,
    last: Option<Last>,
    /// Arrival minus device time of the last scans.
    window: [i64; WINDOW],
    filled: usize,
    next: usize,
    /// How often the device's clock has jumped, up to [`MOST_JUMPS`] and one more,
    jumps: u32,
    /// and by how much the last time.
    jumped_ns: i64,
    /// Scans in a row whose delay differs by more than [`TOLERANCE_NS`],
    off: u32,
    /// and when the last of them arrived that counts.
    off_at_ns: u64,
}

#[derive(Debug, Clone, Copy)]
struct Last {
    raw_ms: u32,
    device_ms: u64,
    arrival_ns: u64,
    start_ns: u64,
}

impl DeviceClock {
    /// With a calibration, or, without one, with the delay that a scan has at least.
    pub fn new(bounds: ClockBounds, nominal_delay_ns: u64) -> Self {
        Self {
            nominal_delay_ns: nominal_delay_ns as i64,
            offset_ns: bounds.offset_ns().map(|(offset, _)| offset),
            calibrated: bounds.offset_ns().is_some(),
            floor_ns: None,
            last: None,
            window: [0; WINDOW],
            filled: 0,
            next: 0,
            jumps: 0,
            jumped_ns: 0,
            off: 0,
            off_at_ns: 0,
        }
    }

    /// Maps the stamp of a scan that arrived at `arrival_ns`.
    ///
    /// # Errors
    /// [`Untrusted`]: this scan's time is not known, and neither is that of the next ones.
    pub fn map(&mut self, raw_ms: u32, arrival_ns: u64) -> Result<Mapped, Untrusted> {
        let mut device_ms = self.unwrap(raw_ms, arrival_ns);
        let jumped = self.has_jumped(sample_ns(device_ms, arrival_ns));
        if jumped {
            self.jumps = (self.jumps + 1).min(MOST_JUMPS + 1);
            self.jumped_ns = self.early_ns(sample_ns(device_ms, arrival_ns));
            self.filled = 0;
            self.next = 0;
            self.offset_ns = None;
            self.calibrated = false;
            self.off = 0;
            // Continue the device's time as if it had not jumped.
            device_ms = self.last.map_or(device_ms, |last| {
                last.device_ms + arrival_ns.saturating_sub(last.arrival_ns) / MS_NS as u64
            });
        }
        let elapsed_ms = match self.last {
            Some(last) if !jumped => device_ms - last.device_ms,
            _ => 0,
        };
        let sample_ns = sample_ns(device_ms, arrival_ns);
        let waited_ns = self.waited_ns(sample_ns);
        if waited_ns < LATE_NS {
            self.push(sample_ns);
        }
        let offset_ns = self.follow(sample_ns, elapsed_ms);
        let off_ns = if waited_ns < LATE_NS {
            self.off_ns(offset_ns)
        } else {
            waited_ns
        };
        let trusted = self.judge(off_ns, arrival_ns);
        // No turn begins after it has arrived.
        let mapped_ns = arrival_ns as i64 - sample_ns + offset_ns.min(sample_ns);
        let mapped_ns = mapped_ns.max(0).unsigned_abs();
        let start_ns = self
            .last
            .map_or(mapped_ns, |last| mapped_ns.max(last.start_ns + 1));
        self.last = Some(Last {
            raw_ms,
            device_ms,
            arrival_ns,
            start_ns,
        });
        trusted.map(|()| Mapped {
            start_ns,
            device_ms,
            elapsed_ms,
            jumped,
        })
    }

    /// Continues the 24-bit clock, over whole wraps too when the host's clock says that they passed.
    fn unwrap(&self, raw_ms: u32, arrival_ns: u64) -> u64 {
        let raw = u64::from(raw_ms) % WRAP_MS;
        let Some(last) = self.last else {
            // It may have wrapped since it was calibrated.
            let expected_ms = self.offset_ns.map_or(0, |offset_ns| {
                (arrival_ns as i64 - self.nominal_delay_ns - offset_ns) / MS_NS
            });
            let wraps = (expected_ms - raw as i64 + WRAP_MS as i64 / 2).div_euclid(WRAP_MS as i64);
            return raw + wraps.max(0) as u64 * WRAP_MS;
        };
        let forward_ms = (raw + WRAP_MS - u64::from(last.raw_ms) % WRAP_MS) % WRAP_MS;
        let host_ms = arrival_ns.saturating_sub(last.arrival_ns) / MS_NS as u64;
        let wraps = (host_ms.saturating_sub(forward_ms) + WRAP_MS / 2) / WRAP_MS;
        last.device_ms + forward_ms + wraps * WRAP_MS
    }

    /// Only early scans show a jump: a late one may have waited in a queue, and must not pass for a new one.
    fn has_jumped(&self, sample_ns: i64) -> bool {
        self.early_ns(sample_ns) < -EARLY_NS
    }

    /// How much sooner than the soonest a scan arrived, negative; nothing, if nobody knows when that is.
    fn early_ns(&self, sample_ns: i64) -> i64 {
        let floor_ns = self.floor_ns.unwrap_or(0);
        self.offset_ns
            .map_or(0, |offset_ns| sample_ns - offset_ns - floor_ns)
    }

    /// How much longer than the least a scan took to arrive. Scans that nobody read in time say nothing about the smallest
    /// delay.
    fn waited_ns(&self, sample_ns: i64) -> i64 {
        let floor_ns = self.floor_ns.unwrap_or(self.nominal_delay_ns);
        self.offset_ns
            .map_or(0, |offset_ns| sample_ns - offset_ns - floor_ns)
    }

    fn push(&mut self, sample_ns: i64) {
        self.window[self.next] = sample_ns;
        self.next = (self.next + 1) % WINDOW;
        self.filled = (self.filled + 1).min(WINDOW);
    }

    fn least_ns(&self) -> Option<i64> {
        self.window[..self.filled].iter().copied().min()
    }

    fn follow(&mut self, sample_ns: i64, elapsed_ms: u64) -> i64 {
        let least_ns = self.least_ns().unwrap_or(sample_ns);
        let Some(offset_ns) = self.offset_ns else {
            // Never calibrated, or the calibration is void.
            let floor_ns = *self.floor_ns.get_or_insert(self.nominal_delay_ns);
            return *self.offset_ns.insert(sample_ns - floor_ns);
        };
        if self.floor_ns.is_none() && self.filled == WINDOW {
            self.floor_ns = Some(least_ns - offset_ns);
        }
        let Some(floor_ns) = self.floor_ns else {
            return offset_ns;
        };
        let off_ns = least_ns - floor_ns - offset_ns;
        let follows_ns = if !self.calibrated && self.filled < WINDOW {
            // Before the window is full, the earliest scan is the best estimate.
            offset_ns + off_ns
        } else if off_ns.abs() > TOLERANCE_NS {
            // Drift would not have come so far behind.
            offset_ns
        } else {
            // A clock that leapt by less than a jump is off as well.
            let elapsed_ms = elapsed_ms.min(MOST_ELAPSED_MS) as i64;
            let most_ns = DRIFT_NS_PER_MS * elapsed_ms;
            offset_ns + off_ns.clamp(-most_ns, most_ns)
        };
        *self.offset_ns.insert(follows_ns)
    }

    /// By how much the smallest delay differs from the first one.
    fn off_ns(&self, offset_ns: i64) -> i64 {
        match (self.floor_ns, self.least_ns()) {
            (Some(floor_ns), Some(least_ns)) => least_ns - floor_ns - offset_ns,
            _ => 0,
        }
    }

    fn judge(&mut self, off_ns: i64, arrival_ns: u64) -> Result<(), Untrusted> {
        if off_ns.abs() <= TOLERANCE_NS {
            self.off = 0;
        } else if self.off == 0 || arrival_ns >= self.off_at_ns + TOGETHER_NS {
            self.off += 1;
            self.off_at_ns = arrival_ns;
        }
        if self.jumps > MOST_JUMPS {
            return Err(Untrusted {
                off_ns: self.jumped_ns,
            });
        }
        if self.off < MOST_OFF {
            Ok(())
        } else {
            Err(Untrusted { off_ns })
        }
    }
}

/// Arrival minus device time, which is the middle of the millisecond that the stamp names.
fn sample_ns(device_ms: u64, arrival_ns: u64) -> i64 {
    arrival_ns as i64 - device_ms as i64 * MS_NS - MS_NS / 2
}
