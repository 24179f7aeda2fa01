//! Maps the device's millisecond clock to CLOCK_MONOTONIC.
//!
//! Bytes arrive with an unknown and changing delay; the device's stamps do not. Before streaming, readings of the clock
//! in adjust mode (`TM`) bound the offset between both clocks from two sides ([`ClockBounds`]). While streaming, the
//! smallest delay of the last [`WINDOW`] scans is compared with the smallest delay right after the calibration. The
//! difference is drift; the offset follows it slowly, so that stamps stay evenly spaced. Without a calibration the
//! smallest delay is assumed to be the time it takes to measure a turn.
//!
//! When the device's clock jumps back (it restarted), the 24-bit wrap would put its scans into the future: the mapping
//! starts again. When the device's clock stood still, its scans look old permanently: that needs a new connection.
//!
//! Real-time: no allocation, no system call.

/// Scans over which the smallest delay is sought: 6.4 s at 10 Hz.
pub const WINDOW: usize = 64;
/// The device's clock wraps at 2^24 ms, every 4.66 h.
const WRAP_MS: u64 = 1 << 24;
const MS_NS: i64 = 1_000_000;
/// Largest correction of the offset per scan: 0.1 ms, ten times what a poor crystal drifts in one turn.
const SLEW_NS: i64 = MS_NS / 10;
/// A scan that seems to arrive this long before it can have been measured: the device's clock jumped.
const EARLY_NS: i64 = 200 * MS_NS;
/// A scan that arrives this long after the smallest delay has waited in a queue.
const LATE_NS: i64 = 500 * MS_NS;

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

/// A scan's times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mapped {
    /// Start of the turn, CLOCK_MONOTONIC.
    pub start_ns: u64,
    /// The device's time, continued over its wraps.
    pub device_ms: u64,
    /// Device time since the scan before, 0 for the first one and after a jump.
    pub elapsed_ms: u64,
    /// The device's clock jumped; the mapping starts here.
    pub jumped: bool,
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
        }
    }

    /// Maps the stamp of a scan that arrived at `arrival_ns`.
    pub fn map(&mut self, raw_ms: u32, arrival_ns: u64) -> Mapped {
        let mut device_ms = self.unwrap(raw_ms, arrival_ns);
        let jumped = self.has_jumped(sample_ns(device_ms, arrival_ns));
        if jumped {
            self.filled = 0;
            self.next = 0;
            self.offset_ns = None;
            self.calibrated = false;
            // Continue the device's time as if it had not jumped.
            device_ms = self.last.map_or(device_ms, |last| {
                last.device_ms + arrival_ns.saturating_sub(last.arrival_ns) / MS_NS as u64
            });
        }
        let sample_ns = sample_ns(device_ms, arrival_ns);
        if !self.has_waited(sample_ns) {
            self.push(sample_ns);
        }
        let offset_ns = self.follow(sample_ns);
        // No turn begins after it has arrived.
        let mapped_ns = arrival_ns as i64 - sample_ns + offset_ns.min(sample_ns);
        let mapped_ns = mapped_ns.max(0).unsigned_abs();
        let start_ns = self
            .last
            .map_or(mapped_ns, |last| mapped_ns.max(last.start_ns + 1));
        let elapsed_ms = match self.last {
            Some(last) if !jumped => device_ms - last.device_ms,
            _ => 0,
        };
        self.last = Some(Last {
            raw_ms,
            device_ms,
            arrival_ns,
            start_ns,
        });
        Mapped {
            start_ns,
            device_ms,
            elapsed_ms,
            jumped,
        }
    }

    /// Continues the 24-bit clock, over whole wraps too when the host's clock says that they passed.
    fn unwrap(&self, raw_ms: u32, arrival_ns: u64) -> u64 {
        let raw = u64::from(raw_ms) % WRAP_MS;
        let Some(last) = self.last else { return raw };
        let forward_ms = (raw + WRAP_MS - u64::from(last.raw_ms) % WRAP_MS) % WRAP_MS;
        let host_ms = arrival_ns.saturating_sub(last.arrival_ns) / MS_NS as u64;
        let wraps = (host_ms.saturating_sub(forward_ms) + WRAP_MS / 2) / WRAP_MS;
        last.device_ms + forward_ms + wraps * WRAP_MS
    }

    /// Only early scans show a jump: a late one may have waited in a queue, and must not pass for a new one.
    fn has_jumped(&self, sample_ns: i64) -> bool {
        self.offset_ns
            .is_some_and(|offset_ns| sample_ns - offset_ns < self.floor_ns.unwrap_or(0) - EARLY_NS)
    }

    /// Scans that nobody read in time say nothing about the smallest delay.
    fn has_waited(&self, sample_ns: i64) -> bool {
        let floor_ns = self.floor_ns.unwrap_or(self.nominal_delay_ns);
        self.offset_ns
            .is_some_and(|offset_ns| sample_ns - offset_ns > floor_ns + LATE_NS)
    }

    fn push(&mut self, sample_ns: i64) {
        self.window[self.next] = sample_ns;
        self.next = (self.next + 1) % WINDOW;
        self.filled = (self.filled + 1).min(WINDOW);
    }

    fn follow(&mut self, sample_ns: i64) -> i64 {
        let least_ns = self.window[..self.filled]
            .iter()
            .copied()
            .min()
            .unwrap_or(sample_ns);
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
        let wanted_ns = least_ns - floor_ns;
        let follows_ns = if !self.calibrated && self.filled < WINDOW {
            // Before the window is full, the earliest scan is the best estimate.
            wanted_ns
        } else {
            offset_ns + (wanted_ns - offset_ns).clamp(-SLEW_NS, SLEW_NS)
        };
        *self.offset_ns.insert(follows_ns)
    }
}

/// Arrival minus device time, which is the middle of the millisecond that the stamp names.
fn sample_ns(device_ms: u64, arrival_ns: u64) -> i64 {
    arrival_ns as i64 - device_ms as i64 * MS_NS - MS_NS / 2
}

#[cfg(test)]
mod tests {
    use super::*;

    const TURN_MS: u64 = 100;
    const HOST_0_NS: u64 = 5_000_000_000_000;

    /// A device whose clock runs `rate` times as fast as the host's and whose scans arrive late.
    struct Device {
        zero_ms: f64,
        rate: f64,
        noise: u64,
    }

    impl Device {
        fn device_ms(&self, host_ns: u64) -> u32 {
            let ms = self.zero_ms + (host_ns - HOST_0_NS) as f64 * 1e-6 * self.rate;
            (ms as u64 % WRAP_MS) as u32
        }

        /// 75 ms to measure and send, up to 8 ms of delay.
        fn delay_ns(&mut self) -> u64 {
            self.noise = self
                .noise
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            75_000_000 + (self.noise >> 33) % 8_000_000
        }

        fn bounds(&self) -> ClockBounds {
            let mut bounds = ClockBounds::default();
            for index in 0..8u64 {
                let before = HOST_0_NS + index * 3_300_000;
                bounds.add(self.device_ms(before + 900_000), before, before + 2_000_000);
            }
            bounds
        }

        /// Errors of the mapped start of `turns` turns, in ms.
        fn run(&mut self, clock: &mut DeviceClock, turns: u64) -> Vec<f64> {
            (1..=turns)
                .map(|turn| {
                    let start_ns = HOST_0_NS + turn * TURN_MS * 1_000_000;
                    let raw = self.device_ms(start_ns);
                    let mapped = clock.map(raw, start_ns + self.delay_ns());
                    assert!(!mapped.jumped, "turn {turn}");
                    (mapped.start_ns as i64 - start_ns as i64) as f64 * 1e-6
                })
                .collect()
        }
    }

    fn worst(errors: &[f64]) -> f64 {
        errors
            .iter()
            .fold(0.0, |worst, error| worst.max(error.abs()))
    }

    #[test]
    fn a_calibrated_clock_is_right_from_the_first_scan() {
        let mut device = Device {
            zero_ms: 1234.3,
            rate: 1.0,
            noise: 1,
        };
        let (_, uncertainty_ns) = device.bounds().offset_ns().unwrap();
        assert!(uncertainty_ns < 1_200_000, "{uncertainty_ns}");
        let mut clock = DeviceClock::new(device.bounds(), 71_000_000);
        let errors = device.run(&mut clock, 600);
        assert!(worst(&errors) < 2.0, "{}", worst(&errors));
    }

    #[test]
    fn follows_drift_and_wraps() {
        for rate in [1.0 - 2e-4, 1.0 + 2e-4] {
            // The wrap comes after 20 s; ten minutes at 200 ppm are 120 ms.
            let mut device = Device {
                zero_ms: (WRAP_MS - 20_000) as f64,
                rate,
                noise: 2,
            };
            let mut clock = DeviceClock::new(device.bounds(), 71_000_000);
            let errors = device.run(&mut clock, 6000);
            assert!(worst(&errors) < 4.0, "rate {rate}: {}", worst(&errors));
        }
    }

    #[test]
    fn without_calibration_the_smallest_delay_counts() {
        let mut device = Device {
            zero_ms: 7.0,
            rate: 1.0,
            noise: 3,
        };
        let mut clock = DeviceClock::new(ClockBounds::default(), 75_000_000);
        let errors = device.run(&mut clock, 600);
        assert!(worst(&errors[..100]) < 9.0, "{}", worst(&errors));
        assert!(worst(&errors[200..]) < 1.5, "{}", worst(&errors[200..]));
    }

    #[test]
    fn a_restart_maps_anew_and_a_stall_does_not() {
        let mut device = Device {
            zero_ms: 1e6,
            rate: 1.0,
            noise: 4,
        };
        let mut clock = DeviceClock::new(device.bounds(), 71_000_000);
        device.run(&mut clock, 100);
        // Nobody read for ten seconds: a hundred scans wait in a queue and arrive together.
        let at = |turn: u64| HOST_0_NS + turn * TURN_MS * 1_000_000;
        for turn in 101..=200 {
            let mapped = clock.map(device.device_ms(at(turn)), at(201));
            assert!(!mapped.jumped);
            assert!((mapped.start_ns as i64 - at(turn) as i64).abs() < 5_000_000);
        }
        // The device starts again from zero.
        let mut last = 0;
        for turn in 201..=300 {
            let raw = ((turn - 201) * TURN_MS) as u32;
            let mapped = clock.map(raw, at(turn) + device.delay_ns());
            assert_eq!(mapped.jumped, turn == 201);
            assert!(mapped.start_ns > last);
            assert!((mapped.start_ns as i64 - at(turn) as i64).abs() < 10_000_000);
            last = mapped.start_ns;
        }
    }

    #[test]
    fn bounds_that_contradict_leave_the_newest() {
        let mut bounds = ClockBounds::default();
        bounds.add(1000, 2_000_000_000, 2_001_000_000);
        bounds.add(5000, 2_002_000_000, 2_003_000_000);
        let (offset, uncertainty) = bounds.offset_ns().unwrap();
        assert_eq!(uncertainty, 1_000_000);
        assert_eq!(offset, 2_002_000_000 - 5_000_000_000);
    }

    #[test]
    fn any_stamps_keep_time_growing() {
        let mut clock = DeviceClock::new(ClockBounds::default(), 0);
        let mut noise = 99u64;
        let (mut last_start, mut last_device) = (0, 0);
        for arrival in 1..20_000u64 {
            noise = noise
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let mapped = clock.map((noise >> 40) as u32, arrival * 100_000_000);
            assert!(mapped.start_ns > last_start);
            assert!(mapped.device_ms >= last_device);
            (last_start, last_device) = (mapped.start_ns, mapped.device_ms);
        }
    }
}
