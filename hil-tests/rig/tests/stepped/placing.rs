//! An operator says where the robot stands, and what is behind it.

use description::geometry::Pose2;
use onboard::process::ctl::{FreeBehind, Place, Request, Spot};
use onboard::symbols::faults::Fault;
use sim::world::Pose;

use crate::bench::Bench;

fn place(at: Spot, state: Option<&str>) -> Request {
    Request::Place(Place {
        at,
        state: state.map(str::to_owned),
    })
}

/// How far it is from where it believes to be.
fn off_m(bench: &mut Bench) -> f64 {
    let (truth, believed) = (bench.truth().pose, bench.belief().pose);
    (truth.x_m - believed.x_m).hypot(truth.y_m - believed.y_m)
}

#[test]
fn a_robot_that_was_carried_goes_on_from_where_the_operator_says() {
    let mut bench = Bench::driving();
    bench.ask(Request::Stop);
    bench.until_standing(3.0);
    // To the other lane, the other way round.
    let there = Pose::new(6.0, 0.5, std::f64::consts::PI);
    bench.world.lock().carry(0, there).expect("room");
    bench.stands_for(1.0);
    assert!(off_m(&mut bench) > 1.0);
    let spot = Spot::Pose(Pose2::new(6.02, 0.49, 3.12));
    bench.ask(place(spot, Some("drive-4")));
    bench.stands_for(2.0);
    assert!(off_m(&mut bench) < 0.05);
    bench.ask(Request::Reset);
    bench.until_driving();
    bench.drives_for(3.0);
    assert!(off_m(&mut bench) < 0.05 && bench.belief().state == "drive-4");
    assert_eq!(bench.refused(), [""; 0]);
    bench.finish();
}

#[test]
fn the_word_of_an_operator_is_for_a_robot_that_stands() {
    let mut bench = Bench::driving();
    let behind = Request::FreeBehind(FreeBehind { way_m: 1.0 });
    for request in [place(Spot::Start, None), behind.clone()] {
        bench.ask(request);
        bench.drives_for(1.0);
    }
    let refused = bench.refused();
    let names_what_to_do = |why: &String| why.contains("onboard ctl stop");
    assert!(
        refused.len() == 2 && refused.iter().all(names_what_to_do),
        "{refused:?}"
    );
    bench.ask(Request::Pause);
    bench.until_standing(3.0);
    bench.ask(place(Spot::Start, Some("dance")));
    bench.ask(behind);
    bench.stands_for(1.0);
    let refused = bench.refused();
    assert!(
        refused.len() == 3 && refused[2].contains("`drive-1`"),
        "{refused:?}"
    );
    bench.ask(Request::Resume);
    bench.until_driving();
    bench.finish();
}

#[test]
fn a_reset_says_nothing_of_where_the_robot_stands() {
    // In a place without walls in view, and far from its start.
    let mut bench = Bench::driving();
    bench.watch(5.0);
    bench.ask(Request::Stop);
    bench.until_standing(3.0);
    bench.devices.bus_faults().power_off(0);
    bench.watch(2.0);
    bench.devices.bus_faults().power_on(0);
    bench.until_raised(Fault::DriveReturned, 5.0);
    for _ in 0..3 {
        bench.ask(Request::Reset);
        bench.watch(0.5);
        assert!(off_m(&mut bench) < 0.1, "{:?}", bench.belief());
    }
    bench.until_driving();
    bench.finish();
}
