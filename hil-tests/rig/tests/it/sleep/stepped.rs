//! The robot's computer sleeps, and wakes: nobody has seen what became of the robot meanwhile.

use description::geometry::Pose2;
use onboard::process::ctl::{Done, Place, Refusal, Request, Spot, Teleop};
use onboard::symbols::faults::Fault;

use crate::stepped::bench::Bench;

/// The drive's own watchdog stops the wheels, and nothing starts them.
fn stands_after(bench: &mut Bench, slept_s: f64) {
    bench.sleep(slept_s);
    bench.stands_for(5.0);
    assert!(bench.has(Fault::PlaceUnknown));
}

#[test]
fn a_robot_whose_computer_has_slept_waits_to_be_told_where_it_is() {
    for slept_s in [0.4, 3.0, 90.0] {
        let mut bench = Bench::driving();
        // Until the wheels have come to a stand it does not judge its pose.
        stands_after(&mut bench, slept_s);
        let (reply, _) = bench.answer_to(Request::Reset);
        assert!(
            matches!(&reply, Err(Refusal::Remaining(faults)) if faults.contains(&Fault::PlaceUnknown)),
            "{reply:?}"
        );
        bench.stands_for(3.0);
        let pose = bench.truth().pose;
        let at = Spot::Pose(Pose2::new(pose.x_m, pose.y_m, pose.theta_rad));
        bench.ask(Request::Place(Place { at, state: None }));
        bench.stands_for(2.0);
        bench.until("it drives", 20.0, |bench| {
            let waits = bench.has(Fault::OperatorStop) || bench.has(Fault::DriveReturned);
            if waits && !bench.owes_an_answer() {
                bench.ask(Request::Reset);
            }
            bench.truth().twist.v_m_s > 0.1
        });
        bench.finish();
    }
}

#[test]
fn what_was_asked_before_it_slept_is_asked_again() {
    let mut bench = Bench::driving();
    // It waits for the supervisor, which does not run any more.
    bench.ask(Request::Place(Place {
        at: Spot::Start,
        state: None,
    }));
    for request in [Request::Reset, Request::Stop] {
        bench.ask(request);
    }
    stands_after(&mut bench, 5.0);
    let replies = bench.replies();
    let slept = { replies.iter() }.filter(|(_, reply)| *reply == Err(Refusal::Slept));
    assert_eq!(slept.count(), 2, "{replies:?}");
    // But to stop it is never too late.
    assert_eq!(replies[2], ("stop", Ok(Done::Stopped)));
    assert!(bench.has(Fault::OperatorStop));
    bench.finish();
}

/// It was put there, and its walls were looked at, when it fell asleep.
#[test]
fn what_was_said_of_its_place_before_it_slept_is_no_answer() {
    let mut bench = Bench::driving();
    bench.ask(Request::Stop);
    bench.until_standing(3.0);
    bench.ask(Request::Place(Place {
        at: Spot::Start,
        state: None,
    }));
    bench.watch(0.5);
    stands_after(&mut bench, 5.0);
    let replies = bench.replies();
    assert_eq!(replies[1], ("place", Err(Refusal::Slept)), "{replies:?}");
    bench.finish();
}

/// Communication says so as well: it does not say that it is located.
#[test]
#[ignore = "CI makes these runs"]
fn its_fleet_does_not_take_it_to_be_where_it_was() {
    let mut scenario = crate::stepped::scenario("overtaking").with_at_most(1);
    let sleeps = "at_s = 24.0\nfor_s = 4.0\nwhat = \"sleep\"\nrobot = \"amr-1\"";
    scenario.faults = vec![toml::from_str(sleeps).expect("a fault")];
    let (_, summary) = crate::stepped::ended(&scenario, &crate::stepped::plans(&scenario), 5);
    assert!(summary.passed(), "{summary:?}");
    let faults = &summary.robots[0].faults;
    let raised = faults.iter().find(|(name, _)| name == "place-unknown");
    assert_eq!(raised.map(|(_, count)| *count), Some(2), "{faults:?}");
}

#[test]
fn who_drives_by_hand_has_to_take_it_anew() {
    let mut bench = Bench::driving();
    bench.ask(Request::Teleop(Teleop::default()));
    bench.until("it is in hands", 1.0, |bench| bench.desk().is_taken());
    bench.desk().want(0.2, 0.0);
    bench.until("it is driven", 5.0, |bench| {
        bench.truth().twist.v_m_s > 0.15
    });
    stands_after(&mut bench, 2.0);
    assert!(!bench.desk().is_taken());
    bench.finish();
}
