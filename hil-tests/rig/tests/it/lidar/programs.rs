//! The lidar sees something in front, is unplugged, or hangs. More of it is in `stepped.rs` and in `obstacle`.

use std::time::Duration;

use sim::world::{Obstacle, Shape};

use crate::programs::bench::Bench;
use crate::programs::late::once_more_if_late;

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
        faults.replug();
        // 2 s of good scans come first.
        bench.stands_for(Duration::from_millis(1500));
        bench.until_driving();
        assert!(!bench.publishes("lidar-lost") && !bench.publishes("scan-silent"));

        bench.is_stopped(SCAN_TIMEOUT + REACTION, |_| faults.freeze());
        faults.thaw();
        bench.until_driving();
        bench.finish();
    });
}

#[test]
fn it_stands_before_a_wall_that_appears_and_drives_on_when_it_has_gone() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        // Across the whole corridor: no way around it.
        let wall = Obstacle::fixed(Shape::Box {
            pose: bench.ahead(0.32 + 1.0, 0.0),
            length_m: 0.1,
            width_m: 3.0,
        });
        let wall = bench.world.lock().add_obstacle(wall).expect("added");
        bench.until_published("no-free-tube", Duration::from_secs(20));
        bench.until_standing(Duration::from_secs(6));
        let truth = bench.truth();
        assert!(
            truth.clearance_m > 0.02 && truth.collisions == 0,
            "{truth:?}"
        );
        assert!(bench.world.lock().remove_obstacle(wall));
        bench.until_driving();
        bench.finish();
    });
}
