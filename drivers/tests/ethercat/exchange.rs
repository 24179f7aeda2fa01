//! Exchange: data, deadlines, and every way to lose a cycle and go on.

use crate::support::{Mirror, SegmentLink, expectation};
use drivers::ethercat::{AlState, BringUpOptions, Bus, ExchangeError, Expectation, ProcessData};
use std::time::Duration;

fn operational() -> (SegmentLink, Bus) {
    let link = SegmentLink::of([Mirror::default()]);
    let bus = Bus::bring_up(link.boxed(), &expectation(), BringUpOptions::default()).unwrap();
    (link, bus)
}

/// Exchanges until the inputs mirror outputs filled with `value`: they are those of the frame before.
fn settle(link: &SegmentLink, bus: &mut Bus, value: u8) {
    let mut inputs = [0; 172];
    for _ in 0..3 {
        bus.exchange(&[value; 36], &mut inputs, link.in_us(20_000))
            .unwrap();
    }
    assert_eq!(inputs[..36], [value; 36]);
}

#[test]
fn outputs_arrive_and_inputs_come_back() {
    let (link, mut bus) = operational();
    for value in 1..100 {
        settle(&link, &mut bus, value);
    }
    assert_eq!(bus.counters().cycles, 3 * 99);
    let exchange = bus
        .exchange(&[0; 36], &mut [0; 172], link.in_us(20_000))
        .unwrap();
    assert!(exchange.sent_ns <= exchange.received_ns && exchange.received_ns <= link.now_ns());
}

#[test]
fn a_burst_of_lost_frames_is_only_lost_frames() {
    let (link, mut bus) = operational();
    let mut inputs = [0xAA; 172];
    // More than there are datagram indices, and far more than ethercrab has frames.
    for lost in [1, 7, 8, 9, 300] {
        link.faults.lose_next(lost);
        for _ in 0..lost {
            assert_eq!(
                bus.exchange(&[1; 36], &mut inputs, link.in_us(0)),
                Err(ExchangeError::Lost)
            );
        }
        bus.exchange(&[1; 36], &mut [0; 172], link.in_us(20_000))
            .unwrap();
    }
    assert_eq!(inputs, [0xAA; 172], "inputs change only on success");
    assert_eq!(bus.counters().lost_frames, 1 + 7 + 8 + 9 + 300);
    settle(&link, &mut bus, 9);
}

#[test]
fn late_answers_are_dropped_by_whoever_receives_them() {
    let (link, mut bus) = operational();
    settle(&link, &mut bus, 1);
    let mut inputs = [0; 172];
    for turn in 0..8u8 {
        link.faults.delay_next(1, Duration::from_millis(40));
        assert_eq!(
            bus.exchange(&[100 + turn; 36], &mut inputs, link.in_us(500)),
            Err(ExchangeError::Lost)
        );
        link.pass(Duration::from_millis(50));
        // The late answer mirrors the outputs before; the answer to this frame mirrors those of the late one.
        bus.exchange(&[0; 36], &mut inputs, link.in_us(20_000))
            .unwrap();
        assert_eq!(inputs[..36], [100 + turn; 36]);
    }
    assert_eq!(bus.counters().foreign_frames, 8);
}

#[test]
fn duplicates_and_damage_do_not_disturb_the_next_cycle() {
    let (link, mut bus) = operational();
    let mut inputs = [0; 172];
    link.faults.duplicate_next(50);
    for value in 0..50 {
        bus.exchange(&[value; 36], &mut inputs, link.in_us(20_000))
            .unwrap();
        assert_eq!(inputs[..36], [value.saturating_sub(1); 36]);
    }
    assert!(bus.counters().foreign_frames >= 49);
    link.faults.corrupt_next(8);
    for _ in 0..8 {
        let error = bus
            .exchange(&[1; 36], &mut inputs, link.in_us(300))
            .unwrap_err();
        // What is whole but for its working counter is called that; the rest cannot be an answer.
        assert!(
            matches!(
                error,
                ExchangeError::Lost | ExchangeError::WorkingCounter { .. }
            ),
            "{error}"
        );
    }
    settle(&link, &mut bus, 5);
}

#[test]
fn a_low_working_counter_is_an_error_and_passes() {
    let (link, mut bus) = operational();
    settle(&link, &mut bus, 1);
    let mut inputs = [0xAA; 172];
    link.faults
        .working_counter_low_for(Duration::from_millis(10));
    let error = bus
        .exchange(&[1; 36], &mut inputs, link.in_us(20_000))
        .unwrap_err();
    assert_eq!(
        error,
        ExchangeError::WorkingCounter {
            found: 0,
            expected: 3
        }
    );
    assert_eq!(inputs, [0xAA; 172]);
    link.pass(Duration::from_millis(12));
    settle(&link, &mut bus, 2);
    assert_eq!(bus.counters().wkc_errors, 1);
}

#[test]
fn leaving_op_is_noticed_in_the_same_cycle_with_its_reason() {
    let (link, mut bus) = operational();
    settle(&link, &mut bus, 1);
    link.faults.drop_to_safeop(0);
    link.cycle();
    match bus
        .exchange(&[1; 36], &mut [0; 172], link.in_us(20_000))
        .unwrap_err()
    {
        ExchangeError::NotOperational {
            address: 0x1000,
            status,
        } => {
            assert_eq!(
                (status.state, status.error, status.code),
                (AlState::SafeOp, true, Some(0x001A))
            );
        }
        other => panic!("{other}"),
    }
    assert_eq!(bus.counters().not_operational, 1);
    let carried = bus.release();
    let mut bus = Bus::bring_up(carried, &expectation(), BringUpOptions::default()).unwrap();
    settle(&link, &mut bus, 2);
}

#[test]
fn a_watchdog_trip_is_told_as_such() {
    let link = SegmentLink::of([Mirror::default()]);
    let expected = Expectation {
        watchdog_ms: 100,
        ..expectation()
    };
    let mut bus = Bus::bring_up(link.boxed(), &expected, BringUpOptions::default()).unwrap();
    link.pass(Duration::from_millis(150));
    let error = bus
        .exchange(&[1; 36], &mut [0; 172], link.in_us(20_000))
        .unwrap_err();
    assert!(
        error
            .to_string()
            .contains("SAFEOP with error, AL status code 0x001b"),
        "{error}"
    );
}

#[test]
fn a_restarted_sub_device_no_longer_answers_to_its_address() {
    let (link, mut bus) = operational();
    settle(&link, &mut bus, 1);
    link.faults.drop_to_init(0);
    link.cycle();
    let error = bus
        .exchange(&[1; 36], &mut [0; 172], link.in_us(20_000))
        .unwrap_err();
    assert_eq!(
        error,
        ExchangeError::WorkingCounter {
            found: 0,
            expected: 3
        }
    );
}

#[test]
fn a_pulled_cable_is_silence() {
    let (link, mut bus) = operational();
    link.faults.disappear(0);
    link.cycle();
    for _ in 0..20 {
        assert_eq!(
            bus.exchange(&[1; 36], &mut [0; 172], link.in_us(100)),
            Err(ExchangeError::Lost)
        );
    }
    link.faults.reappear(0);
    link.cycle();
    settle(&link, &mut bus, 3);
}

#[test]
fn deadlines_are_kept_whatever_arrives() {
    let (link, mut bus) = operational();
    // Answers come, but each too late: every exchange meets those before it.
    link.faults.delay_next(64, Duration::from_millis(30));
    for _ in 0..64 {
        let deadline_ns = link.in_us(1000);
        assert_eq!(
            bus.exchange(&[1; 36], &mut [0; 172], deadline_ns),
            Err(ExchangeError::Lost)
        );
        assert_eq!(link.now_ns(), deadline_ns);
    }
    assert!(bus.counters().foreign_frames > 20);
}

#[test]
fn buffers_of_the_wrong_size_are_refused_without_a_frame() {
    let (link, mut bus) = operational();
    let sent = link.frames_sent();
    let (direction, expected) = (ProcessData::Outputs, 36);
    let error = bus
        .exchange(&[0; 35], &mut [0; 172], link.in_us(1000))
        .unwrap_err();
    assert_eq!(
        error,
        ExchangeError::ImageSize {
            direction,
            expected,
            found: 35
        }
    );
    assert!(
        bus.exchange(&[0; 36], &mut [0; 173], link.in_us(1000))
            .is_err()
    );
    assert_eq!(link.frames_sent(), sent);
}

#[test]
fn shutting_down_takes_the_sub_device_to_init() {
    let (link, mut bus) = operational();
    settle(&link, &mut bus, 1);
    bus.shut_down(link.in_us(20_000)).unwrap();
    link.cycle();
    assert_eq!(link.statistics.snapshot().al_status, [1]);
    assert!(
        bus.exchange(&[1; 36], &mut [0; 172], link.in_us(20_000))
            .is_err()
    );
}
