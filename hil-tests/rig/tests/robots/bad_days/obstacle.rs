//! Something appears in front.

use std::time::Duration;

use sim::world::{Obstacle, Shape};

use crate::bad_days::bench::Bench;

#[test]
fn it_stands_before_a_wall_that_appears_and_drives_on_when_it_has_gone() {
    let mut bench = Bench::driving();
    // Across the whole corridor: no way around it.
    let wall = Shape::Box {
        pose: bench.ahead(0.32 + 1.0, 0.0),
        length_m: 0.1,
        width_m: 3.0,
    };
    let wall = bench.world.lock().add_obstacle(Obstacle::fixed(wall));
    let wall = wall.expect("added");
    // What has just appeared may walk on, so at first it waits at a distance, then creeps up to it.
    bench.until("the fault is published", Duration::from_secs(20), |bench| {
        bench.publishes("no-free-tube")
    });
    bench.until_standing(Duration::from_secs(6));
    bench.stands_for(Duration::from_secs(2));
    let truth = bench.truth();
    assert!(
        truth.clearance_m > 0.02 && truth.collisions == 0,
        "{truth:?}"
    );

    assert!(bench.world.lock().remove_obstacle(wall));
    // It wants to have seen it free for 2 s.
    bench.stands_for(Duration::from_millis(1500));
    bench.until_driving();
    assert!(!bench.publishes("no-free-tube"));
    bench.finish();
}

#[test]
fn it_stands_before_a_box_in_its_lane() {
    let mut bench = Bench::driving();
    let shape = Shape::Box {
        pose: bench.ahead(0.32 + 0.8, 0.0),
        length_m: 0.4,
        width_m: 0.8,
    };
    let id = bench.world.lock().add_obstacle(Obstacle::fixed(shape));
    let id = id.expect("added");
    bench.until("the fault is published", Duration::from_secs(20), |bench| {
        bench.publishes("no-free-tube")
    });
    // It creeps up to where even the shortest tube ends.
    bench.until_standing(Duration::from_secs(20));
    bench.stands_for(Duration::from_secs(1));
    let truth = bench.truth();
    assert!(
        truth.clearance_m > 0.02 && truth.collisions == 0,
        "{truth:?}"
    );
    assert!(bench.world.lock().remove_obstacle(id));
    bench.until_driving();
    bench.finish();
}
