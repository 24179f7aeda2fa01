//! What a real-time thread may rely on: no allocation, no other thread, the deadline kept.

use crate::counting;
use crate::support::{expectation, in_own_thread, in_us, patient, served_over_udp};
use drivers::ethercat::{Bus, ExchangeError, UdpLink};
use drivers::monotonic_ns;
use sim::ethercat::{FaultHandle, ServeOptions, ServerHandle};
use sim::rt;
use std::time::Duration;

/// A segment in a thread of its own, whose allocations are not ours, above [`promoted`] ones.
fn served() -> (ServerHandle, FaultHandle, Bus) {
    let (server, address, faults) = served_over_udp(ServeOptions { priority: Some(85) });
    let link = UdpLink::open(address).unwrap();
    let bus = Bus::bring_up(Box::new(link), &expectation(), patient()).unwrap();
    (server, faults, bus)
}

/// Runs a test with real-time priority where that is permitted: then it is not late because others compute.
fn promoted(test: impl FnOnce() + Send + 'static) {
    in_own_thread(|| {
        println!("MainDevice: {}", rt::promote(80));
        test();
    });
}

#[test]
fn an_exchange_never_allocates() {
    promoted(exchanges_without_allocating);
}

fn exchanges_without_allocating() {
    let (server, faults, mut bus) = served();
    let mut inputs = [0; 172];
    let mut counted = |cycles: u32, deadline_us: u64, what: &str| {
        let mut failures = 0;
        let before = counting::so_far();
        for cycle in 0..cycles {
            let outcome = bus.exchange(&[cycle as u8; 36], &mut inputs, in_us(deadline_us));
            failures += u32::from(outcome.is_err());
        }
        assert_eq!(counting::so_far() - before, 0, "{what}");
        println!("{what}: {failures} of {cycles} failed");
        failures
    };
    assert_eq!(counted(2000, 500_000, "good cycles"), 0);
    faults.lose_next(300);
    assert_eq!(counted(300, 200, "lost frames"), 300);
    faults.delay_next(64, Duration::from_millis(2));
    counted(64, 200, "late frames");
    faults.duplicate_next(50);
    counted(50, 500_000, "duplicates");
    faults.corrupt_next(40);
    counted(40, 500, "damaged frames");
    faults.foreign_before_next(20);
    counted(20, 500_000, "foreign frames");
    faults.working_counter_low_for(Duration::from_millis(100));
    assert!(counted(20, 500_000, "low working counter") > 0);
    std::thread::sleep(Duration::from_millis(120));
    assert_eq!(counted(100, 500_000, "good again"), 0);
    faults.drop_to_safeop(0);
    assert_eq!(counted(20, 500_000, "left OP"), 20);
    drop(server);
    assert_eq!(counted(20, 500, "nobody listens"), 20);
}

#[test]
fn no_thread_is_started_behind_our_back() {
    let (_server, _faults, mut bus) = served();
    bus.exchange(&[0; 36], &mut [0; 172], in_us(500_000))
        .unwrap();
    for task in std::fs::read_dir("/proc/self/task").unwrap() {
        // A thread of another test may just be ending.
        let name = std::fs::read_to_string(task.unwrap().path().join("comm")).unwrap_or_default();
        assert!(!name.contains("async-io"), "ethercrab's timers are in use");
    }
}

#[test]
fn an_exchange_returns_at_its_deadline() {
    promoted(returns_at_its_deadline);
}

fn returns_at_its_deadline() {
    let (_server, faults, mut bus) = served();
    faults.lose_next(u32::MAX);
    let mut late_us: Vec<u64> = (0..200)
        .map(|_| {
            let deadline_ns = in_us(500);
            assert_eq!(
                bus.exchange(&[0; 36], &mut [0; 172], deadline_ns),
                Err(ExchangeError::Lost)
            );
            (monotonic_ns()
                .checked_sub(deadline_ns)
                .expect("not before the deadline"))
                / 1000
        })
        .collect();
    late_us.sort_unstable();
    println!(
        "late by {} µs (median), {} µs (p99), {} µs (worst)",
        late_us[100], late_us[198], late_us[199]
    );
    assert!(late_us[100] < 5_000, "median {} µs", late_us[100]);
}

#[test]
fn a_segment_that_is_gone_is_told_from_a_lost_frame() {
    let (server, _faults, mut bus) = served();
    drop(server);
    let mut exchange = || bus.exchange(&[0; 36], &mut [0; 172], in_us(5_000));
    let refused = |outcome: &Result<_, ExchangeError>| {
        matches!(
            outcome,
            Err(ExchangeError::Io {
                kind: std::io::ErrorKind::ConnectionRefused,
                ..
            })
        )
    };
    // A process that another test is just starting has the server's socket, too, until it runs.
    let mut tries = 0..400;
    assert!(tries.any(|_| refused(&exchange())));
    let outcomes: Vec<_> = (0..5).map(|_| exchange()).collect();
    assert!(outcomes.iter().all(refused), "{outcomes:?}");
}
