//! A process that is told to end, and what the next one knows.

use onboard::process::ctl::{Done, Place, Request, Spot};
use onboard::symbols::faults::Fault;
use sim::lidar::Disturbance;

use crate::stepped::bench::Bench;

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

/// The button that takes the drive's supply as well, while the process ends: whoever releases it starts no robot.
#[test]
fn a_robot_that_ends_while_its_drive_is_gone_waits_for_an_operator_in_its_next_process() {
    for gone_s in [0.3, 1.5, 20.0] {
        let mut bench = Bench::driving();
        bench.devices.bus_faults().power_off(0);
        bench.until_raised(Fault::BusLost, 1.0);
        bench.watch(gone_s);
        bench.end();
        bench.devices.bus_faults().power_on(0);
        bench.begin_again();
        bench.stands_for(8.0);
        assert!(bench.has(Fault::OperatorStop), "{gone_s} s");
        bench.ask(Request::Reset);
        bench.until_driving();
        bench.finish();
    }
}

/// Killed, and the drive has kept its power: the next one finds it at its first attempt, as if nothing had been.
#[test]
fn a_robot_that_is_killed_while_its_drive_is_gone_waits_for_an_operator_in_its_next_process() {
    for gone_s in [0.3, 1.5] {
        let mut bench = Bench::driving();
        let faults = bench.devices.bus_faults().clone();
        faults.disappear(0);
        bench.until_raised(Fault::BusLost, 1.0);
        bench.watch(gone_s);
        assert!(!bench.has(Fault::BringUpLimit), "{gone_s} s");
        faults.reappear(0);
        bench.begin_again();
        bench.stands_for(8.0);
        assert!(bench.has(Fault::OperatorStop), "{gone_s} s");
        bench.ask(Request::Reset);
        bench.until_driving();
        bench.finish();
    }
}

/// One that has never had its drive has not begun to look for an emergency stop either.
#[test]
fn a_robot_that_ends_before_it_had_its_drive_waits_for_an_operator_in_its_next_process() {
    let mut bench = Bench::standing();
    bench.devices.bus_faults().power_off(0);
    bench.watch(3.0);
    bench.end();
    bench.devices.bus_faults().power_on(0);
    bench.begin_again();
    bench.stands_for(8.0);
    assert!(bench.has(Fault::OperatorStop));
    bench.ask(Request::Reset);
    bench.until_driving();
    bench.finish();
}

/// Killed before that, as with its computer, it has been nowhere else than at its start.
#[test]
fn a_robot_that_is_killed_before_it_had_its_drive_begins_afresh() {
    let mut bench = Bench::standing();
    bench.devices.bus_faults().power_off(0);
    bench.watch(3.0);
    assert!(bench.has(Fault::BusLost));
    bench.devices.bus_faults().power_on(0);
    bench.begin_again();
    bench.until_driving();
    bench.finish();
}

/// Somebody stops it while it waits for its lidar, and switches it off to plug that in.
#[test]
fn a_robot_that_is_stopped_before_it_has_begun_is_stopped_in_its_next_process() {
    for switched_off in [false, true] {
        let mut bench = Bench::standing();
        bench.devices.unplug_lidar();
        bench.watch(3.0);
        let (reply, _) = bench.answer_to(Request::Stop);
        assert_eq!(reply, Ok(Done::Stopped));
        bench.watch(0.5);
        if switched_off {
            bench.lose_memory();
        }
        let now_ns = bench.now_ns;
        bench.devices.plug_in_lidar(now_ns);
        bench.begin_again();
        bench.stands_for(10.0);
        assert!(bench.has(Fault::PlaceUnknown) || bench.has(Fault::OperatorStop));
        bench.put_at_its_start();
        let place = Place {
            at: Spot::Start,
            state: None,
        };
        assert!(bench.answer_to(Request::Place(place)).0.is_ok());
        let (reply, _) = bench.answer_to(Request::Reset);
        assert!(matches!(reply, Ok(Done::Reset(_))), "{reply:?}");
        bench.until_driving();
        bench.finish();
    }
}

#[test]
fn a_robot_of_which_a_part_panics_before_it_has_begun_is_stopped_in_its_next_process() {
    let mut bench = Bench::standing();
    bench.devices.unplug_lidar();
    bench.watch(3.0);
    bench.panic("navigation");
    bench.until("it has ended", 5.0, Bench::has_ended);
    let now_ns = bench.now_ns;
    bench.devices.plug_in_lidar(now_ns);
    bench.begin_again();
    bench.stands_for(8.0);
    assert!(bench.has(Fault::PlaceUnknown) || bench.has(Fault::OperatorStop));
    bench.finish();
}

/// It was paused where it ended; started again, it waits for its lidar, and is switched off once more.
#[test]
fn a_robot_that_was_switched_on_in_vain_still_knows_where_it_ended() {
    let mut bench = Bench::driving();
    bench.ask(Request::Pause);
    bench.until_standing(3.0);
    bench.end();
    bench.devices.unplug_lidar();
    bench.begin_again();
    bench.watch(3.0);
    bench.lose_memory();
    let now_ns = bench.now_ns;
    bench.devices.plug_in_lidar(now_ns);
    bench.put_at_its_start();
    bench.begin_again();
    bench.stands_for(8.0);
    assert!(!bench.has(Fault::PlaceUnknown) && !bench.has(Fault::OperatorStop));
    let (reply, _) = bench.answer_to(Request::Resume);
    assert_eq!(reply, Ok(Done::Running));
    bench.until_driving();
    bench.finish();
}

/// However often it is started again: nobody has said where it stands.
#[test]
fn a_robot_that_does_not_know_where_it_is_does_not_know_it_in_its_next_process() {
    type Ends = fn(&mut Bench);
    let ends: [(&str, Ends); 3] = [
        ("killed", |_| ()),
        ("told to end", Bench::end),
        ("switched off", |bench| bench.lose_memory()),
    ];
    for (how, ends) in ends {
        let mut bench = Bench::driving();
        bench.watch(3.0);
        bench.lose_memory();
        bench.begin_again();
        bench.until_standing(1.5);
        for _ in 0..3 {
            bench.stands_for(5.0);
            assert!(bench.has(Fault::PlaceUnknown), "{how}");
            let (reply, _) = bench.answer_to(Request::Reset);
            assert!(reply.is_err(), "{how}: {reply:?}");
            ends(&mut bench);
            bench.begin_again();
        }
        bench.put_at_its_start();
        let start = Place {
            at: Spot::Start,
            state: None,
        };
        let (reply, _) = bench.answer_to(Request::Place(start));
        assert!(reply.is_ok(), "{how}: {reply:?}");
        // Its place is one word, that it may drive another.
        bench.stands_for(3.0);
        assert!(!bench.has(Fault::PlaceUnknown) && bench.has(Fault::OperatorStop));
        bench.ask(Request::Reset);
        bench.until_driving();
        bench.finish();
    }
}

/// Switched off now, it would be taken for one that has never begun.
#[test]
fn a_robot_of_which_nothing_can_be_noted_does_not_drive() {
    let mut bench = Bench::standing();
    bench.fill_disk(true);
    bench.stands_for(10.0);
    assert!(bench.has(Fault::NoteUnwritten));
    bench.fill_disk(false);
    bench.until_driving();
    assert!(!bench.has(Fault::NoteUnwritten));
    // Once it is noted, it stays so.
    bench.fill_disk(true);
    bench.drives_for(3.0);
    bench.finish();
}

/// Its place is one of the files that it goes by, not of those that it began with.
#[test]
fn a_robot_that_is_killed_after_a_reload_goes_on_from_where_it_is() {
    let mut bench = Bench::driving();
    bench.reload_with(&["navigation.lookahead_m=0.5"]);
    bench.until_driving();
    bench.drives_for(2.0);
    bench.begin_again();
    bench.until_driving();
    assert_eq!(bench.raised(Fault::PlaceUnknown), 0);
    bench.finish();
}

/// Whoever has carried it, has carried it away from the floor that it has seen.
#[test]
fn floor_that_is_forgotten_is_not_kept_for_the_next_process() {
    let mut bench = Bench::driving();
    bench.watch(3.0);
    let cover = Disturbance::Cover { covered: true };
    bench.devices.disturb_lidar(cover, bench.now_ns);
    bench.until_standing(8.0);
    let floor_m = |bench: &Bench| bench.kept().expect("it runs").floor.cell_m;
    assert!(floor_m(&bench) > 0.0);
    bench.ask(Request::Stop);
    bench.watch(0.5);
    bench.put_at_its_start();
    let start = Place {
        at: Spot::Start,
        state: None,
    };
    let (reply, _) = bench.answer_to(Request::Place(start));
    assert!(reply.is_ok(), "{reply:?}");
    bench.watch(0.5);
    assert_eq!(floor_m(&bench), 0.0);
    bench.finish();
}
