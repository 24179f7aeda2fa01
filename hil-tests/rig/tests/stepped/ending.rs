//! A process that is told to end, and what the next one knows.

use onboard::process::ctl::{Done, Request};
use onboard::symbols::faults::Fault;

use crate::bench::Bench;

/// An orderly end, a new start, and the emergency stop released meanwhile: as after `systemctl restart`, or a reboot.
#[test]
fn a_robot_that_waited_for_an_operator_waits_for_one_in_its_next_process() {
    type Change = fn(&mut Bench);
    let cases: [(&str, Change, Change); 2] = [
        (
            "emergency stop",
            |bench| {
                bench.devices.drive_faults().set_emergency_stop(true);
                bench.until_raised(Fault::MotorsOff, 2.0);
            },
            |bench| bench.devices.drive_faults().clear_faults(),
        ),
        ("stop", |bench| bench.ask(Request::Stop), |_| ()),
    ];
    for (name, stops, goes) in cases {
        let mut bench = Bench::driving();
        stops(&mut bench);
        bench.until_standing(3.0);
        bench.end();
        goes(&mut bench);
        bench.begin_again();
        bench.stands_for(8.0);
        assert!(bench.has(Fault::OperatorStop), "{name}");
        let (reply, _) = bench.answer_to(Request::Reset);
        assert_eq!(reply, Ok(Done::Reset(Vec::new())), "{name}");
        bench.until_driving();
        bench.finish();
    }
}

#[test]
fn a_robot_that_was_paused_is_paused_in_its_next_process_and_one_that_drove_drives() {
    let mut bench = Bench::driving();
    bench.ask(Request::Pause);
    bench.until_standing(3.0);
    bench.end();
    bench.begin_again();
    bench.stands_for(8.0);
    let (reply, _) = bench.answer_to(Request::Resume);
    assert_eq!(reply, Ok(Done::Running));
    bench.until_driving();
    bench.end();
    bench.put_at_its_start();
    bench.begin_again();
    bench.until_driving();
    bench.finish();
}
