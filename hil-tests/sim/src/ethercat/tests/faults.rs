//! Faults of the bus, one at a time.

use std::time::Duration;

use super::cmd::*;
use super::*;

fn driving() -> Bench {
    let mut bench = Bench::new(1);
    bench.reach_op(0x64);
    assert_eq!(bench.drive_for_ms(50, 5.0).counter, 3);
    bench
}

fn brd(bench: &mut Bench) -> Option<Vec<Answer>> {
    bench.frame(&[(BRD, 0, &[0; 2])])
}

#[test]
fn lost_frames_do_nothing_lost_replies_have_acted() {
    let mut bench = driving();
    let faults = bench.segment.faults();
    let user = address(0, 0x0F80);
    faults.lose_next(1);
    assert_eq!(bench.frame(&[(APWR, user, &[1])]), None);
    assert_eq!(bench.read::<1>(0x0F80), [0]);
    faults.lose_next_replies(1);
    assert_eq!(bench.frame(&[(APWR, user, &[2])]), None);
    assert_eq!(bench.read::<1>(0x0F80), [2]);
    assert_eq!(bench.statistics.snapshot().lost, 2);
}

#[test]
fn frames_lost_for_long_trip_the_watchdog() {
    let mut bench = driving();
    bench
        .segment
        .faults()
        .lose_frames_for(Duration::from_millis(150));
    for _ in 0..150 {
        assert_eq!(brd(&mut bench), None);
        bench.wait_ms(1);
    }
    assert_eq!(bench.al(), (0x14, 0x1B));
}

#[test]
fn delay_copies_and_company_are_told_to_the_carrier() {
    let mut bench = driving();
    let faults = bench.segment.faults();
    faults.delay_next(1, Duration::from_millis(3));
    faults.duplicate_next(1);
    faults.foreign_before_next(1);
    let mut bytes = payload(&[(BRD, 0, &[0; 2])]);
    let reply = bench
        .segment
        .process_payload(&mut bytes, bench.now_ns)
        .unwrap();
    assert_eq!(
        (reply.delay, reply.copies, reply.foreign_before),
        (Duration::from_millis(3), 2, true)
    );
    let reply = bench
        .segment
        .process_payload(&mut bytes, bench.now_ns)
        .unwrap();
    assert_eq!(
        (reply.delay, reply.copies, reply.foreign_before),
        (Duration::ZERO, 1, false)
    );
}

#[test]
fn corruption_never_changes_process_data_alone() {
    let mut bench = driving();
    let clean = bench.drive(5.0);
    bench.segment.faults().corrupt_next(8);
    for _ in 0..8 {
        let mut bytes = payload(&[(LRW, 0x1_0000, &[0; 208])]);
        let sent = bytes.clone();
        let reply = bench
            .segment
            .process_payload(&mut bytes, bench.now_ns)
            .unwrap();
        let header_changed = bytes[2..12] != sent[2..12];
        let counter_wrong = bytes[bytes.len() - 2..] != [3, 0];
        assert!(reply.length < bytes.len() || header_changed || counter_wrong);
    }
    assert_eq!(bench.drive(5.0).counter, clean.counter);
}

#[test]
fn a_low_working_counter_takes_process_data_only() {
    let mut bench = driving();
    bench
        .segment
        .faults()
        .working_counter_low_for(Duration::from_millis(10));
    for _ in 0..10 {
        assert_eq!(bench.drive(5.0).counter, 0);
        assert_eq!(bench.al(), (8, 0));
        bench.wait_ms(1);
    }
    assert_eq!(bench.drive(5.0).counter, 3);
}

#[test]
fn states_can_be_lost() {
    let mut bench = driving();
    bench.segment.faults().drop_to_safeop(0);
    bench.wait_ms(1);
    assert_eq!(bench.al(), (0x14, 0x1A));
    let mut bench = driving();
    bench.write(0x0010, &[1, 0x10]);
    bench.segment.faults().drop_to_init(0);
    bench.wait_ms(1);
    assert_eq!(bench.al(), (1, 0));
    assert_eq!(bench.read_u16(0x0010), 0, "registers are at their defaults");
    assert_eq!(bench.drive(5.0).counter, 0);
}

#[test]
fn a_fault_takes_effect_with_the_next_frame() {
    let mut bench = driving();
    let faults = bench.segment.faults();
    faults.drop_to_safeop(0);
    assert_eq!(bench.al(), (0x14, 0x1A));
    faults.disappear(0);
    assert_eq!(brd(&mut bench), None);
    faults.reappear(0);
    assert!(brd(&mut bench).is_some());
}

#[test]
fn behind_a_pulled_cable_the_watchdog_runs() {
    let mut bench = driving();
    let faults = bench.segment.faults();
    faults.disappear(0);
    bench.wait_ms(1);
    assert_eq!(brd(&mut bench), None);
    bench.wait_ms(150);
    faults.reappear(0);
    bench.wait_ms(1);
    assert_eq!(bench.al(), (0x14, 0x1B));
    assert_eq!(bench.read::<1>(0x0310), [1], "a lost link was counted");
}

#[test]
fn a_cable_in_the_middle_shortens_the_line() {
    let mut bench = Bench::new(3);
    let faults = bench.segment.faults();
    faults.disappear(1);
    bench.wait_ms(1);
    assert_eq!(brd(&mut bench).unwrap()[0].counter, 1);
    assert_eq!(bench.read_u16(0x0110), 0x5611, "port 1 is closed");
    faults.reappear(1);
    faults.power_off(2);
    bench.wait_ms(1);
    assert_eq!(brd(&mut bench).unwrap()[0].counter, 2);
    faults.power_on(2);
    bench.wait_ms(1);
    assert_eq!(brd(&mut bench).unwrap()[0].counter, 3);
}

#[test]
fn power_that_returns_finds_a_drive_in_init() {
    let mut bench = driving();
    let faults = bench.segment.faults();
    faults.power_off(0);
    bench.wait_ms(500);
    assert_eq!(brd(&mut bench), None);
    faults.power_on(0);
    bench.wait_ms(1);
    assert_eq!(bench.al(), (1, 0));
    bench.reach_op(0x64);
    let answer = bench.drive(0.0);
    assert_eq!(
        (input_f32(&answer, 68), input_f32(&answer, 72)),
        (0.0, 0.0),
        "encoders start anew, wheels stand"
    );
}

#[test]
fn a_stopped_clock_stops_the_time_stamps() {
    let mut bench = driving();
    bench.segment.faults().stop_clock(0, true);
    let before = bench.drive_for_ms(5, 5.0);
    let after = bench.drive_for_ms(5, 5.0);
    assert_eq!(input_u64(&before, 4), input_u64(&after, 4));
    bench.segment.faults().stop_clock(0, false);
    let later = bench.drive_for_ms(5, 5.0);
    assert!(input_u64(&later, 4) > input_u64(&after, 4));
}

#[test]
fn faults_of_positions_that_do_not_exist_have_no_effect() {
    let mut bench = driving();
    bench.segment.faults().power_off(7);
    bench.segment.faults().disappear(usize::MAX);
    bench.wait_ms(1);
    assert_eq!(bench.drive(5.0).counter, 3);
}

#[test]
fn a_starved_simulator_shows() {
    let mut bench = driving();
    bench.statistics.reset_longest_gap();
    bench.now_ns += 40 * MS;
    bench.drive(5.0);
    assert_eq!(bench.statistics.snapshot().longest_gap_ns, 40 * MS);
}
