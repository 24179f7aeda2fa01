//! The drive's emergency stop. Its other faults are in `tests/stepped/drive.rs`.

use std::time::Duration;

use crate::bad_days::bench::Bench;
use crate::late::once_more_if_late;

/// A fault is believed after 50 ms, so that noise stops nobody.
const BELIEVED: Duration = Duration::from_millis(50);

#[test]
fn the_emergency_stop_holds_it_until_an_operator_agrees() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        bench.is_stopped(BELIEVED, |bench| {
            bench.devices.drive.set_emergency_stop(true)
        });
        bench.until_published("motors-off", Duration::from_secs(1));
        // While it is pressed, a reset says so, and that it was of no use.
        bench.is_refused("reset", "motors-off");
        bench.is_refused("reset", "release that");
        // That the cause is gone is not enough.
        bench.devices.drive.clear_faults();
        bench.stands_for(Duration::from_millis(500));
        assert!(!bench.ctl("resume").status.success(), "resume is no reset");
        bench.stands_for(Duration::from_millis(500));
        bench.ask("reset");
        bench.until_driving();
        assert!(!bench.publishes("motors-off"));
        bench.finish();
    });
}
