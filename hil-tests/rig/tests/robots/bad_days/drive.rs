//! The drive reports that something is wrong with it.

use std::time::Duration;

use sim::kelo::DriveHandle;

use crate::bad_days::bench::Bench;
use crate::late::once_more_if_late;

/// A fault is believed after 50 ms, so that noise stops nobody.
const BELIEVED: Duration = Duration::from_millis(50);
const OVERTEMPERATURE_1: u16 = 0x0200;

#[test]
fn low_voltage_motor_faults_and_the_emergency_stop_hold_it_until_an_operator_agrees() {
    once_more_if_late(|| {
        type Inject = fn(&DriveHandle);
        let cases: [(&str, Inject); 3] = [
            // Still enough for the motors, which the stop needs.
            ("bus-voltage", |drive| drive.set_bus_voltage(Some(18.0))),
            ("drive-fault", |drive| {
                drive.set_status1_bits(OVERTEMPERATURE_1, 0)
            }),
            ("motors-off", |drive| drive.set_emergency_stop(true)),
        ];
        let mut bench = Bench::driving();
        for (fault, inject) in cases {
            bench.is_stopped(BELIEVED, |bench| inject(&bench.devices.drive));
            bench.until_published(fault, Duration::from_secs(1));
            // That the cause is gone is not enough.
            bench.devices.drive.clear_faults();
            bench.stands_for(Duration::from_secs(2));
            assert!(!bench.ctl("resume").status.success(), "resume is no reset");
            bench.stands_for(Duration::from_millis(500));
            bench.ask("reset");
            bench.until_driving();
            assert!(!bench.publishes(fault));
        }
        bench.finish();
    });
}
