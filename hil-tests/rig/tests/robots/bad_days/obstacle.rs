//! Something appears in front.

use std::time::Duration;

use sim::world::{Obstacle, ObstacleId, Shape};

use crate::bad_days::bench::Bench;
use crate::late::once_more_if_late;

fn add(bench: &Bench, shape: Shape) -> ObstacleId {
    let added = bench.world.lock().add_obstacle(Obstacle::fixed(shape));
    added.expect("added")
}

fn has_touched_nothing(bench: &Bench) {
    let truth = bench.truth();
    assert!(
        truth.clearance_m > 0.02 && truth.collisions == 0,
        "{truth:?}"
    );
}

#[test]
fn it_stands_before_a_wall_that_appears_and_drives_on_when_it_has_gone() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        // Across the whole corridor: no way around it.
        let wall = Shape::Box {
            pose: bench.ahead(0.32 + 1.0, 0.0),
            length_m: 0.1,
            width_m: 3.0,
        };
        let wall = add(&bench, wall);
        // What has just appeared may walk on, so at first it waits at a distance, then creeps up to it.
        bench.until_published("no-free-tube", Duration::from_secs(20));
        bench.until_standing(Duration::from_secs(6));
        bench.stands_for(Duration::from_secs(2));
        has_touched_nothing(&bench);

        assert!(bench.world.lock().remove_obstacle(wall));
        // It wants to have seen it free for 2 s.
        bench.stands_for(Duration::from_millis(1500));
        bench.until_driving();
        assert!(!bench.publishes("no-free-tube"));
        bench.finish();
    });
}

#[test]
fn it_stands_before_a_box_in_its_lane() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        let shape = Shape::Box {
            pose: bench.ahead(0.32 + 0.8, 0.0),
            length_m: 0.4,
            width_m: 0.8,
        };
        let id = add(&bench, shape);
        bench.until_published("no-free-tube", Duration::from_secs(20));
        // It creeps up to where even the shortest tube ends.
        bench.until_standing(Duration::from_secs(20));
        bench.stands_for(Duration::from_secs(1));
        has_touched_nothing(&bench);
        assert!(bench.world.lock().remove_obstacle(id));
        bench.until_driving();
        bench.finish();
    });
}
