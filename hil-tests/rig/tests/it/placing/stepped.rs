//! An operator says where the robot stands, and what is behind it.

use description::geometry::Pose2;
use onboard::process::ctl::{Done, FreeBehind, Place, Placement, Request, Spot};
use onboard::symbols::faults::Fault;
use sim::world::{Mechanics, Pose};

use crate::stepped::bench::Bench;

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

/// What has moved the robot meanwhile comes with the next reading of its wheels, and is no way from where it was placed.
#[test]
fn nobody_is_placed_while_its_wheels_are_not_counted() {
    type Change = fn(&mut Bench);
    let cases: [(Change, Change); 3] = [
        (
            |bench| bench.devices.bus_faults().disappear(0),
            |bench| bench.devices.bus_faults().reappear(0),
        ),
        (|bench| bench.hang(&["fieldbus"]), |bench| bench.hang(&[])),
        (|bench| bench.hang(&["motion"]), |bench| bench.hang(&[])),
    ];
    for (comes, goes) in cases {
        let mut bench = Bench::driving();
        bench.ask(Request::Stop);
        bench.until_standing(3.0);
        comes(&mut bench);
        bench.watch(1.0);
        let (reply, _) = bench.answer_to(place(Spot::Start, None));
        let why = reply.expect_err("it is refused").to_string();
        assert!(why.contains("its drive does not answer"), "{why}");
        goes(&mut bench);
        bench.until("the bus is there", 10.0, |bench| !bench.has(Fault::BusLost));
        bench.watch(0.5);
        let (reply, _) = bench.answer_to(place(Spot::Start, None));
        reply.expect("it is taken");
        bench.finish();
    }
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

/// It rolls, as it would if somebody pushed it: the walls of a corridor look the same everywhere.
#[test]
fn a_robot_that_was_pushed_while_no_program_ran_asks_where_it_is() {
    let mut bench = Bench::driving();
    bench.hang(&["fieldbus", "motion", "lidar", "navigation", "supervisor"]);
    bench.watch(1.0);
    let began_m = bench.truth().distance_m;
    let slope = Mechanics {
        slope_m_s2: [3.0, 0.0],
        ..Mechanics::default()
    };
    bench.world.lock().wear(0, slope);
    bench.until("it has rolled", 20.0, |bench| {
        bench.truth().distance_m > began_m + 2.5
    });
    bench.world.lock().wear(0, Mechanics::default());
    bench.until_standing(10.0);
    bench.begin_again();
    bench.until_raised(Fault::PlaceUnknown, 5.0);
    bench.stands_for(5.0);
    let there = bench.truth().pose;
    let spot = Spot::Pose(Pose2::new(there.x_m, there.y_m, there.theta_rad));
    let (reply, _) = bench.answer_to(place(spot, None));
    reply.expect("it is taken");
    bench.ask(Request::Reset);
    bench.until_driving();
    bench.finish();
}

/// Places it, and waits for what its walls say.
fn placed(bench: &mut Bench, x_m: f64, y_m: f64, theta_rad: f64) -> (Placement, String) {
    let spot = Spot::Pose(Pose2::new(x_m, y_m, theta_rad));
    let (reply, after_s) = bench.answer_to(place(spot, None));
    let said = reply.as_ref().map(ToString::to_string);
    let Ok(Done::Placed(placement)) = reply else {
        panic!("{reply:?}");
    };
    assert!((0.9..1.2).contains(&after_s), "{after_s} s");
    (placement, said.unwrap_or_default())
}

#[test]
fn walls_that_contradict_the_operators_word_are_shown() {
    let mut bench = Bench::driving();
    bench.ask(Request::Stop);
    bench.until_standing(3.0);
    let truth = bench.truth().pose;
    // Turned, and across the corridor. A small error is one that walls correct.
    let mut contradicted = 0;
    for (off_y_m, off_rad) in [
        (0.0, 0.6),
        (0.0, -0.6),
        (0.35, 0.0),
        (0.8, 0.0),
        (0.0, 0.25),
    ] {
        let (y_m, theta_rad) = (truth.y_m + off_y_m, truth.theta_rad + off_rad);
        let (wrong, said) = placed(&mut bench, truth.x_m, y_m, theta_rad);
        let off_m = (wrong.pose.y_m - truth.y_m).abs();
        if off_m < 0.1 && (wrong.pose.theta_rad - truth.theta_rad).abs() < 0.1 {
            continue;
        }
        assert!(
            wrong.looked && (wrong.contradict > 0 || wrong.unseen),
            "{wrong:?}"
        );
        assert!(said.contains("contradict"), "{said}");
        contradicted += 1;
    }
    assert!(contradicted >= 2, "{contradicted}");
    let (right, said) = placed(&mut bench, truth.x_m, truth.y_m, truth.theta_rad);
    assert!(
        right.looked && right.agree > 0 && right.contradict == 0,
        "{right:?}"
    );
    assert!(
        said.contains("agree") && !said.contains("contradict"),
        "{said}"
    );
    assert!((right.pose.x_m - truth.x_m).hypot(right.pose.y_m - truth.y_m) < 0.05);
    // Without a lidar nothing says whether it is true.
    bench.devices.unplug_lidar();
    bench.watch(1.0);
    let (unseen, said) = placed(&mut bench, truth.x_m, truth.y_m, truth.theta_rad);
    assert!(!unseen.looked, "{unseen:?}");
    assert!(said.contains("nothing confirms"), "{said}");
    bench.finish();
}
