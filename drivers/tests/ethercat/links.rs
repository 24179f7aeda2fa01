//! Both links, end to end: bring-up, a thousand exchanges a second, losses, and what they say when they cannot.

use crate::interfaces::{MAIN_DEVICE, SEGMENT, ip, refuse_frames, with_own_network};
use crate::support::{Mirror, expectation, impatient, in_us, patient, segment, served_over_udp};
use crate::timing::{PERIOD, measure};
use drivers::ethercat::{
    BringUpError, BringUpOptions, Bus, ExchangeError, Link, LinkError, RawLink, UdpLink,
};
use drivers::monotonic_ns;
use rustix::thread::{CapabilitySet, CapabilitySets};
use sim::ethercat::{FaultHandle, ServeOptions, serve_raw};
use std::net::UdpSocket;
use std::thread;
use std::time::Duration;

/// A bus over any link: what it does with losses, late answers and a SubDevice that leaves OP.
fn drive(open: impl Fn() -> Box<dyn Link>, faults: &FaultHandle) {
    let started_ns = monotonic_ns();
    let mut bus = Bus::bring_up(open(), &expectation(), patient()).unwrap();
    let bring_up_ms = (monotonic_ns() - started_ns) / 1_000_000;
    println!("{}: brought up in {bring_up_ms} ms", bus.identity().link);

    let mut inputs = [0; 172];
    println!("{}", measure(&mut bus, 1000, Duration::ZERO));
    println!("{}", measure(&mut bus, 1500, PERIOD));

    // A burst of losses: the cycles in it are lost, those after it are good. Shorter than the watchdog.
    faults.lose_next(50);
    for _ in 0..50 {
        assert_eq!(
            bus.exchange(&[1; 36], &mut inputs, in_us(300)),
            Err(ExchangeError::Lost)
        );
    }
    for cycle in 0..50 {
        bus.exchange(&[cycle; 36], &mut inputs, in_us(200_000))
            .unwrap();
    }
    assert_eq!(inputs[0], 48);

    // Answers after the deadline are dropped; the data is that of the right cycle. A busy machine holds up neither side so long.
    faults.delay_next(20, Duration::from_millis(150));
    for cycle in 0..20 {
        assert_eq!(
            bus.exchange(&[cycle; 36], &mut inputs, in_us(300)),
            Err(ExchangeError::Lost)
        );
    }
    thread::sleep(Duration::from_millis(300));
    bus.exchange(&[99; 36], &mut inputs, in_us(200_000))
        .unwrap();
    assert_eq!(inputs[0], 19);
    assert_eq!(bus.counters().foreign_frames, 20, "{:?}", bus.counters());

    // Out of OP, and back by bringing the bus up again on the same socket and on a new one.
    for reopen in [false, true] {
        faults.drop_to_safeop(0);
        let error = bus
            .exchange(&[1; 36], &mut inputs, in_us(200_000))
            .unwrap_err();
        assert!(
            matches!(error, ExchangeError::NotOperational { .. }),
            "{error}"
        );
        let link = bus.release();
        let link = if reopen { open() } else { link };
        bus = Bus::bring_up(link, &expectation(), patient()).unwrap();
        bus.exchange(&[1; 36], &mut inputs, in_us(200_000)).unwrap();
    }
    bus.shut_down(in_us(200_000)).unwrap();
}

#[test]
fn over_udp() {
    let (server, address, faults) = served_over_udp(ServeOptions::default());
    drive(|| Box::new(UdpLink::open(address).unwrap()), &faults);
    assert!(server.stop());
}

#[test]
fn over_a_network_interface() {
    with_own_network(|| {
        let segment = segment([Mirror::default()]);
        let faults = segment.faults();
        let server = serve_raw(SEGMENT, segment, ServeOptions::default()).unwrap();
        drive(|| Box::new(RawLink::open(MAIN_DEVICE).unwrap()), &faults);
        assert!(server.stop());
    });
}

#[test]
fn an_interface_that_goes_down_and_comes_back() {
    with_own_network(|| {
        let server = serve_raw(
            SEGMENT,
            segment([Mirror::default()]),
            ServeOptions::default(),
        )
        .unwrap();
        let link = Box::new(RawLink::open(MAIN_DEVICE).unwrap());
        let mut bus = Bus::bring_up(link, &expectation(), patient()).unwrap();
        bus.exchange(&[1; 36], &mut [0; 172], in_us(200_000))
            .unwrap();
        ip(&["link", "set", MAIN_DEVICE, "down"]).unwrap();
        for _ in 0..5 {
            let error = bus
                .exchange(&[1; 36], &mut [0; 172], in_us(500))
                .unwrap_err();
            assert!(matches!(error, ExchangeError::Io { .. }), "{error}");
        }
        let error = RawLink::open(MAIN_DEVICE).err().unwrap();
        assert!(matches!(error, LinkError::InterfaceDown { .. }), "{error}");
        ip(&["link", "set", MAIN_DEVICE, "up"]).unwrap();
        let link = bus.release();
        // Frames may be lost while it comes up.
        let options = BringUpOptions {
            frame_timeout: Duration::from_millis(20),
            frame_attempts: 500,
            ..patient()
        };
        Bus::bring_up(link, &expectation(), options).unwrap();
        assert!(server.stop());
    });
}

#[test]
fn frames_that_the_interface_refuses_are_lost_and_no_more() {
    with_own_network(|| {
        let segment = segment([Mirror::default()]);
        let server = serve_raw(SEGMENT, segment, ServeOptions::default()).unwrap();
        let link = Box::new(RawLink::open(MAIN_DEVICE).unwrap());
        let mut bus = Bus::bring_up(link, &expectation(), patient()).unwrap();
        if let Err(reason) = refuse_frames(true) {
            eprintln!("SKIPPED: needs `tc` with pfifo: {reason}");
            return;
        }
        for _ in 0..20 {
            let exchanged = bus.exchange(&[1; 36], &mut [0; 172], in_us(300));
            assert_eq!(exchanged, Err(ExchangeError::Lost));
        }
        refuse_frames(false).unwrap();
        let exchanged = bus.exchange(&[1; 36], &mut [0; 172], in_us(200_000));
        assert!(exchanged.is_ok(), "{exchanged:?}");
        assert!(server.stop());
    });
}

#[test]
fn an_interface_without_a_segment_is_silent() {
    with_own_network(|| {
        let link = Box::new(RawLink::open(MAIN_DEVICE).unwrap());
        let error = Bus::bring_up(link, &expectation(), impatient())
            .err()
            .unwrap();
        assert!(
            matches!(
                error,
                BringUpError::NoAnswer {
                    echoed_frames: 0,
                    ..
                }
            ),
            "{error}"
        );
        // Everything that is sent on a loopback interface comes back as it was.
        ip(&["link", "set", "lo", "up"]).unwrap();
        let link = Box::new(RawLink::open("lo").unwrap());
        let error = Bus::bring_up(link, &expectation(), impatient())
            .err()
            .unwrap();
        assert!(
            error.to_string().contains("frames come back as they left"),
            "{error}"
        );
    });
}

#[test]
fn an_interface_that_is_down_is_refused() {
    with_own_network(|| {
        let error = RawLink::open("lo").err().unwrap();
        assert!(matches!(error, LinkError::InterfaceDown { .. }), "{error}");
        assert!(error.to_string().contains("ip link set lo up"), "{error}");
    });
}

#[test]
fn a_process_without_the_right_is_told_what_to_grant() {
    // Of this thread only.
    let refused = thread::spawn(|| {
        let none = CapabilitySet::empty();
        let sets = CapabilitySets {
            effective: none,
            permitted: none,
            inheritable: none,
        };
        rustix::thread::set_capabilities(None, sets).unwrap();
        RawLink::open("lo").err().unwrap()
    });
    let error = refused.join().unwrap();
    assert!(matches!(error, LinkError::NotPermitted { .. }), "{error}");
    let text = error.to_string();
    assert!(
        text.contains("CAP_NET_RAW") && text.contains("setcap cap_net_raw+ep"),
        "{text}"
    );
}

#[test]
fn a_udp_port_where_nobody_listens_is_named() {
    let free = UdpSocket::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap();
    let error = Bus::bring_up(
        Box::new(UdpLink::open(free).unwrap()),
        &expectation(),
        impatient(),
    )
    .err()
    .unwrap();
    assert!(matches!(error, BringUpError::Link { .. }), "{error}");
    let text = error.to_string();
    assert!(
        text.contains(&free.to_string()) && text.contains("nobody listens on that port"),
        "{text}"
    );
}

#[test]
fn a_udp_port_that_never_answers_is_silent() {
    let mute = UdpSocket::bind("127.0.0.1:0").unwrap();
    let link = UdpLink::open(mute.local_addr().unwrap()).unwrap();
    let error = Bus::bring_up(Box::new(link), &expectation(), impatient())
        .err()
        .unwrap();
    assert!(
        matches!(error, BringUpError::NoAnswer { attempts: 4, .. }),
        "{error}"
    );
}

#[test]
fn two_buses_in_one_process_do_not_disturb_each_other() {
    let drive = |value: u8| {
        move || {
            let (_server, address, _) = served_over_udp(ServeOptions::default());
            let link = UdpLink::open(address).unwrap();
            let mut bus = Bus::bring_up(Box::new(link), &expectation(), patient()).unwrap();
            let mut inputs = [0; 172];
            for _ in 0..500 {
                bus.exchange(&[value; 36], &mut inputs, in_us(500_000))
                    .unwrap();
            }
            assert_eq!(inputs[..36], [value; 36]);
            assert_eq!(bus.counters().foreign_frames, 0);
        }
    };
    let threads: Vec<_> = (1..=3).map(|value| thread::spawn(drive(value))).collect();
    for thread in threads {
        thread.join().unwrap();
    }
}
