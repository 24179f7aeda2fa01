//! The robot's computer sleeps, and wakes: nobody has seen what became of the robot meanwhile.

use description::geometry::Pose2;
use onboard::process::ctl::{Place, Refusal, Request, Spot, Teleop};
use onboard::symbols::faults::Fault;

use crate::bench::Bench;

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
    bench.ask(Request::Reset);
    stands_after(&mut bench, 5.0);
    let replies = bench.replies();
    let slept = { replies.iter() }.filter(|(_, reply)| *reply == Err(Refusal::Slept));
    assert_eq!(slept.count(), 2, "{replies:?}");
    bench.finish();
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
