//! Frames are lost, and the drive leaves OP.

use std::time::Duration;

use sim::rt::monotonic_ns;

use crate::bench::Bench;
use crate::watch::SURELY_STANDS;

/// The drive's own watchdog, which ends a setpoint that nobody renews.
const WATCHDOG: Duration = Duration::from_millis(100);

#[test]
fn short_losses_are_borne_and_a_long_one_survived() {
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
    bench.until("it has stopped", SURELY_STANDS, |bench| {
        bench
            .since(lost_ns)
            .iter()
            .any(|truth| truth.twist.v_m_s < 0.01)
    });
    bench.until_driving();
    assert!(bench.raised("bus-lost") > 0, "{:?}", bench.published());
    assert!(!bench.publishes("bus-lost"));
    bench.finish();
}

#[test]
fn a_drive_that_leaves_op_is_brought_up_again_until_it_is_too_often() {
    let mut bench = Bench::driving();
    let faults = bench.devices.bus_faults.clone();
    let times = bench.config.drive.bringups_per_minute;
    for time in 1..=times {
        let dropped_ns = monotonic_ns();
        faults.drop_to_safeop(0);
        bench.until("it has stopped", SURELY_STANDS, |bench| {
            bench
                .since(dropped_ns)
                .iter()
                .any(|truth| truth.twist.v_m_s < 0.01)
        });
        bench.until_driving();
        assert!(
            !bench.publishes("bring-up-limit"),
            "after {time} of {times}"
        );
    }

    let dropped_ns = monotonic_ns();
    faults.drop_to_safeop(0);
    bench.until_standing(SURELY_STANDS);
    bench.stopped_in_time(dropped_ns, WATCHDOG);
    bench.until("the fault is published", Duration::from_secs(1), |bench| {
        bench.publishes("bring-up-limit")
    });
    bench.stands_for(Duration::from_secs(3));

    bench.ask("reset");
    bench.until_driving();
    assert!(!bench.publishes("bring-up-limit") && !bench.publishes("bus-lost"));
    bench.finish();
}

#[test]
fn probe() {
    let mut bench = Bench::driving();
    let faults = bench.devices.bus_faults.clone();
    for which in 0..2 {
        let t = monotonic_ns();
        if which == 0 { faults.drop_to_safeop(0) } else { faults.lose_frames_for(Duration::from_millis(200)) };
        std::thread::sleep(Duration::from_millis(3000));
        for truth in bench.since(t).iter().take(120).step_by(2) {
            print!("{:.2}:{:.3} ", (truth.time_ns - t) as f64 / 1e9, truth.twist.v_m_s);
        }
        println!("\n{}", bench.log());
    }
    bench.finish();
}
