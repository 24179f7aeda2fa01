//! Every command: who answers, what is counted, what changes.

use super::cmd::*;
use super::*;
use crate::ethercat::frame::{ETHERNET_HEADER, ETHERTYPE};

/// Bytes of user memory, free for any use.
const USER: u16 = 0x0F80;

fn two() -> Bench {
    let mut bench = Bench::new(2);
    assert_eq!(
        bench.send(APWR, address(0, 0x0010), &[0x01, 0x10]).counter,
        1
    );
    assert_eq!(
        bench
            .send(APWR, address(0xFFFF, 0x0010), &[0x02, 0x10])
            .counter,
        1
    );
    bench.send(APWR, address(0, USER), &[0x0F]);
    bench.send(APWR, address(0xFFFF, USER), &[0xF1]);
    bench
}

fn answer(counter: u16, device: u16, data: u8) -> Answer {
    Answer {
        counter,
        device,
        data: vec![data],
    }
}

/// Sends one byte to or from user memory and compares what comes back.
#[track_caller]
fn check(bench: &mut Bench, command: u8, device: u16, byte: u8, expected: Answer) {
    assert_eq!(
        bench.send(command, address(device, USER), &[byte]),
        expected
    );
}

#[test]
fn by_position() {
    let mut bench = two();
    check(&mut bench, APRD, 0, 9, answer(1, 2, 0x0F));
    check(&mut bench, APRD, 0xFFFF, 9, answer(1, 1, 0xF1));
    check(&mut bench, APRD, 0xFFFE, 9, answer(0, 0, 9));
    check(&mut bench, APRW, 0, 0xAA, answer(3, 2, 0x0F));
    check(&mut bench, APRD, 0, 9, answer(1, 2, 0xAA));
}

#[test]
fn by_station_address() {
    let mut bench = two();
    check(&mut bench, FPRD, 0x1002, 9, answer(1, 0x1002, 0xF1));
    check(&mut bench, FPRD, 0x1003, 9, answer(0, 0x1003, 9));
    check(&mut bench, FPWR, 0x1001, 0x55, answer(1, 0x1001, 0x55));
    check(&mut bench, FPRW, 0x1001, 0x66, answer(3, 0x1001, 0x55));
    check(&mut bench, FPRD, 0x1001, 9, answer(1, 0x1001, 0x66));
}

#[test]
fn to_all() {
    let mut bench = two();
    check(&mut bench, BRD, 0, 0, answer(2, 2, 0xFF));
    check(&mut bench, BRW, 0, 0, answer(6, 2, 0xFF));
    check(&mut bench, BWR, 7, 3, answer(2, 9, 3));
    check(&mut bench, BRD, 0, 0, answer(2, 2, 3));
}

#[test]
fn read_from_one_write_to_the_others() {
    let mut bench = two();
    check(&mut bench, ARMW, 0, 0, answer(2, 2, 0x0F));
    assert_eq!(bench.send(APRD, address(0xFFFF, USER), &[0]).data, [0x0F]);
    bench.send(APWR, address(0xFFFF, USER), &[0xF1]);
    check(&mut bench, FRMW, 0x1001, 0, answer(2, 0x1001, 0x0F));
    assert_eq!(bench.send(FPRD, address(0x1002, USER), &[0]).data, [0x0F]);
}

#[test]
fn nop_and_unknown_commands_pass() {
    let mut bench = two();
    for command in [0, 15, 0xFF] {
        check(&mut bench, command, 0, 7, answer(0, 0, 7));
    }
}

#[test]
fn datagrams_of_a_frame_are_carried_out_in_order() {
    let mut bench = Bench::new(1);
    let at = address(0, USER);
    let answers = bench
        .frame(&[
            (APWR, at, &[1]),
            (APRD, at, &[0]),
            (APWR, at, &[2]),
            (APRD, at, &[0]),
        ])
        .unwrap();
    let data: Vec<u8> = answers.iter().map(|answer| answer.data[0]).collect();
    assert_eq!(data, [1, 1, 2, 2]);
    assert_eq!(bench.statistics.snapshot().datagrams, 4);
}

#[test]
fn an_alias_answers_when_switched_on() {
    let options = KeloOptions {
        alias: 0x0777,
        ..KeloOptions::default()
    };
    let kelo = Kelo::new(Box::new(TestStand::new()), options);
    let mut bench = Bench::new(0);
    bench.segment = Segment::new(vec![SubDevice::new(Box::new(kelo), ReadSize::Eight)]);
    assert_eq!(bench.read_u16(0x0012), 0x0777);
    assert_eq!(bench.send(FPRD, address(0x0777, 0), &[0]).counter, 0);
    bench.write(0x0103, &[1]);
    assert_eq!(bench.send(FPRD, address(0x0777, 0), &[0]).counter, 1);
}

#[test]
fn the_first_subdevice_marks_the_source_address() {
    let mut bench = Bench::new(2);
    let mut frame = vec![0xFF; 6];
    frame.extend([0x10; 6]);
    frame.extend(ETHERTYPE.to_be_bytes());
    frame.extend(payload(&[(BRD, 0, &[0; 2])]));
    // Ethernet pads short frames.
    frame.resize(60, 0);
    let reply = bench
        .segment
        .process_frame(&mut frame, bench.now_ns)
        .unwrap();
    assert_eq!((reply.length, reply.copies), (60, 1));
    assert_eq!(
        frame[..14],
        [
            255, 255, 255, 255, 255, 255, 0x12, 16, 16, 16, 16, 16, 0x88, 0xA4
        ]
    );
    assert_eq!(frame[ETHERNET_HEADER + 2 + 12], 2, "working counter");
}

#[test]
fn foreign_frames_are_destroyed_unless_dl_control_says_otherwise() {
    let mut bench = Bench::new(1);
    let mut arp = [0; 60];
    arp[12..14].copy_from_slice(&[0x08, 0x06]);
    assert_eq!(bench.segment.process_frame(&mut arp, bench.now_ns), None);
    bench.write(0x0100, &[0]);
    assert!(
        bench
            .segment
            .process_frame(&mut arp, bench.now_ns)
            .is_some()
    );
    assert_eq!(bench.statistics.snapshot().foreign, 2);
}

#[test]
fn malformed_frames_are_counted_and_not_answered() {
    let mut bench = Bench::new(1);
    let mut bytes = payload(&[(BWR, address(0, 0x0120), &[2, 0])]);
    bytes[8] = 200;
    assert_eq!(
        bench.segment.process_payload(&mut bytes, bench.now_ns),
        None
    );
    bench.segment.cycle(bench.now_ns);
    assert_eq!(bench.read::<1>(0x030C), [1]);
    assert_eq!(bench.al(), (1, 0), "nothing of it was carried out");
    assert_eq!(bench.statistics.snapshot().malformed, 1);
    bench.write(0x030C, &[0]);
    assert_eq!(bench.read::<1>(0x030C), [0]);
}

#[test]
fn an_empty_segment_does_not_answer() {
    let mut bench = Bench::new(0);
    assert_eq!(bench.frame(&[(BRD, 0, &[0])]), None);
}
