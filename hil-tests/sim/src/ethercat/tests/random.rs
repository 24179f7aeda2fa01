//! Whatever arrives, nothing panics.

use proptest::collection::vec;
use proptest::prelude::*;

use super::*;

/// A datagram whose addresses lie where something happens.
fn datagram() -> impl Strategy<Value = (u8, u32, Vec<u8>)> {
    let offset = prop_oneof![
        Just(0x0000u16),
        Just(0x0010),
        Just(0x0100),
        Just(0x0120),
        Just(0x0300),
        Just(0x0400),
        Just(0x0420),
        Just(0x0500),
        Just(0x0502),
        Just(0x0508),
        0x0600u16..0x0680,
        0x0800u16..0x0840,
        0x0900u16..0x0940,
        0x0F70u16..0x1300,
        0x2FF0u16..0x3010,
        any::<u16>(),
    ];
    let device = prop_oneof![Just(0u16), Just(0xFFFF), any::<u16>()];
    let logical = prop_oneof![0xFFF0u32..0x1_0200, any::<u32>()];
    let place = prop_oneof![
        (device, offset).prop_map(|(device, offset)| address(device, offset)),
        logical
    ];
    (0u8..17, place, vec(any::<u8>(), 0..260))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn arbitrary_bytes(frames in vec(vec(any::<u8>(), 0..200), 1..8), ethernet in any::<bool>()) {
        let mut bench = Bench::new(2);
        for mut bytes in frames {
            if ethernet {
                bench.segment.process_frame(&mut bytes, bench.now_ns);
            } else {
                bench.segment.process_payload(&mut bytes, bench.now_ns);
            }
            bench.wait_ms(1);
        }
    }

    #[test]
    fn arbitrary_datagrams(frames in vec(vec(datagram(), 1..6), 1..12), in_op in any::<bool>(), step_ms in 0u64..60) {
        let mut bench = Bench::new(2);
        if in_op {
            bench.reach_op(0x64);
        }
        for datagrams in frames {
            let datagrams: Vec<_> = datagrams.iter().map(|(c, a, data)| (*c, *a, &data[..])).collect();
            let answers = bench.frame(&datagrams);
            prop_assert_eq!(answers.map(|answers| answers.len()), Some(datagrams.len()));
            bench.now_ns += step_ms * MS;
        }
        bench.wait_ms(200);
    }

    /// None of it may last: who sets the registers has a watchdog, and so has who takes the power away for a moment.
    #[test]
    fn arbitrary_writes_leave_a_watchdog_that_does_what_its_registers_say(
        writes in vec((0x03F8u16..0x0424, vec(prop_oneof![Just(0u8), 0u8..4, any::<u8>()], 1..42)), 0..12),
    ) {
        const LONGEST_MS: u64 = 2_000;
        const TRIPPED: (u16, u16) = (0x14, 0x1B);
        let mut bench = Bench::new(1);
        bench.reach_op(0x64);
        for (offset, data) in writes {
            bench.send(cmd::APWR, address(0, offset), &data);
            bench.drive_for_ms(3, 1.0);
        }
        let tick_ns = (u64::from(bench.read_u16(0x0400)) + 2) * 40;
        let timeout_ms = tick_ns * u64::from(bench.read_u16(0x0420)) / MS;
        let is_off = bench.read_u16(0x0420) == 0;
        // It may have tripped between two exchanges, and does again if its time is that short.
        bench.request(0x14);
        bench.request(8);
        if is_off || timeout_ms > 3 {
            bench.drive_for_ms(3, 1.0);
            prop_assert_eq!(bench.al(), (8, 0));
            let silent_ms = if is_off { LONGEST_MS } else { LONGEST_MS.min(timeout_ms - 2) };
            bench.wait_ms(silent_ms);
            prop_assert_eq!(bench.al(), (8, 0));
        }
        if !is_off && timeout_ms <= LONGEST_MS {
            bench.wait_ms(5);
            prop_assert_eq!(bench.al(), TRIPPED);
        }
        bench.write(0x0400, &2498u16.to_le_bytes());
        bench.write(0x0420, &1000u16.to_le_bytes());
        bench.request(0x14);
        prop_assert_eq!(bench.request(8), (8, 0));
        bench.wait_ms(102);
        prop_assert_eq!(bench.al(), TRIPPED);
    }

    #[test]
    fn a_good_frame_with_changed_bytes(changes in vec((0usize..230, any::<u8>()), 1..4)) {
        let mut bench = Bench::new(1);
        bench.reach_op(0x64);
        let mut bytes = payload(&[(cmd::LRW, 0x1_0000, &[0; 208])]);
        for (at, value) in changes {
            if let Some(byte) = bytes.get_mut(at) {
                *byte = value;
            }
        }
        bench.segment.process_payload(&mut bytes, bench.now_ns);
        bench.wait_ms(150);
    }

    #[test]
    fn arbitrary_units_map_only_their_own_bits(registers in any::<[u8; 16]>(), start in any::<u32>(), length in 0usize..1500) {
        let mut near = registers;
        near[..4].copy_from_slice(&start.wrapping_add(u32::from(registers[0]) % 16).to_le_bytes());
        for registers in [registers, near] {
            if let Some(run) = crate::ethercat::fmmu::Fmmu::decode(&registers).map(start, length) {
                prop_assert!(run.bits > 0 && run.data_bit + run.bits <= length as u64 * 8);
            }
        }
    }
}

#[test]
fn frames_of_the_greatest_length_are_carried_out() {
    let mut bench = Bench::new(1);
    let answer = bench.send(cmd::BRW, address(0, 0x1000), &[0; 1486]);
    assert_eq!(answer.counter, 3);
    // Longer than Ethernet allows, as only UDP can carry: passed on untouched.
    assert_eq!(
        bench.send(cmd::BRW, address(0, 0x1000), &[0; 2000]).counter,
        0
    );
    assert_eq!(bench.send(cmd::LRW, 0, &[0; 2000]).counter, 0);
}
