//! Process data through FMMUs and SyncManagers, and its watchdog.

use super::cmd::*;
use super::*;

#[test]
fn one_exchange_counts_three() {
    let mut bench = Bench::new(1);
    bench.reach_op(0x64);
    let answer = bench.drive_for_ms(200, 5.0);
    assert_eq!(answer.counter, 3);
    assert_eq!(answer.data[36..40], [63, 0, 3, 8]);
    assert!((input_f32(&answer, 72) - 5.0).abs() < 0.05);
    assert_eq!(answer.data[0], 0x0B, "outputs come back as they were sent");
}

#[test]
fn reads_and_writes_count_one_each() {
    let mut bench = Bench::new(1);
    bench.reach_op(0x64);
    assert_eq!(bench.send(LWR, 0x1_0000, &[0; 36]).counter, 1);
    assert_eq!(bench.send(LRD, 0x1_0024, &[0; 172]).counter, 1);
    assert_eq!(bench.send(LRW, 0x1_0000, &[0; 36]).counter, 2);
    assert_eq!(
        bench.send(LRD, 0x2_0000, &[9; 4]),
        Answer {
            counter: 0,
            device: 0,
            data: vec![9; 4]
        }
    );
}

#[test]
fn before_safeop_there_are_no_inputs() {
    let mut bench = Bench::new(1);
    bench.request(2);
    bench.configure(0x64);
    assert_eq!(bench.send(LRD, 0x1_0024, &[0; 172]).counter, 0);
    bench.request(4);
    assert_eq!(bench.send(LRD, 0x1_0024, &[0; 172]).counter, 1);
}

#[test]
fn a_buffer_is_used_from_its_first_to_its_last_byte() {
    let mut bench = Bench::new(1);
    bench.reach_op(0x64);
    let enabled = |bench: &mut Bench| bench.read::<1>(0x1200)[0] & 3;
    // In two halves: nothing acts before the second.
    let half = |bench: &mut Bench, at: u16, data: &[u8]| {
        bench.send(APWR, address(0, 0x1100 + at), data).counter
    };
    assert_eq!(half(&mut bench, 18, &[0; 18]), 0, "not opened");
    let mut first = [0; 18];
    first[0] = 0x0B;
    assert_eq!(half(&mut bench, 0, &first), 1);
    bench.wait_ms(2);
    assert_eq!(bench.send(LRD, 0x1_0024, &[0; 172]).data[0] & 3, 0);
    assert_eq!(half(&mut bench, 18, &[0; 18]), 1);
    bench.wait_ms(2);
    assert_eq!(bench.send(LRD, 0x1_0024, &[0; 172]).data[0] & 3, 3);
    assert_eq!(
        enabled(&mut bench),
        3,
        "inputs can be opened by a first byte"
    );
    // The other buffers of the three are out of bounds, as is the wrong direction.
    assert_eq!(half(&mut bench, 36, &[0; 4]), 0);
    assert_eq!(half(&mut bench, 0, &[0; 37]), 0);
    assert_eq!(bench.send(APRD, address(0, 0x1100), &[0; 36]).counter, 0);
    assert_eq!(bench.send(APWR, address(0, 0x1200), &[0; 172]).counter, 0);
    // Memory that no SyncManager holds is free.
    assert_eq!(bench.send(APRW, address(0, 0x2800), &[1; 8]).counter, 3);
}

#[test]
fn of_two_units_the_one_with_the_lower_number_is_read() {
    let mut bench = Bench::new(1);
    bench.reach_op(0x64);
    // A unit left over from another MainDevice maps free memory over the inputs' place.
    bench.write(0x2800, &[0xEE; 4]);
    bench.write(
        0x0630,
        &[0x24, 0, 1, 0, 4, 0, 0, 7, 0x00, 0x28, 0, 1, 1, 0, 0, 0],
    );
    let answer = bench.drive_for_ms(2, 1.0);
    assert_eq!(
        (answer.counter, &answer.data[36..40]),
        (3, &[63, 0, 3, 8][..])
    );
}

#[test]
fn bits_are_mapped_too() {
    let mut bench = Bench::new(1);
    // Four bits of logical byte 0x20000, from bit 2, lie at bit 5 of memory byte 0x2800.
    bench.write(
        0x0600,
        &[0, 0, 2, 0, 1, 0, 2, 5, 0x00, 0x28, 5, 3, 1, 0, 0, 0],
    );
    bench.write(0x2800, &[0b0001_1111, 0b1111_1110]);
    let answer = bench.send(LRW, 0x2_0000, &[0b0010_1100]);
    assert_eq!(answer.counter, 3);
    assert_eq!(
        bench.read::<2>(0x2800),
        [0b0111_1111, 0b1111_1111],
        "written: 1011"
    );
    let answer = bench.send(LRD, 0x2_0000, &[0b1100_0011]);
    assert_eq!((answer.counter, answer.data[0]), (1, 0b1110_1111));
}

#[test]
fn silence_trips_the_watchdog() {
    let mut bench = Bench::new(1);
    bench.reach_op(0x64);
    bench.drive_for_ms(100, 5.0);
    bench.wait_ms(99);
    assert_eq!(bench.al(), (8, 0));
    bench.wait_ms(2);
    assert_eq!(bench.al(), (0x14, 0x1B));
    assert_eq!((bench.read_u16(0x0440), bench.read::<1>(0x0442)), (0, [1]));
    assert_eq!(bench.statistics.snapshot().watchdog_trips, 1);
    // Outputs are ignored now, and the wheels roll out.
    bench.drive_for_ms(400, 5.0);
    let answer = bench.drive(5.0);
    assert_eq!((answer.counter, answer.data[36] & 3), (3, 0));
    assert_eq!(input_f32(&answer, 72), 0.0);
    assert_eq!(bench.request(0x14), (4, 0));
    assert_eq!(bench.request(8), (8, 0));
    let answer = bench.drive_for_ms(50, 5.0);
    assert!(input_f32(&answer, 72) > 4.0);
    bench.write(0x0442, &[0]);
    assert_eq!(bench.read::<1>(0x0442), [0]);
}

#[test]
fn the_watchdog_waits_from_the_entry_into_op() {
    let mut bench = Bench::new(1);
    bench.reach_op(0x64);
    bench.wait_ms(102);
    assert_eq!(bench.al(), (0x14, 0x1B));
}

#[test]
fn its_time_can_be_set() {
    let mut bench = Bench::new(1);
    bench.write(0x0420, &200u16.to_le_bytes());
    bench.reach_op(0x64);
    bench.drive_for_ms(10, 1.0);
    bench.wait_ms(19);
    assert_eq!(bench.al(), (8, 0));
    bench.wait_ms(3);
    assert_eq!(bench.al(), (0x14, 0x1B));
}

#[test]
fn without_its_bit_or_its_time_it_never_trips() {
    for (control, time) in [(0x24, 1000u16), (0x64, 0)] {
        let mut bench = Bench::new(1);
        bench.reach_op(control);
        bench.write(0x0420, &time.to_le_bytes());
        let turning = bench.drive_for_ms(100, 5.0);
        bench.wait_ms(5000);
        assert_eq!(bench.al(), (8, 0));
        let answer = bench.drive(5.0);
        assert!(
            input_f32(&answer, 68) > input_f32(&turning, 68) + 20.0,
            "and the wheels go on"
        );
    }
}

#[test]
fn what_is_written_to_it_in_op_counts_at_once() {
    let mut bench = Bench::new(1);
    bench.reach_op(0x64);
    bench.write(0x0420, &[0, 0]);
    bench.wait_ms(5000);
    assert_eq!((bench.al(), bench.read_u16(0x0440)), ((8, 0), 1), "off");
    // Switched on again, it waits from then on.
    bench.write(0x0420, &1000u16.to_le_bytes());
    bench.wait_ms(99);
    assert_eq!(bench.al(), (8, 0));
    bench.wait_ms(2);
    assert_eq!((bench.al(), bench.read_u16(0x0440)), ((0x14, 0x1B), 0));
    // Off, it has not expired.
    bench.write(0x0420, &[0, 0]);
    assert_eq!(bench.read_u16(0x0440), 1);

    let mut bench = Bench::new(1);
    bench.reach_op(0x64);
    bench.drive_for_ms(10, 1.0);
    // Ticks of 10 µs.
    bench.write(0x0400, &248u16.to_le_bytes());
    bench.wait_ms(9);
    assert_eq!(bench.al(), (8, 0));
    bench.wait_ms(2);
    assert_eq!(bench.al(), (0x14, 0x1B));
}

#[test]
fn its_registers_outlive_init_but_not_power() {
    let mut bench = Bench::new(1);
    bench.reach_op(0x64);
    bench.write(0x0400, &[7, 7]);
    bench.write(0x0420, &[0, 0]);
    assert_eq!(bench.request(1), (1, 0));
    assert_eq!(
        (bench.read_u16(0x0400), bench.read_u16(0x0420)),
        (0x0707, 0)
    );
    let faults = bench.segment.faults();
    faults.power_off(0);
    bench.wait_ms(1);
    faults.power_on(0);
    bench.wait_ms(1);
    assert_eq!(
        (bench.read_u16(0x0400), bench.read_u16(0x0420)),
        (2498, 1000)
    );
}

#[test]
fn safeop_is_refused_while_the_outputs_feed_a_watchdog_that_is_off() {
    let mut bench = Bench::new(1);
    bench.write(0x0420, &[0, 0]);
    assert_eq!(bench.request(2), (2, 0));
    bench.configure(0x64);
    assert_eq!(bench.request(4), (0x12, 0x1F));
    bench.write(0x0420, &[1, 0]);
    assert_eq!(bench.request(0x14), (4, 0));
}

#[test]
fn losing_its_syncmanager_takes_it_out_of_op() {
    let mut bench = Bench::new(1);
    bench.reach_op(0x64);
    bench.drive_for_ms(10, 5.0);
    bench.write(0x0816, &[0]);
    assert_eq!(bench.al(), (0x12, 0x1D));
    bench.wait_ms(400);
    assert_eq!(bench.request(0x11), (1, 0));
}

#[test]
fn old_outputs_do_not_act_after_a_return_to_op() {
    let mut bench = Bench::new(1);
    bench.reach_op(0x64);
    bench.drive_for_ms(50, 5.0);
    bench.request(4);
    bench.wait_ms(400);
    bench.drive_for_ms(10, 5.0);
    assert_eq!(bench.request(8), (8, 0));
    bench.wait_ms(5);
    assert_eq!(bench.send(LRD, 0x1_0024, &[0; 172]).data[0] & 3, 0);
}
