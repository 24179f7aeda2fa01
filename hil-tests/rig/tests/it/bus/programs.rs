//! Frames are lost, the drive leaves OP, its cable is pulled. More of it, and figures, are in `stepped.rs`.

use std::time::Duration;

use sim::rt::monotonic_ns;
use sim::world::Truth;

use crate::programs::bench::Bench;
use crate::programs::late::once_more_if_late;
use crate::programs::watch::{SURELY_STANDS, seconds};

/// The drive's own watchdog, which ends a setpoint that nobody renews.
const WATCHDOG: Duration = Duration::from_millis(100);

#[test]
fn lost_frames_and_a_drive_that_leaves_op_stop_it_for_a_moment_and_a_pulled_cable_until_a_reset() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        let faults = bench.devices.bus_faults.clone();
        let lost_ns = monotonic_ns();
        faults.lose_frames_for(Duration::from_millis(200));
        stops_and_drives_on(&mut bench, lost_ns);
        assert!(bench.raised("bus-lost") > 0, "{:?}", bench.published());

        let dropped_ns = monotonic_ns();
        faults.drop_to_safeop(0);
        stops_and_drives_on(&mut bench, dropped_ns);

        bench.is_stopped(WATCHDOG, |_| faults.disappear(0));
        bench.until_published("bus-lost", Duration::from_secs(1));
        bench.stands_for(Duration::from_millis(500));
        // Gone for over a second.
        std::thread::sleep(Duration::from_millis(500));
        faults.reappear(0);
        bench.until_published("drive-returned", Duration::from_secs(5));
        assert!(!bench.publishes("bus-lost"));
        bench.stands_for(Duration::from_millis(500));
        bench.ask("reset");
        bench.until_driving();
        assert!(!bench.publishes("drive-returned"));
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
