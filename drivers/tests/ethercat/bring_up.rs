//! Bring-up: what is found, what is refused and with which words, and that it can be repeated.

use crate::counting;
use crate::support::{Mirror, SegmentLink, expectation, impatient};
use drivers::Clock;
use drivers::ethercat::{AlState, BringUpError, BringUpOptions, Bus, Phase, ProcessData};
use sim::ethercat::sii::{EntryType, Identity};
use std::sync::Arc;
use std::time::Duration;

fn refused(link: &SegmentLink) -> BringUpError {
    let started_ns = link.now_ns();
    let error = Bus::bring_up(link.boxed(), &expectation(), impatient())
        .err()
        .expect("must be refused");
    assert!(
        link.now_ns() - started_ns < 1_500_000_000,
        "bounded in time"
    );
    error
}

#[test]
fn reaches_op_and_tells_what_it_found() {
    let link = SegmentLink::of([Mirror::default()]);
    let bus = Bus::bring_up(link.boxed(), &expectation(), BringUpOptions::default()).unwrap();
    let identity = bus.identity();
    assert_eq!(identity.link, "simulated segment");
    assert_eq!(
        (identity.address, identity.product_code),
        (0x1000, 0x0170_5011)
    );
    assert_eq!((identity.revision, identity.serial), (7, 42));
    assert!(!identity.name.is_empty());
    assert_eq!(link.statistics.snapshot().al_status, [8]);
    assert_eq!(bus.counters(), Default::default());
}

#[test]
fn it_tells_whether_the_sub_device_has_had_power_since_the_last_bring_up() {
    let link = SegmentLink::of([Mirror::default()]);
    let had_address = || {
        let bus = Bus::bring_up(link.boxed(), &expectation(), BringUpOptions::default());
        bus.expect("it comes up").identity().had_address
    };
    assert!(!had_address());
    assert!(had_address() && had_address());
    link.faults.power_off(0);
    assert!(Bus::bring_up(link.boxed(), &expectation(), impatient()).is_err());
    link.faults.power_on(0);
    assert!(!had_address() && had_address());
}

#[test]
fn another_vendor_or_product_is_refused_by_name() {
    let other = |identity| {
        SegmentLink::of([Mirror {
            identity,
            ..Mirror::default()
        }])
    };
    let Identity {
        vendor_id,
        product_code,
        revision,
        serial,
    } = Mirror::default().identity;
    let error = refused(&other(Identity {
        vendor_id: 0xBEEF,
        product_code,
        revision,
        serial,
    }));
    assert!(
        matches!(
            error,
            BringUpError::Vendor {
                address: 0x1000,
                found: 0xBEEF,
                ..
            }
        ),
        "{error}"
    );
    let error = refused(&other(Identity {
        vendor_id,
        product_code: 0x1234,
        revision,
        serial,
    }));
    assert!(
        matches!(
            error,
            BringUpError::Product {
                address: 0x1000,
                found: 0x1234,
                ..
            }
        ),
        "{error}"
    );
    let text = error.to_string();
    assert!(
        text.contains("0x00001234") && text.contains("0x01705011 or 0x17010091 or 0x02001001"),
        "{text}"
    );
}

#[test]
fn another_process_data_layout_is_refused() {
    let mut fewer_outputs = Mirror::default();
    fewer_outputs.outputs.pop();
    let error = refused(&SegmentLink::of([fewer_outputs]));
    let BringUpError::ProcessDataSize {
        direction: ProcessData::Outputs,
        expected: 36,
        found: 28,
        ..
    } = error
    else {
        panic!("{error}");
    };
    let mut more_inputs = Mirror::default();
    more_inputs.inputs.push(EntryType::U16);
    let error = refused(&SegmentLink::of([more_inputs]));
    assert_eq!(
        error.to_string(),
        "SubDevice 0x1000: 174 bytes of inputs, expected 172"
    );
    // More than there is room for.
    let far_too_many = Mirror {
        inputs: vec![EntryType::U64; 150],
        ..Mirror::default()
    };
    let error = refused(&SegmentLink::of([far_too_many]));
    assert!(
        matches!(
            error,
            BringUpError::Protocol {
                phase: Phase::Mapping,
                ..
            }
        ),
        "{error}"
    );
}

/// Feeds the watchdog and says nothing more until it trips; returns how long that took.
fn until_watchdog_trips(link: &SegmentLink, bus: &mut Bus) -> Duration {
    let trips = || link.statistics.snapshot().watchdog_trips;
    let (tripped, fed_ns) = (trips(), link.now_ns());
    bus.exchange(&[0; 36], &mut [0; 172], link.in_us(5_000))
        .unwrap();
    let silent = || Duration::from_nanos(link.now_ns() - fed_ns);
    while trips() == tripped {
        assert!(silent().as_secs() < 10, "the watchdog never tripped");
        link.pass(Duration::from_millis(1));
    }
    silent()
}

/// A SubDevice whose EEPROM has the watchdog of its outputs off.
fn unwatched() -> SegmentLink {
    SegmentLink::of([Mirror {
        outputs_control: 0x24,
        ..Mirror::default()
    }])
}

#[test]
fn a_watchdog_that_is_off_is_armed() {
    let link = unwatched();
    let mut bus = Bus::bring_up(link.boxed(), &expectation(), impatient()).unwrap();
    until_watchdog_trips(&link, &mut bus);
}

#[test]
fn a_watchdog_that_cannot_be_armed_is_refused() {
    let link = unwatched();
    link.faults.have_no_watchdog(0);
    let error = refused(&link);
    let BringUpError::WatchdogDisarmed {
        address: 0x1000,
        sync_manager: 0,
        control: 0x24,
    } = error
    else {
        panic!("{error}");
    };
    assert_ne!(
        link.statistics.snapshot().al_status,
        [8],
        "never reached OP"
    );
}

#[test]
fn the_watchdog_gets_the_configured_time() {
    let link = SegmentLink::of([Mirror::default()]);
    let expected = drivers::ethercat::Expectation {
        watchdog_ms: 200,
        ..expectation()
    };
    let mut bus = Bus::bring_up(link.boxed(), &expected, BringUpOptions::default()).unwrap();
    let silent = until_watchdog_trips(&link, &mut bus);
    assert!(silent >= Duration::from_millis(199), "{silent:?}");
    for watchdog_ms in [0, 7000] {
        let expected = drivers::ethercat::Expectation {
            watchdog_ms,
            ..expectation()
        };
        let error = Bus::bring_up(link.boxed(), &expected, impatient())
            .err()
            .unwrap();
        assert!(
            matches!(error, BringUpError::WatchdogRange { .. }),
            "{error}"
        );
    }
}

#[test]
fn a_watchdog_that_somebody_else_has_set_is_set_right_at_the_next_bring_up() {
    let expected = drivers::ethercat::Expectation {
        watchdog_ms: 200,
        ..expectation()
    };
    // Off; almost three minutes; ticks of 80 ns, which trip it at once.
    for writes in [
        &[(0x0420, 0)][..],
        &[(0x0400, u16::MAX), (0x0420, u16::MAX)],
        &[(0x0400, 0)],
    ] {
        let link = SegmentLink::of([Mirror::default()]);
        let bus = Bus::bring_up(link.boxed(), &expected, BringUpOptions::default()).unwrap();
        for &(register, value) in writes {
            link.write_register(register, value);
        }
        drop(bus);
        let mut bus = Bus::bring_up(link.boxed(), &expected, BringUpOptions::default()).unwrap();
        let silent = until_watchdog_trips(&link, &mut bus);
        assert!(silent >= Duration::from_millis(199), "{silent:?}");
    }
}

#[test]
fn exactly_one_sub_device_is_expected() {
    for count in [2, 3, 20] {
        let error = refused(&SegmentLink::of(std::iter::repeat_n(
            Mirror::default(),
            count,
        )));
        assert_eq!(
            error.to_string(),
            format!("simulated segment: found {count} SubDevices, expected 1")
        );
    }
}

#[test]
fn an_empty_segment_is_reported_as_silence() {
    let link = SegmentLink::of([Mirror::default()]);
    link.faults.disappear(0);
    link.cycle();
    let error = refused(&link);
    assert!(
        matches!(
            error,
            BringUpError::NoAnswer {
                phase: Phase::Counting,
                attempts: 4,
                ..
            }
        ),
        "{error}"
    );
    assert!(
        error.to_string().contains("no answer to 4 frames in 20 ms"),
        "{error}"
    );
    link.faults.reappear(0);
    link.cycle();
    Bus::bring_up(link.boxed(), &expectation(), BringUpOptions::default()).unwrap();
}

#[test]
fn a_state_that_is_refused_is_reported_with_its_reason() {
    let link = SegmentLink::of([Mirror {
        inputs_length: Some(100),
        ..Mirror::default()
    }]);
    let error = refused(&link);
    let BringUpError::Refused {
        address: 0x1000,
        wanted: AlState::SafeOp,
        status,
    } = error
    else {
        panic!("{error}");
    };
    assert_eq!(
        (status.state, status.error, status.code),
        (AlState::PreOp, true, Some(0x001E))
    );
}

#[test]
fn bring_up_survives_lost_late_and_damaged_frames() {
    let link = SegmentLink::of([Mirror::default()]);
    let options = BringUpOptions {
        frame_timeout: Duration::from_millis(2),
        ..BringUpOptions::default()
    };
    let faults = link.faults.clone();
    let disturbed = Disturbed {
        inner: link.clone(),
        sent: 0,
        faults,
    };
    Bus::bring_up(Box::new(disturbed), &expectation(), options).unwrap();
    assert!(link.statistics.snapshot().lost > 10);
}

/// Every few frames something happens.
struct Disturbed {
    inner: SegmentLink,
    sent: u32,
    faults: sim::ethercat::FaultHandle,
}

impl drivers::ethercat::Link for Disturbed {
    fn send(&mut self, frame: &[u8]) -> std::io::Result<()> {
        self.sent += 1;
        match self.sent % 35 {
            7 => self.faults.lose_next(1),
            14 => self.faults.lose_next_replies(1),
            21 => self.faults.duplicate_next(2),
            28 => self.faults.delay_next(1, Duration::from_millis(5)),
            0 => self.faults.corrupt_next(1),
            _ => {}
        }
        self.inner.send(frame)
    }

    fn receive(&mut self, buffer: &mut [u8], deadline_ns: u64) -> std::io::Result<Option<usize>> {
        self.inner.receive(buffer, deadline_ns)
    }

    fn clock(&self) -> Arc<dyn Clock> {
        self.inner.clock()
    }

    fn describe(&self) -> String {
        self.inner.describe()
    }
}

#[test]
fn from_every_state_and_again_and_again() {
    let link = SegmentLink::of([Mirror::default()]);
    let mut carried = link.boxed();
    for turn in 0..40 {
        match turn % 4 {
            1 => link.faults.drop_to_safeop(0),
            2 => link.faults.drop_to_init(0),
            3 => {
                link.faults.power_off(0);
                link.cycle();
                link.faults.power_on(0);
            }
            _ => {}
        }
        link.cycle();
        let mut bus = Bus::bring_up(carried, &expectation(), BringUpOptions::default()).unwrap();
        for _ in 0..10 {
            bus.exchange(&[1; 36], &mut [0; 172], link.in_us(20_000))
                .unwrap();
        }
        carried = bus.release();
    }
}

#[test]
fn memory_does_not_grow_with_bring_ups() {
    let link = SegmentLink::of([Mirror::default()]);
    let bring_up = |turns| {
        for _ in 0..turns {
            Bus::bring_up(link.boxed(), &expectation(), BringUpOptions::default()).unwrap();
            refused(&SegmentLink::of([]));
        }
    };
    bring_up(2);
    let before = counting::live_bytes();
    bring_up(50);
    let grown = counting::live_bytes() - before;
    // A hundred leaks of frame storage would be 1.2 MB. A few may be allocated because other tests hold what this
    // one has given back.
    assert!(grown < 200_000, "{grown} bytes");
}
