//! Register file, SII interface, state machine and clock, as a MainDevice sees them.

use super::cmd::*;
use super::*;
use crate::ethercat::sii;

#[test]
fn information() {
    let mut bench = Bench::new(1);
    assert_eq!(bench.read::<10>(0), [0x11, 0, 2, 0, 8, 8, 8, 0x0F, 0x0C, 0]);
    assert_eq!(bench.read_u16(0x0400), 2498);
    assert_eq!(bench.read_u16(0x0420), 1000);
    assert_eq!(bench.read_u16(0x0440), 1);
}

#[test]
fn read_only_registers_do_not_count_writes() {
    let mut bench = Bench::new(1);
    for offset in [0x0000, 0x0110, 0x0130, 0x0134] {
        assert_eq!(
            bench.send(APWR, address(0, offset), &[0xFF]).counter,
            0,
            "{offset:#06x}"
        );
    }
    assert_eq!(bench.read::<1>(0), [0x11]);
    // A write that also covers writable bytes counts, and leaves the others.
    bench.write(0x000F, &[0xFF, 0x34, 0x12, 0xFF]);
    assert_eq!(bench.read::<4>(0x000F), [0, 0x34, 0x12, 0]);
}

#[test]
fn beyond_the_memory_nothing_answers() {
    let mut bench = Bench::new(1);
    assert_eq!(
        bench.send(APRD, address(0, 0x3000), &[7]),
        Answer {
            counter: 0,
            device: 1,
            data: vec![7]
        }
    );
    assert_eq!(bench.send(APWR, address(0, 0xFFFF), &[7; 4]).counter, 0);
    // Across the end: what exists answers.
    assert_eq!(bench.send(APRD, address(0, 0x2FFF), &[7; 2]).data, [0, 0]);
}

#[test]
fn dl_status_shows_the_topology() {
    let mut line = Bench::new(3);
    // Link and communication at port 0, loops closed elsewhere; inner SubDevices have port 1 open too.
    assert_eq!(line.read_u16(0x0110), 0x0001 | 0x0030 | 0x0A00 | 0x5000);
    let last = line.send(APRD, address(0xFFFE, 0x0110), &[0; 2]);
    assert_eq!(
        last.data,
        (0x0001u16 | 0x0010 | 0x0200 | 0x5400).to_le_bytes()
    );
}

#[test]
fn the_eeprom_is_read_through_its_registers() {
    let mut bench = Bench::new(1);
    bench.write(0x0502, &[0x00, 0x01, 8, 0, 0, 0]);
    assert_ne!(bench.read_u16(0x0502) & 0x8000, 0, "busy");
    bench.wait_ms(1);
    assert_eq!(bench.read_u16(0x0502), 0x0040, "ready, eight bytes");
    let mut identity = crate::kelo::VENDOR_ID.to_le_bytes().to_vec();
    identity.extend(crate::kelo::PRODUCT_CODE.to_le_bytes());
    assert_eq!(bench.read::<8>(0x0508).to_vec(), identity);
}

#[test]
fn the_eeprom_can_be_written_and_reloaded() {
    let mut bench = Bench::new(1);
    let mut head = [0; 14];
    head[0] = 0x05;
    head[8..10].copy_from_slice(&[0x34, 0x12]);
    for (word, data) in [(4u8, [0x34, 0x12]), (7, [sii::checksum(&head), 0])] {
        // Data first, then the command with its enable bit, as MainDevices do.
        bench.write(0x0508, &data);
        bench.write(0x0502, &[0x01, 0x02, word, 0, 0, 0]);
        bench.wait_ms(5);
        assert_eq!(bench.read_u16(0x0502) & 0xF800, 0);
    }
    assert_eq!(bench.read_u16(0x0012), 0);
    bench.write(0x0502, &[0x00, 0x04]);
    bench.wait_ms(5);
    assert_eq!(bench.read_u16(0x0012), 0x1234);
}

#[test]
fn the_processor_may_own_the_eeprom() {
    let mut bench = Bench::new(1);
    bench.write(0x0500, &[1]);
    assert_eq!(
        bench
            .send(APWR, address(0, 0x0502), &[0x00, 0x01, 8, 0, 0, 0])
            .counter,
        0
    );
    assert_eq!(bench.read_u16(0x0502) & 0x8000, 0, "no command was taken");
    bench.write(0x0500, &[0]);
    bench.write(0x0502, &[0x00, 0x01, 8, 0, 0, 0]);
    assert_ne!(bench.read_u16(0x0502) & 0x8000, 0);
}

#[test]
fn states_are_taken_one_by_one() {
    let mut bench = Bench::new(1);
    assert_eq!(bench.al(), (1, 0));
    assert_eq!(bench.request(8), (0x11, 0x0011));
    assert_eq!(bench.request(2), (0x11, 0x0011), "not acknowledged");
    assert_eq!(bench.request(0x12), (2, 0));
    assert_eq!(bench.request(4), (0x12, 0x001D), "no SyncManager is set up");
    bench.configure(0x64);
    assert_eq!(bench.request(0x14), (4, 0));
    assert_eq!(bench.request(8), (8, 0));
    assert_eq!(bench.request(2), (2, 0));
    assert_eq!(bench.request(1), (1, 0));
    assert_eq!(bench.request(3), (0x11, 0x0013));
}

#[test]
fn wrong_syncmanagers_are_refused_with_their_code() {
    for (offset, byte, code) in [
        (0x0812, 35, 0x1D),
        (0x0814, 0x60, 0x1D),
        (0x0816, 0, 0x1D),
        (0x081A, 1, 0x1E),
        (0x081E, 0, 0x1E),
    ] {
        let mut bench = Bench::new(1);
        bench.request(2);
        bench.configure(0x64);
        // It takes no settings while it is active.
        let active = offset / 8 * 8 + 6;
        if offset != active {
            bench.write(offset, &[byte]);
            bench.write(active, &[0]);
        }
        bench.write(offset, &[byte]);
        if offset != active {
            bench.write(active, &[1]);
        }
        assert_eq!(bench.request(4), (0x12, code), "{offset:#06x}");
    }
}

#[test]
fn an_active_syncmanager_takes_no_settings() {
    let mut bench = Bench::new(1);
    bench.request(2);
    bench.configure(0x64);
    bench.write(0x0812, &[35]);
    bench.write(0x0814, &[0x60]);
    assert_eq!(bench.request(4), (4, 0));
}

#[test]
fn an_al_event_is_raised_where_it_is_wanted() {
    let mut bench = Bench::new(1);
    bench.write(0x0200, &[0x08, 0x00]);
    bench.request(2);
    let mut bytes = payload(&[(APRD, address(0, 0), &[0])]);
    bench.write(0x0120, &[1, 0]);
    bench.segment.process_payload(&mut bytes, bench.now_ns);
    assert_eq!(bytes[10..12], [0x08, 0x00]);
    bench.al();
    let mut bytes = payload(&[(APRD, address(0, 0), &[0])]);
    bench.segment.process_payload(&mut bytes, bench.now_ns);
    assert_eq!(
        bytes[10..12],
        [0, 0],
        "reading the status takes the event back"
    );
}

#[test]
fn receive_times_are_latched_and_offsets_set_the_system_time() {
    let mut bench = Bench::new(2);
    let all = bench.send(BWR, address(0, 0x0900), &[0; 4]);
    assert_eq!(all.counter, 2);
    let now_ns = bench.now_ns;
    let times: [u8; 32] = bench.read(0x0900);
    let port = |i: usize| u32::from_le_bytes(times[4 * i..4 * i + 4].try_into().unwrap());
    assert_eq!(
        (port(0), port(1)),
        (now_ns as u32, now_ns as u32 + 1000),
        "there and back"
    );
    assert_eq!(u64::from_le_bytes(times[24..].try_into().unwrap()), now_ns);
    let offset = 5_000_000_000u64.wrapping_sub(now_ns);
    bench.write(0x0920, &offset.to_le_bytes());
    assert_eq!(u64::from_le_bytes(bench.read(0x0910)), 5_000_000_000);
    bench.wait_ms(2);
    assert_eq!(u64::from_le_bytes(bench.read(0x0910)), 5_002_000_000);
}

#[test]
fn a_second_clock_follows_the_first() {
    let mut bench = Bench::new(2);
    let offset = 40_000u64;
    bench.write(0x0920, &offset.to_le_bytes());
    for _ in 0..500 {
        bench.wait_ms(1);
        let answer = bench.send(ARMW, address(0, 0x0910), &[0; 8]);
        assert_eq!(answer.counter, 2);
    }
    let first = u64::from_le_bytes(bench.read(0x0910));
    let second = bench.send(APRD, address(0xFFFF, 0x0910), &[0; 8]).data;
    let second = u64::from_le_bytes(second.try_into().unwrap());
    assert!(first.abs_diff(second) < 1_000, "{first} {second}");
}
