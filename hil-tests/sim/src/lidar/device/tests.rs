//! Conversations, byte by byte.

use proptest::prelude::*;

use super::firmware::MAX_LINE;
use super::*;
use crate::lidar::checksum;
use crate::world::RANGE_STEPS;

const MS: u64 = 1_000_000;
const SECOND_NS: u64 = 1_000 * MS;

fn scip20() -> Device {
    let options = DeviceOptions {
        protocol: Protocol::Scip20,
        ..DeviceOptions::default()
    };
    Device::new(options, 0)
}

fn say_at(device: &mut Device, text: &str, now_ns: u64) -> String {
    let mut out = Vec::new();
    device.receive(text.as_bytes(), now_ns, &mut out);
    text_of(&out)
}

fn say(device: &mut Device, text: &str) -> String {
    say_at(device, text, 0)
}

fn text_of(out: &[Emission]) -> String {
    let bytes: Vec<u8> = out.iter().flat_map(|e| e.bytes.clone()).collect();
    String::from_utf8(bytes).unwrap()
}

fn readings() -> [u16; RANGE_STEPS] {
    let mut readings = [0; RANGE_STEPS];
    readings[44] = 1234;
    readings[45] = 5432;
    readings
}

fn turn(device: &mut Device, start_ns: u64) -> String {
    let mut out = Vec::new();
    device.turn_measured(start_ns, &readings(), false, &mut out);
    text_of(&out)
}

#[test]
fn the_reports() {
    let mut device = scip20();
    assert_eq!(
        say(&mut device, "PP\n"),
        "PP\n00P\nMODL:URG-04LX(Hokuyo Automatic Co.,Ltd.);N\nDMIN:20;4\nDMAX:5600;_\n\
         ARES:1024;\\\nAMIN:44;7\nAMAX:725;o\nAFRT:384;6\nSCAN:600;e\n\n"
    );
    let version = say(&mut device, "VV\n");
    let keys: Vec<_> = version
        .lines()
        .skip(2)
        .map(|l| l.split(':').next().unwrap())
        .collect();
    assert_eq!(keys, ["VEND", "PROD", "FIRM", "PROT", "SERI", ""]);
    let state = say_at(&mut device, "II\n", 0x1234 * MS);
    assert!(state.starts_with("II\n00P\nMODL:"), "{state}");
    for line in [
        "LASR:OFF;7",
        "SCSP:Initial(600[rpm])<-Default setting by user;A",
        "MESM:IDLE;:",
        "SBPS:19200[bps]<-Default setting by user;A",
        "TIME:001234;",
        "STAT:Sensor works well.;8",
    ] {
        assert!(state.contains(&format!("\n{line}")), "{line} in {state}");
    }
}

#[test]
fn scip11_until_told_otherwise() {
    let mut device = Device::new(DeviceOptions::default(), 0);
    assert!(device.is_measuring());
    assert_eq!(say(&mut device, "QT\n"), "QT\nE\n\n");
    assert_eq!(say(&mut device, "VV\n"), "VV\nE\n\n");
    assert!(say(&mut device, "V\n").starts_with("V\n0\nVEND:Hokuyo"));
    assert_eq!(say(&mut device, "G04404501\n"), "");
    assert_eq!(turn(&mut device, 0), "G04404501\n0\nCBoo\n\n");
    assert_eq!(say(&mut device, "L0\n"), "L0\n0\n\n");
    assert_eq!(say(&mut device, "G04404501\n"), "G04404501\n6\n\n");
    assert_eq!(say(&mut device, "SCIP2.0\n"), "SCIP2.0\n0\n\n");
    assert!(!device.is_measuring());
    assert_eq!(say(&mut device, "SCIP2.0\n"), "SCIP2.0\n0Ee\n\n");
    assert_eq!(say(&mut device, "QT\n"), "QT\n00P\n\n");
}

#[test]
fn terminators_may_be_cr_lf_or_both() {
    let mut device = scip20();
    assert_eq!(say(&mut device, "BM\r"), "BM\n00P\n\n");
    assert_eq!(say(&mut device, "BM\r\n"), "BM\n02R\n\n");
    assert_eq!(say(&mut device, "\n\r\nQ"), "");
    assert_eq!(
        say(&mut device, "T;hello\nBM\n"),
        "QT;hello\n00P\n\nBM\n00P\n\n"
    );
}

#[test]
fn one_scan_on_request() {
    let mut device = scip20();
    assert_eq!(say(&mut device, "GD0044004501\n"), "GD0044004501\n10Q\n\n");
    say(&mut device, "BM\n");
    assert_eq!(say(&mut device, "GD0044004501\n"), "");
    assert_eq!(say(&mut device, "GS0044004501\n"), "GS0044004501\n0Bb\n\n");
    // 100 ms: 0000 0000 0001 100100 is "001T"; sum 0x30 + 0x30 + 0x31 + 0x54 = 0xE5: 0x25 + 0x30 = 'U'.
    // 1234 is "0CB", 5432 is "1Dh": 0x30+0x43+0x42+0x31+0x44+0x68 = 0x192: 0x12 + 0x30 = 'B'.
    assert_eq!(
        turn(&mut device, 100 * MS),
        "GD0044004501\n00P\n001TU\n0CB1DhB\n\n"
    );
    assert_eq!(
        say(&mut device, "GS0044004501;tag\n"),
        "GS0044004501;tag\n00P\n001TU\nCBooS\n\n"
    );
    say(&mut device, "QT\n");
    assert_eq!(say(&mut device, "GD0044004501\n"), "GD0044004501\n10Q\n\n");
}

fn sum(text: &str) -> String {
    char::from(checksum(text.as_bytes())).to_string()
}

#[test]
fn a_stream_counts_down_and_turns_the_laser_off() {
    let mut device = scip20();
    assert_eq!(
        say(&mut device, "MD0044004501002;ab\n"),
        "MD0044004501002;ab\n00P\n\n"
    );
    assert!(device.is_measuring() && device.is_streaming());
    assert_eq!(
        turn(&mut device, 100 * MS),
        "MD0044004501001;ab\n99b\n001TU\n0CB1DhB\n\n"
    );
    assert!(turn(&mut device, 200 * MS).starts_with("MD0044004501000;ab\n99b\n"));
    assert!(!device.is_measuring());
    assert_eq!(turn(&mut device, 300 * MS), "");
}

#[test]
fn an_endless_stream_answers_in_between_until_quit() {
    let mut device = scip20();
    say(&mut device, "MS0044072501100\n");
    for start_ms in (0..2000).step_by(200) {
        let scan = turn(&mut device, start_ms * MS);
        assert!(scan.starts_with("MS0044072501100\n99b\n"), "{scan}");
        assert_eq!(
            turn(&mut device, (start_ms + 100) * MS),
            "",
            "every other scan is skipped"
        );
        assert!(say(&mut device, "II\n").contains("MESM:Measuring"));
    }
    assert_eq!(say(&mut device, "BM\n"), "BM\n02R\n\n");
    assert_eq!(say(&mut device, "QT\n"), "QT\n00P\n\n");
    assert_eq!(turn(&mut device, 2000 * MS), "");
}

#[test]
fn a_stream_begins_with_a_turn_that_began_after_it() {
    let mut device = scip20();
    say_at(&mut device, "MD0044072501000\n", 50 * MS);
    assert_eq!(turn(&mut device, 0), "");
    assert_ne!(turn(&mut device, 100 * MS), "");
}

#[test]
fn a_full_scan_has_the_length_the_format_says() {
    let mut device = scip20();
    say(&mut device, "MD0044072501000\n");
    let scan = turn(&mut device, 0);
    // Echo 16, status 4, time stamp 6, 2046 data bytes in 32 lines with sum and end, one empty line.
    assert_eq!(scan.len(), 16 + 4 + 6 + 2046 + 32 * 2 + 1);
    for line in scan.lines().skip(1).filter(|line| !line.is_empty()) {
        let (data, last) = line.split_at(line.len() - 1);
        assert_eq!(last, sum(data), "{line}");
    }
    say(&mut device, "MS0044072502000\n");
    assert_eq!(turn(&mut device, 0).len(), 16 + 4 + 6 + 682 + 11 * 2 + 1);
}

#[test]
fn a_busy_line_drops_whole_scans_and_counts_them() {
    let mut device = scip20();
    say(&mut device, "MD0044072501005\n");
    let mut out = Vec::new();
    device.turn_measured(0, &readings(), true, &mut out);
    assert_eq!((out.len(), device.dropped_scans()), (0, 1));
    assert!(turn(&mut device, 100 * MS).starts_with("MD0044072501004\n"));
}

#[test]
fn tells_what_it_is_doing() {
    let mut device = scip20();
    for (before, activity) in [
        ("QT", "000"),
        ("BM", "003"),
        ("MD0044072501000", "004"),
        ("TM0", "002"),
    ] {
        say(&mut device, &format!("{before}\n"));
        assert_eq!(
            say(&mut device, "%ST\n"),
            format!("%ST\n00P\n{activity}{}\n\n", sum(activity))
        );
    }
}

#[test]
fn clock_adjustment_shuts_out_everything_else() {
    let mut device = scip20();
    assert_eq!(
        say(&mut device, "TM1\n"),
        format!("TM1\n04{}\n\n", sum("04"))
    );
    assert_eq!(
        say(&mut device, "TM2\n"),
        format!("TM2\n03{}\n\n", sum("03"))
    );
    say(&mut device, "MD0044072501000\n");
    assert_eq!(say(&mut device, "TM0\n"), "TM0\n00P\n\n");
    assert!(!device.is_measuring());
    for line in ["QT", "VV", "nonsense"] {
        assert_eq!(
            say(&mut device, &format!("{line}\n")),
            format!("{line}\n0Ee\n\n")
        );
    }
    assert_eq!(say(&mut device, "TM0\n"), "TM0\n02R\n\n");
    assert_eq!(
        say(&mut device, "TM9\n"),
        format!("TM9\n01{}\n\n", sum("01"))
    );
    assert_eq!(
        say_at(&mut device, "TM1\n", 16_000_000 * MS),
        "TM1\n00P\nm2@0?\n\n"
    );
    assert_eq!(say(&mut device, "TM2\n"), "TM2\n00P\n\n");
    assert_eq!(say(&mut device, "QT\n"), "QT\n00P\n\n");
}

#[test]
fn the_timer_wraps_drifts_and_is_reset() {
    let options = DeviceOptions {
        timer_ms: (1 << 24) - 10,
        timer_drift_ppm: 100.0,
        protocol: Protocol::Scip20,
        ..DeviceOptions::default()
    };
    let mut device = Device::new(options, SECOND_NS);
    assert_eq!(device.timer_ms(SECOND_NS), (1 << 24) - 10);
    assert_eq!(device.timer_ms(SECOND_NS + 10 * MS), 0);
    assert_eq!(device.timer_ms(101 * SECOND_NS), 100_010 - 10);
    say_at(&mut device, "RS\n", 200 * SECOND_NS);
    assert_eq!(device.timer_ms(200 * SECOND_NS), 0);
}

#[test]
fn the_bit_rate_changes_behind_the_reply() {
    let mut device = scip20();
    let mut out = Vec::new();
    device.receive(b"SS115200\n", 0, &mut out);
    assert_eq!(out[0].bytes, b"SS115200\n00P\n\n");
    assert_eq!(out[0].bit_rate_after, Some(115_200));
    for (line, status) in [
        ("SS115200", "03"),
        ("SS123456", "02"),
        ("SS038400", "04"),
        ("SSabcdef", "01"),
    ] {
        let expected = format!("{line}\n{status}{}\n\n", sum(status));
        assert_eq!(say(&mut device, &format!("{line}\n")), expected);
    }
    out.clear();
    device.receive(b"RS\n", 0, &mut out);
    assert_eq!(out[0].bit_rate_after, Some(19_200));
}

#[test]
fn the_motor_changes_speed() {
    let mut device = scip20();
    assert_eq!(device.turn_ns(), 100 * MS);
    for (line, status) in [
        ("CR05", "00"),
        ("CR05", "03"),
        ("CR11", "02"),
        ("CRxx", "01"),
    ] {
        let expected = format!("{line}\n{status}{}\n\n", sum(status));
        assert_eq!(say(&mut device, &format!("{line}\n")), expected);
    }
    assert_eq!(device.turn_ns(), 60 * SECOND_NS / 570);
    assert!(say(&mut device, "II\n").contains("SCSP:05(570[rpm])<-"));
    say(&mut device, "CR99\n");
    assert_eq!(device.turn_ns(), 100 * MS);
}

#[test]
fn it_may_power_up_streaming() {
    let options = DeviceOptions {
        streaming: true,
        bit_rate: 750_000,
        ..DeviceOptions::default()
    };
    let mut device = Device::new(options, 0);
    assert_eq!(
        (device.protocol(), device.bit_rate()),
        (Protocol::Scip20, 750_000)
    );
    assert!(turn(&mut device, 0).starts_with("MD0044072501000\n99b\n"));
}

#[test]
fn a_line_without_end_is_refused_and_forgotten() {
    let mut device = scip20();
    let long = "x".repeat(100_000);
    assert_eq!(say(&mut device, &long), "");
    assert!(device.line.len() <= MAX_LINE);
    let reply = say(&mut device, "\n");
    assert!(
        reply.ends_with(&format!("\n0G{}\n\n", sum("0G"))),
        "{reply}"
    );
    assert_eq!(say(&mut device, "QT\n"), "QT\n00P\n\n");
}

#[test]
fn half_a_command_is_lost_in_a_broken_character() {
    let mut device = scip20();
    say(&mut device, "MD00");
    device.framing_error();
    assert_eq!(say(&mut device, "QT\n"), "QT\n00P\n\n");
}

proptest! {
    #[test]
    fn any_bytes_are_answered_without_a_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..300),
        scip11 in any::<bool>(),
    ) {
        let protocol = if scip11 { Protocol::Scip11 } else { Protocol::Scip20 };
        let mut device = Device::new(DeviceOptions { protocol, ..DeviceOptions::default() }, 0);
        let mut out = Vec::new();
        device.receive(&bytes, 1, &mut out);
        device.turn_measured(2, &readings(), false, &mut out);
        prop_assert!(out.iter().map(|e| e.bytes.len()).sum::<usize>() < 300 * 300);
    }

    #[test]
    fn anything_like_a_command_is_answered_without_a_panic(
        lines in prop::collection::vec("(VV|PP|II|BM|QT|RS|TM|SS|CR|GD|GS|MD|MS|G|S|SCIP2.0)[0-9;]{0,20}[\n\r]", 0..20),
        scip11 in any::<bool>(),
    ) {
        let protocol = if scip11 { Protocol::Scip11 } else { Protocol::Scip20 };
        let mut device = Device::new(DeviceOptions { protocol, ..DeviceOptions::default() }, 0);
        for (i, line) in lines.iter().enumerate() {
            let mut out = Vec::new();
            device.receive(line.as_bytes(), i as u64 * 50 * MS, &mut out);
            device.turn_measured(i as u64 * 50 * MS, &readings(), i % 3 == 0, &mut out);
            for emission in &out {
                prop_assert!(emission.bytes.ends_with(b"\n\n"));
            }
        }
    }
}
