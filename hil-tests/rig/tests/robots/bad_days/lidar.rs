//! The lidar is unplugged, or its bytes are broken.

use std::time::Duration;

use crate::bad_days::bench::Bench;
use crate::late::once_more_if_late;

const SCAN_TIMEOUT: Duration = Duration::from_millis(250);
const REACTION: Duration = Duration::from_millis(50);

#[test]
fn without_a_lidar_it_stops_and_with_it_drives_on() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        let faults = bench.devices.lidar_faults.clone();
        bench.is_stopped(SCAN_TIMEOUT + REACTION, |_| faults.unplug());
        bench.until("the fault is published", Duration::from_secs(1), |bench| {
            bench.publishes("lidar-lost") && bench.publishes("scan-silent")
        });
        bench.stands_for(Duration::from_secs(1));

        faults.replug();
        // 2 s of good scans come first.
        bench.stands_for(Duration::from_millis(1500));
        bench.until_driving();
        assert!(!bench.publishes("lidar-lost") && !bench.publishes("scan-silent"));
        bench.finish();
    });
}

#[test]
fn a_lidar_that_hangs_stops_it() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        let faults = bench.devices.lidar_faults.clone();
        bench.is_stopped(SCAN_TIMEOUT + REACTION, |_| faults.freeze());
        faults.thaw();
        bench.until_driving();
        bench.finish();
    });
}

#[test]
fn broken_scans_are_dropped_and_it_goes_on() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        let faults = bench.devices.lidar_faults.clone();
        // Every second or third scan is broken, in one way after the other.
        for round in 0..12 {
            match round % 3 {
                0 => faults.garbage(700),
                1 => faults.truncate_scans(1),
                _ => faults.corrupt_checksums(1),
            }
            std::thread::sleep(Duration::from_millis(250));
            let truth = bench.truth();
            assert_eq!(truth.collisions, 0, "{truth:?}");
        }
        bench.until_driving();

        // Nothing but broken scans: as good as none.
        bench.is_stopped(SCAN_TIMEOUT + REACTION, |_| faults.corrupt_checksums(10));
        bench.until_driving();
        assert!(bench.raised("scan-broken") > 0, "{:?}", bench.published());
        bench.finish();
    });
}
