//! The drive's emergency stops, and a wheel that does not obey. Its other faults are in `stepped.rs` and in `wheels`.

use std::time::Duration;

use sim::world::Mechanics;

use crate::programs::bench::Bench;
use crate::programs::late::once_more_if_late;

/// A fault is believed after 50 ms, so that noise stops nobody.
const BELIEVED: Duration = Duration::from_millis(50);
/// The drive's own watchdog, which ends a setpoint that nobody renews.
const WATCHDOG: Duration = Duration::from_millis(100);

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

/// The button that cuts the drive's logic supply as well.
#[test]
fn a_button_that_cuts_all_holds_it_until_an_operator_agrees() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        let faults = bench.devices.bus_faults.clone();
        bench.is_stopped(WATCHDOG, |_| faults.power_off(0));
        bench.until_published("bus-lost", Duration::from_secs(1));
        // Whoever holds it down and resets the robot has not seen the drive come back.
        bench.stands_for(Duration::from_millis(1500));
        bench.is_refused("reset", "bus-lost");
        faults.power_on(0);
        bench.until_published("drive-returned", Duration::from_secs(5));
        bench.stands_for(Duration::from_millis(500));
        assert!(!bench.ctl("resume").status.success(), "resume is no reset");
        bench.stands_for(Duration::from_millis(500));
        bench.ask("reset");
        bench.until_driving();
        bench.finish();
    });
}

#[test]
fn a_wheel_that_turns_the_wrong_way_is_named_with_what_it_was_told_and_does() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        let before_m = bench.truth().distance_m;
        let reversed = Mechanics {
            reversed: [false, true],
            ..Mechanics::default()
        };
        let is_reversed = |bench: &Bench| bench.world.lock().wear(0, reversed);
        bench.ask("pause");
        bench.until("it stands", Duration::from_secs(3), |bench| {
            bench.truth().twist.v_m_s.abs() < 0.01
        });
        is_reversed(&bench);
        bench.ask("resume");
        bench.until_published("wheels-disobey", Duration::from_secs(3));
        bench.stands_for(Duration::from_secs(1));
        assert!(bench.truth().distance_m - before_m < 0.5);
        let log = bench.log();
        let told = { log.lines() }.find(|line| line.contains("the right wheel was told"));
        let told = told.unwrap_or_else(|| panic!("which wheel: {log}"));
        assert!(
            told.contains("turns at") && told.contains("beyond"),
            "{told}"
        );
        bench.world.lock().wear(0, Mechanics::default());
        bench.ask("reset");
        bench.until_driving();
        bench.finish();
    });
}
