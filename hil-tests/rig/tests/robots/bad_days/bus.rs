//! Frames are lost, and the drive leaves OP.

use std::time::Duration;

use sim::rt::monotonic_ns;
use sim::world::Truth;

use crate::bad_days::bench::Bench;
use crate::bad_days::watch::{SURELY_STANDS, seconds};
use crate::late::once_more_if_late;

/// The drive's own watchdog, which ends a setpoint that nobody renews.
const WATCHDOG: Duration = Duration::from_millis(100);

#[test]
fn short_losses_are_borne_and_a_long_one_survived() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        let faults = bench.devices.bus_faults.clone();
        for lost in [1, 10] {
            for _ in 0..5 {
                faults.lose_frames_for(Duration::from_millis(lost));
                bench.drives_for(Duration::from_millis(200));
            }
        }
        assert_eq!(bench.raised("bus-lost"), 0, "{:?}", bench.published());

        let lost_ns = monotonic_ns();
        faults.lose_frames_for(Duration::from_millis(200));
        stops_and_drives_on(&mut bench, lost_ns);
        assert!(bench.raised("bus-lost") > 0, "{:?}", bench.published());
        assert!(!bench.publishes("bus-lost"));
        bench.finish();
    });
}

#[test]
fn a_drive_that_leaves_op_is_brought_up_again_until_it_is_too_often() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        let faults = bench.devices.bus_faults.clone();
        let times = bench.config.drive.bringups_per_minute;
        for time in 1..=times {
            let dropped_ns = monotonic_ns();
            faults.drop_to_safeop(0);
            stops_and_drives_on(&mut bench, dropped_ns);
            assert!(
                !bench.publishes("bring-up-limit"),
                "after {time} of {times}"
            );
        }

        bench.is_stopped(WATCHDOG, |_| faults.drop_to_safeop(0));
        bench.until_published("bring-up-limit", Duration::from_secs(1));
        bench.stands_for(Duration::from_secs(3));

        bench.ask("reset");
        bench.until_driving();
        assert!(!bench.publishes("bring-up-limit") && !bench.publishes("bus-lost"));
        bench.finish();
    });
}

#[test]
fn a_cable_that_is_pulled_and_a_drive_without_power_stop_it_until_they_are_back() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        let faults = bench.devices.bus_faults.clone();
        bench.is_stopped(WATCHDOG, |_| faults.disappear(0));
        bench.until_published("bus-lost", Duration::from_secs(1));
        bench.stands_for(Duration::from_secs(1));
        faults.reappear(0);
        bench.until_driving();

        bench.is_stopped(WATCHDOG, |_| faults.power_off(0));
        bench.stands_for(Duration::from_secs(1));
        faults.power_on(0);
        bench.until_driving();
        assert!(!bench.publishes("bus-lost"));
        bench.finish();
    });
}

/// Motors are off until the bus is up again, which may be sooner than wheels come to rest; then it speeds up from
/// standing, and never jumps to the speed it had.
fn stops_and_drives_on(bench: &mut Bench, start_ns: u64) {
    const ALL_BUT_STANDING_M_S: f64 = 0.08;
    let slow = |truth: &Truth| truth.twist.v_m_s < ALL_BUT_STANDING_M_S;
    bench.until("it has stopped", SURELY_STANDS, |bench| {
        bench.since(start_ns).iter().any(slow)
    });
    bench.until_driving();
    let log = bench.since(start_ns);
    let slowest = log.iter().position(slow).expect("found above");
    for truth in &log[slowest..] {
        let after_s = seconds(truth.time_ns - log[slowest].time_ns);
        let most_m_s =
            ALL_BUT_STANDING_M_S + 1.5 * bench.config.drive.limits.acceleration_m_s2 * after_s;
        assert!(
            truth.twist.v_m_s < most_m_s,
            "jumped, {after_s:.3} s after: {truth:?}"
        );
    }
}
