//! Something appears in front.

use onboard::process::ctl::Request;
use onboard::symbols::faults::Fault;
use sim::world::Shape;

use crate::stepped::bench::Bench;

fn has_touched_nothing(bench: &Bench) {
    let truth = bench.truth();
    assert!(
        truth.clearance_m > 0.02 && truth.collisions == 0,
        "{truth:?}"
    );
}

#[test]
fn it_stands_before_a_wall_that_appears_and_drives_on_when_it_has_gone() {
    let mut bench = Bench::driving();
    // Across the whole corridor: no way around it.
    let wall = bench.add(Shape::Box {
        pose: bench.ahead(0.32 + 1.0),
        length_m: 0.1,
        width_m: 3.0,
    });
    // What has just appeared may walk on, so at first it waits at a distance, then creeps up to it.
    bench.until_raised(Fault::NoFreeTube, 15.0);
    bench.until_standing(4.0);
    bench.stands_for(20.0);
    has_touched_nothing(&bench);

    assert!(bench.world.lock().remove_obstacle(wall));
    // It wants to have seen it free for 2 s.
    bench.stands_for(1.9);
    bench.until_driving();
    assert!(!bench.has(Fault::NoFreeTube));
    bench.finish();
}

#[test]
fn it_stands_before_a_box_in_its_lane() {
    let mut bench = Bench::driving();
    let id = bench.add(Shape::Box {
        pose: bench.ahead(0.32 + 0.8),
        length_m: 0.4,
        width_m: 0.8,
    });
    bench.until_raised(Fault::NoFreeTube, 15.0);
    // It creeps up to where even the shortest tube ends.
    bench.until_standing(15.0);
    bench.stands_for(20.0);
    has_touched_nothing(&bench);
    assert!(bench.world.lock().remove_obstacle(id));
    bench.until_driving();
    bench.finish();
}

/// A reload that nobody stands beside is no word that the floor is free.
#[test]
fn after_a_reload_it_remembers_what_stands_where_it_does_not_look() {
    let mut bench = Bench::driving();
    bench.watch(6.0);
    bench.ask(Request::Stop);
    bench.until_standing(3.0);
    bench.watch(1.0);
    let floor = |bench: &mut Bench| {
        bench.watch(0.3);
        let kept = bench.kept().expect("it is kept");
        let bytes = bytemuck::bytes_of(&kept.floor).to_vec();
        (kept.floor.cell_m, bytes)
    };
    let (cell_m, before) = floor(&mut bench);
    bench.reload_with(&["navigation.lookahead_m=0.5"]);
    let (_, after) = floor(&mut bench);
    let differ = before
        .iter()
        .zip(&after)
        .filter(|(before, after)| before != after);
    let (known, differ) = (
        before.iter().filter(|&&byte| byte != 0).count(),
        differ.count(),
    );
    assert!(
        cell_m > 0.0 && known > 100 && differ < known / 20,
        "{differ} of {known}"
    );
    bench.finish();
}
