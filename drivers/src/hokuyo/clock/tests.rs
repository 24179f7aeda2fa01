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
                let mapped = clock.map(raw, start_ns + self.delay_ns()).unwrap();
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
fn a_clock_that_wraps_between_its_calibration_and_the_first_scan_is_right() {
    for left_ms in [25.3, 50.3, 99.3] {
        let mut device = Device {
            zero_ms: WRAP_MS as f64 - left_ms,
            rate: 1.0,
            noise: 1,
        };
        let mut clock = DeviceClock::new(device.bounds(), 71_000_000);
        let errors = device.run(&mut clock, 600);
        assert!(worst(&errors) < 2.0, "{left_ms}: {}", worst(&errors));
    }
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
        let mapped = clock.map(device.device_ms(at(turn)), at(201)).unwrap();
        assert!(!mapped.jumped);
        assert!((mapped.start_ns as i64 - at(turn) as i64).abs() < 5_000_000);
    }
    // The device starts again from zero.
    let mut last = 0;
    for turn in 201..=300 {
        let raw = ((turn - 201) * TURN_MS) as u32;
        let mapped = clock.map(raw, at(turn) + device.delay_ns()).unwrap();
        assert_eq!(mapped.jumped, turn == 201);
        assert!(mapped.start_ns > last);
        assert!((mapped.start_ns as i64 - at(turn) as i64).abs() < 10_000_000);
        last = mapped.start_ns;
    }
}

/// Its scans seem to come earlier and earlier, and each jump would void the calibration.
#[test]
fn a_clock_that_runs_far_too_fast_is_not_trusted_for_long() {
    let mut device = Device {
        zero_ms: 1e6,
        rate: 1.05,
        noise: 4,
    };
    let mut clock = DeviceClock::new(device.bounds(), 71_000_000);
    let mut jumps = 0;
    let mut map = |turn: u64| {
        let at_ns = HOST_0_NS + turn * TURN_MS * 1_000_000;
        clock.map(device.device_ms(at_ns), at_ns + device.delay_ns())
    };
    let distrusted = (0..300).find_map(|turn| match map(turn) {
        Ok(mapped) => {
            jumps += u32::from(mapped.jumped);
            None
        }
        Err(untrusted) => Some((turn, untrusted.off_ns)),
    });
    let (turn, off_ns) = distrusted.expect("it is not a clock");
    assert!(
        jumps == 1 && turn < 200 && off_ns < -100_000_000,
        "{turn}: {off_ns}"
    );
    assert!(map(turn + 1).is_err(), "until it is compared anew");
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
        let Ok(mapped) = clock.map((noise >> 40) as u32, arrival * 100_000_000) else {
            continue;
        };
        assert!(mapped.start_ns > last_start);
        assert!(mapped.device_ms >= last_device);
        (last_start, last_device) = (mapped.start_ns, mapped.device_ms);
    }
}

/// Scans of a device with perfect clock, each later by `delay_ns(turn)` than those of [`Device`]: errors in ms, and why it ended.
fn delayed(turns: u64, delay_ns: impl Fn(u64) -> u64) -> (Vec<f64>, Option<Untrusted>) {
    let mut device = Device {
        zero_ms: 1e6,
        rate: 1.0,
        noise: 5,
    };
    let mut clock = DeviceClock::new(device.bounds(), 71_000_000);
    let mut errors = Vec::new();
    for turn in 1..=turns {
        let start_ns = HOST_0_NS + turn * TURN_MS * 1_000_000;
        let arrival_ns = start_ns + device.delay_ns() + delay_ns(turn);
        match clock.map(device.device_ms(start_ns), arrival_ns) {
            Ok(mapped) => errors.push((mapped.start_ns as i64 - start_ns as i64) as f64 * 1e-6),
            Err(untrusted) => return (errors, Some(untrusted)),
        }
    }
    (errors, None)
}

#[test]
fn a_delay_that_grows_is_not_followed_as_drift() {
    // By 1 ms in a second, from the beginning or later.
    for since in [0, 300] {
        let (errors, end) = delayed(3000, |turn| turn.saturating_sub(since) * 100_000);
        assert!(worst(&errors) < 5.0, "{}", worst(&errors));
        let off_ms = end.unwrap().off_ns / MS_NS;
        assert!((8..20).contains(&off_ms), "{off_ms}");
        // Half a minute after it began.
        assert!(errors.len() < since as usize + 300, "{}", errors.len());
    }
}

#[test]
fn a_delay_that_leaps_and_stays_is_not_followed_and_ends_it() {
    for (leap_ms, later) in [(30, 200), (400, 200), (2000, 100)] {
        let (errors, end) = delayed(1000, |turn| u64::from(turn > 100) * leap_ms * 1_000_000);
        assert!(worst(&errors) < 3.0, "{}", worst(&errors));
        assert!(
            end.is_some() && errors.len() < 100 + later,
            "{leap_ms} ms: {}",
            errors.len()
        );
    }
    // A delay that was there from the first scan on and goes.
    let (errors, end) = delayed(1000, |turn| u64::from(turn < 200) * 50_000_000);
    assert!(worst(&errors) < 3.0 && end.is_some(), "{}", worst(&errors));
    // For 10 s is no longer than a host is busy.
    let (errors, end) = delayed(1000, |turn| {
        u64::from((200..300).contains(&turn)) * 50_000_000
    });
    assert!(worst(&errors) < 3.0 && end.is_none(), "{}", worst(&errors));
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(64))]

    #[test]
    fn real_drift_is_never_refused_and_stays_small(
        ppm in -200.0..=200.0f64,
        jitter_ms in 0u64..=12,
        stalls in proptest::collection::vec((0u64..12_000, 1u64..=8_000), 0..8),
        zero_ms in 0u64..WRAP_MS,
        noise in proptest::prelude::any::<u64>(),
    ) {
        let mut device = Device { zero_ms: zero_ms as f64 + 0.3, rate: 1.0 + ppm * 1e-6, noise };
        let mut clock = DeviceClock::new(device.bounds(), 71_000_000);
        let mut before_ns = 0;
        // Twenty minutes: 240 ms of drift.
        for turn in 1..=12_000u64 {
            let start_ns = HOST_0_NS + turn * TURN_MS * 1_000_000;
            let late_ns = (device.delay_ns() - 75_000_000) * jitter_ms / 8;
            let mut arrival_ns = (start_ns + 75_000_000 + late_ns).max(before_ns);
            // Who reads stands still, and then reads all that has come meanwhile.
            for (begin, lasts_ms) in &stalls {
                let begin_ns = HOST_0_NS + begin * TURN_MS * 1_000_000;
                let end_ns = begin_ns + lasts_ms * 1_000_000;
                if (begin_ns..end_ns).contains(&arrival_ns) {
                    arrival_ns = end_ns;
                }
            }
            before_ns = arrival_ns;
            let mapped = clock.map(device.device_ms(start_ns), arrival_ns);
            let mapped = mapped.map_err(|error| format!("turn {turn}: {error:?}")).unwrap();
            proptest::prop_assert!(!mapped.jumped);
            let error_ms = (mapped.start_ns as i64 - start_ns as i64) as f64 * 1e-6;
            proptest::prop_assert!(error_ms.abs() < 6.0, "turn {}: {} ms", turn, error_ms);
        }
    }
}
