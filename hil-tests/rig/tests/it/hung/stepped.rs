//! A thread of the robot's own program hangs, or the supervisor does.

use onboard::composition::plan::Budget;
use onboard::process::ctl::{Done, Request};
use onboard::symbols::faults::Fault;

use crate::stepped::bench::Bench;

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

/// Nobody would see to it that it can drive on.
#[test]
fn a_thread_that_hangs_while_the_robot_is_paused_is_found_too() {
    let mut bench = Bench::driving();
    bench.ask(Request::Pause);
    bench.until_standing(3.0);
    bench.stands_for(2.0);
    assert!(!bench.has(Fault::ThreadHung));
    bench.hang(&["navigation"]);
    bench.until_raised(Fault::ThreadHung, FOUND_S);
    bench.hang(&[]);
    bench.watch(1.0);
    for request in [Request::Reset, Request::Resume] {
        bench.answer_to(request).0.expect("it runs again");
    }
    bench.until_driving();
    bench.finish();
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

/// Nobody writes down what the drive has found, and the next process finds a drive that is well.
#[test]
fn an_emergency_stop_while_the_supervisor_hangs_outlives_the_process() {
    let mut bench = Bench::driving();
    bench.hang(&["supervisor"]);
    bench.watch(2.0);
    bench.devices.drive_faults().set_emergency_stop(true);
    bench.watch(1.0);
    bench.devices.drive_faults().clear_faults();
    bench.watch(2.0);
    bench.begin_again();
    bench.stands_for(8.0);
    assert!(bench.has(Fault::OperatorStop));
    let (reply, _) = bench.answer_to(Request::Reset);
    assert_eq!(reply, Ok(Done::Reset(Vec::new())));
    bench.until_driving();
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

/// What `onboard check` prints as the budget of lateness holds, whoever hangs, at any moment.
#[test]
fn whoever_hangs_the_robot_stands_within_the_budget() {
    for (thread, who) in [
        ("navigation", "motion tubes hang"),
        ("motion", "control hangs"),
        ("fieldbus", "the drive or its bus hangs"),
    ] {
        for moment_ms in [0, 13, 26, 39] {
            let mut bench = Bench::driving();
            bench.watch(3.0 + f64::from(moment_ms) * 1e-3);
            let budget = Budget::of(&bench.plan);
            let case = { budget.cases.iter() }.find(|case| case.who == who);
            let before = bench.truth();
            bench.hang(&[thread]);
            bench.watch(2.0);
            let truth = bench.truth();
            let way_m = truth.distance_m - before.distance_m;
            let most_m = case.expect("it is there").way_m(before.twist.v_m_s);
            assert!(
                truth.twist.v_m_s.abs() < 0.01 && way_m < most_m,
                "{who}: {way_m} m, expected at most {most_m}"
            );
            // And it uses it: the budget is no guess.
            assert!(way_m > 0.5 * most_m, "{who}: {way_m} m of {most_m}");
        }
    }
}

/// While a thread hangs, what is said to it piles up; a reset at that time is no less a reset.
#[test]
fn a_reset_while_a_thread_still_hangs_is_heard_when_it_runs_again() {
    for hung_s in [4.0, 6.0, 15.0] {
        let mut bench = Bench::driving();
        bench.hang(&["navigation"]);
        bench.until_raised(Fault::ThreadHung, FOUND_S);
        bench.watch(hung_s);
        bench.ask(Request::Reset);
        bench.watch(0.2);
        bench.hang(&[]);
        bench.until("it drives", 20.0, |bench| {
            // It may have been found to hang once more.
            if bench.has(Fault::ThreadHung) {
                bench.ask(Request::Reset);
            }
            bench.truth().twist.v_m_s > 0.1
        });
        bench.finish();
    }
}

#[test]
fn a_thread_that_overruns_slows_the_robot_down_and_then_stops_it_until_a_reset() {
    let mut bench = Bench::driving();
    bench.drives_for(3.0);
    let full_m_s = bench.truth().twist.v_m_s;
    // About one period in six is missed.
    bench.be_late("motion", 0.4, 10);
    bench.watch(2.5);
    for truth in bench.watch(2.0) {
        let share = truth.twist.v_m_s / full_m_s;
        assert!((0.4..0.6).contains(&share), "{share} of {full_m_s} m/s");
    }
    assert_eq!(bench.raised(Fault::Overruns), 0);
    // More than half of them, for seconds.
    bench.be_late("motion", 1.0, 20);
    bench.until_raised(Fault::Overruns, 5.0);
    bench.until_standing(1.0);
    bench.be_late("motion", 0.0, 0);
    bench.stands_for(5.0);
    bench.ask(Request::Resume);
    bench.stands_for(2.0);
    bench.ask(Request::Reset);
    bench.until_driving();
    let reaches = |bench: &mut Bench| bench.truth().twist.v_m_s > 0.9 * full_m_s;
    bench.until("it is as fast as before", 5.0, reaches);
    assert!(!bench.has(Fault::Overruns));
    bench.finish();
}

/// Its period begins when a scan wakes it, not when it gets its processor.
#[test]
fn navigation_that_wakes_up_late_slows_the_robot_down() {
    let mut bench = Bench::driving();
    bench.drives_for(3.0);
    let full_m_s = bench.truth().twist.v_m_s;
    bench.be_late("navigation", 1.0, 140);
    let slows = |bench: &mut Bench| bench.truth().twist.v_m_s < 0.6 * full_m_s;
    bench.until("it is slower", 4.0, slows);
    bench.be_late("navigation", 0.0, 0);
    assert_eq!(bench.raised(Fault::Overruns), 0);
    let reaches = |bench: &mut Bench| bench.truth().twist.v_m_s > 0.9 * full_m_s;
    bench.until("it is as fast as before", 10.0, reaches);
    bench.finish();
}

/// More reports than a queue holds wait for a supervisor that gets no time: what an operator has said stays said.
#[test]
fn reports_that_pile_up_while_the_supervisor_hangs_take_nothing_back_that_others_have_said() {
    let mut bench = Bench::driving();
    bench.ask(Request::Stop);
    bench.until_raised(Fault::OperatorStop, 1.0);
    bench.until_standing(3.0);
    bench.hang(&["supervisor"]);
    bench.be_late("motion", 1.0, 150);
    bench.watch(40.0);
    bench.be_late("motion", 0.0, 0);
    bench.hang(&[]);
    bench.stands_for(5.0);
    assert!(bench.raised(Fault::QueueFull) > 0, "no report was lost");
    assert!(bench.has(Fault::OperatorStop));
    bench.ask(Request::Reset);
    bench.until_driving();
    bench.finish();
}

/// An operator insists while a thread hangs, whose queue holds 32 commands.
#[test]
fn commands_that_a_hung_thread_does_not_take_are_counted() {
    let mut bench = Bench::driving();
    bench.hang(&["navigation"]);
    bench.until_raised(Fault::ThreadHung, FOUND_S);
    bench.until_standing(3.0);
    for _ in 0..40 {
        let (reply, _) = bench.answer_to(Request::Reset);
        assert!(reply.is_err(), "{reply:?}");
    }
    let lost = bench.raised(Fault::QueueFull);
    assert!((8..40).contains(&lost), "{lost}");
    bench.hang(&[]);
    bench.watch(2.0);
    bench.ask(Request::Reset);
    bench.until_driving();
    assert_eq!(bench.raised(Fault::QueueFull), lost);
    bench.finish();
}
