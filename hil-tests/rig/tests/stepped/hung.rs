//! A thread of the robot's own program hangs, or the supervisor does.

use onboard::process::ctl::Request;
use onboard::symbols::faults::Fault;

use crate::bench::Bench;

/// Within which a hung thread is found: a second without a cycle, judged once a second.
const FOUND_S: f64 = 2.2;

#[test]
fn a_thread_that_hangs_stops_the_robot_until_a_reset() {
    for thread in ["fieldbus", "motion", "lidar", "navigation"] {
        let mut bench = Bench::driving();
        // It says what it is before it stops, unless the thread itself would have to say it.
        bench.hang(&[thread]);
        bench.until_raised(Fault::ThreadHung, FOUND_S);
        bench.until_standing(3.0);
        bench.stands_for(3.0);
        bench.hang(&[]);
        // That it runs again is not enough.
        bench.stands_for(5.0);
        bench.ask(Request::Reset);
        bench.until("it drives", 20.0, |bench| {
            // What was gone meanwhile may want a word too.
            if bench.has(Fault::DriveReturned) {
                bench.ask(Request::Reset);
            }
            bench.truth().twist.v_m_s > 0.1
        });
        assert!(!bench.has(Fault::ThreadHung), "{thread}");
        bench.finish();
    }
}

#[test]
fn without_its_supervisor_the_robot_stops_and_goes_on_when_it_is_back() {
    /// Until it is silent.
    const SILENT_S: f64 = 1.1;
    let mut bench = Bench::driving();
    bench.hang(&["supervisor"]);
    bench.drives_for(0.8);
    bench.is_stopped(SILENT_S - 0.8, |_| {});
    bench.stands_for(5.0);
    bench.hang(&[]);
    bench.until_driving();
    assert_eq!(bench.raised(Fault::SupervisorSilent), 1);
    assert!(!bench.has(Fault::SupervisorSilent));
    bench.finish();
}

#[test]
fn a_supervisor_that_is_held_up_for_a_moment_stops_nobody() {
    let mut bench = Bench::driving();
    for _ in 0..5 {
        bench.hang(&["supervisor"]);
        bench.drives_for(0.7);
        bench.hang(&[]);
        bench.drives_for(0.5);
    }
    assert_eq!(bench.raised(Fault::SupervisorSilent), 0);
    bench.finish();
}
