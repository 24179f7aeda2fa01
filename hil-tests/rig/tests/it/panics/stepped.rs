//! A part of the robot's own program panics.

use onboard::symbols::faults::Fault;
use rig::scenario::{ScriptedFault, ScriptedKind};

use crate::stepped::bench::Bench;

/// A thread panics when its turn is over, for which the lidar's waits longest; a cycle later motors are told to stop.
const PANICS_WITHIN_S: f64 = 0.12;
/// A robot at full speed ramps down in 0.2 s, its supervisor sees that it stands, and its activities have a second to stop.
const ENDS_WITHIN_S: f64 = 3.0;

#[test]
fn a_panic_of_any_thread_ramps_the_robot_to_a_stop_and_ends_its_process() {
    // One that talks with nobody has no thread of communication.
    for thread in ["fieldbus", "motion", "lidar", "navigation", "supervisor"] {
        let mut bench = Bench::driving();
        // At full speed: while it accelerates it would go on to until its thread's turn is over.
        bench.drives_for(2.0);
        bench.panic(thread);
        // By its own ramp, which is harder than what the drive's watchdog would leave to friction.
        bench.is_stopped(PANICS_WITHIN_S, |_| {});
        let says_so = thread != "supervisor";
        assert!(!says_so || bench.has(Fault::Panic), "{thread}");
        bench.until("its process ends", ENDS_WITHIN_S, |bench| bench.has_ended());
        bench.stands_for(2.0);
        bench.finish();
    }
}

/// Its own thread says nothing of the wheels any more. Whoever ends the process waits until it has had its time.
#[test]
fn a_panic_of_the_fieldbus_ramps_a_robot_that_brakes_softly_to_a_stop() {
    let mut bench = Bench::driving_with(&[
        "drive.stop_deceleration_m_s2=0.25",
        "drive.deceleration_m_s2=0.25",
        "navigation.deceleration_m_s2=0.2",
    ]);
    bench.drives_for(4.0);
    let before_m_s = bench.truth().twist.v_m_s;
    bench.panic("fieldbus");
    bench.until("its process ends", ENDS_WITHIN_S + 2.0, |bench| {
        bench.has_ended()
    });
    let after_m_s = bench.truth().twist.v_m_s;
    assert!(
        before_m_s > 0.35 && after_m_s < 0.02,
        "{before_m_s}: {after_m_s} m/s"
    );
    bench.finish();
}

/// A thread of a process that is gone has no turn any more in which it could panic.
#[test]
fn a_process_can_be_killed_before_its_thread_comes_to_panic() {
    for thread in ["fieldbus", "motion", "lidar", "navigation"] {
        let mut bench = Bench::driving();
        bench.panic(thread);
        drop(bench);
    }
}

#[test]
fn a_robot_does_not_stop_for_the_panic_of_another_one_in_the_same_process() {
    let (mut one, mut other) = (Bench::driving(), Bench::driving());
    one.panic("navigation");
    one.until("its process ends", ENDS_WITHIN_S, |bench| bench.has_ended());
    other.drives_for(3.0);
    assert!(!other.has(Fault::Panic) && !other.has_ended());
    other.finish();
}

#[test]
fn a_robot_that_is_started_again_after_a_panic_waits_for_an_operator() {
    for thread in ["navigation", "supervisor"] {
        let mut scenario = crate::stepped::scenario("lap").with_at_most(1);
        scenario.faults = vec![ScriptedFault {
            at_s: 12.0,
            for_s: 4.0,
            what: ScriptedKind::Panic,
            robot: Some("amr-1".to_owned()),
            share: None,
            by_s: None,
            thread: Some(thread.to_owned()),
            pose: None,
            motion: None,
            way: None,
            mediator: None,
        }];
        let (_, summary) = crate::stepped::ended(&scenario, &crate::stepped::plans(&scenario), 3);
        assert!(summary.passed(), "{thread}: {summary:?}");
        let own = &summary.robots[0];
        let stopped = own.faults.iter().any(|(name, _)| name == "operator-stop");
        assert!(stopped && own.resets > 0, "{thread}: {own:?}");
    }
}
