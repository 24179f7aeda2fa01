//! Reading scans, broken ones included.

use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use drivers::hokuyo::{Hokuyo, ReadError, Scan, Status};
use drivers::monotonic_ns;

use super::peer::{Order, Peer, Setup};
use super::scripted_connect::{WATCHDOG, options, soon};

fn connected() -> (Peer, Hokuyo, Scan) {
    let peer = Peer::start(Setup::default());
    let mut lidar = Hokuyo::connect(peer.path(), &options()).unwrap();
    let mut scan = Scan::new();
    lidar.read_scan(&mut scan, soon()).unwrap();
    (peer, lidar, scan)
}

/// The first failure among the next scans.
fn failure(lidar: &mut Hokuyo, scan: &mut Scan) -> ReadError {
    (0..20)
        .find_map(|_| lidar.read_scan(scan, soon()).err())
        .unwrap()
}

#[test]
fn every_broken_scan_is_dropped_once_and_the_next_one_is_whole() {
    let (peer, mut lidar, mut scan) = connected();
    let orders = [
        (Order::WrongChecksum, ReadError::Checksum),
        // Less than an echo is left of it.
        (Order::Truncate(10), ReadError::Garbage),
        (Order::Truncate(20), ReadError::Truncated),
        (Order::Truncate(500), ReadError::Truncated),
        (Order::Garbage(vec![0xff; 3000]), ReadError::Garbage),
        (
            Order::Garbage(b"noise\n\n\nmore noise\n99b\n".to_vec()),
            ReadError::Garbage,
        ),
        (Order::Status("50"), ReadError::DeviceError(Status(*b"50"))),
    ];
    for (order, expected) in orders {
        let before = lidar.counters();
        peer.order(order.clone());
        assert_eq!(failure(&mut lidar, &mut scan), expected, "{order:?}");
        let sequence = scan.sequence;
        lidar.read_scan(&mut scan, soon()).unwrap();
        assert_eq!(scan.sequence, sequence + 1);
        assert!(
            scan.ranges_mm()
                .iter()
                .enumerate()
                .all(|(beam, range)| usize::from(*range) == beam)
        );
        let after = lidar.counters();
        let faults = |c: drivers::hokuyo::LidarCounters| {
            c.checksum + c.truncated + c.garbage + c.device_errors
        };
        assert_eq!(faults(after), faults(before) + 1, "{order:?}");
        let again = u64::from(!matches!(expected, ReadError::DeviceError(_)));
        assert_eq!(
            after.resynchronisations,
            before.resynchronisations + again,
            "{order:?}"
        );
    }
    let counters = lidar.counters();
    assert_eq!(
        (counters.checksum, counters.truncated, counters.garbage),
        (1, 2, 3)
    );
    assert_eq!(counters.device_errors, 1);
    assert_eq!(counters.scans, scan.sequence + 1);
}

#[test]
fn the_deadline_holds() {
    let (peer, mut lidar, mut scan) = connected();
    peer.order(Order::Freeze);
    while lidar
        .read_scan(&mut scan, monotonic_ns() + 100_000_000)
        .is_ok()
    {}
    for wait_ms in [0, 1, 20, 100] {
        let started = Instant::now();
        let result = lidar.read_scan(&mut scan, monotonic_ns() + wait_ms * 1_000_000);
        assert_eq!(result, Err(ReadError::Timeout));
        assert!(started.elapsed() >= Duration::from_millis(wait_ms));
        assert!(started.elapsed() < Duration::from_millis(wait_ms) + WATCHDOG);
    }
    assert_eq!(lidar.read_scan(&mut scan, 0), Err(ReadError::Timeout));
}

#[test]
fn the_deadline_holds_under_endless_rubbish() {
    let (peer, mut lidar, mut scan) = connected();
    peer.order(Order::Garbage(vec![b'x'; 60_000]));
    let mut timeouts = 0;
    for _ in 0..60 {
        let started = Instant::now();
        let result = lidar.read_scan(&mut scan, monotonic_ns() + 5_000_000);
        timeouts += u32::from(result == Err(ReadError::Timeout));
        assert!(started.elapsed() < WATCHDOG);
    }
    assert!(timeouts > 0);
    // The peer could not write all of it, so what follows is not a whole scan.
    assert!((0..10).any(|_| lidar.read_scan(&mut scan, soon()).is_ok()));
}

/// It pauses in the middle of a scan, and all that it sent before is read.
fn read_until_it_pauses(peer: &Peer, lidar: &mut Hokuyo, scan: &mut Scan) {
    let (begun, begins) = channel();
    peer.order(Order::PauseWithin(begun));
    let mut is_half = false;
    let waited = (0..1000).any(|_| {
        is_half = is_half || begins.try_recv().is_ok();
        let result = lidar.read_scan(scan, monotonic_ns() + 30_000_000);
        assert!(
            matches!(result, Ok(_) | Err(ReadError::Timeout)),
            "{result:?}"
        );
        is_half && result.is_err()
    });
    assert!(waited, "it never paused");
}

#[test]
fn half_a_scan_is_continued_after_a_timeout() {
    let (peer, mut lidar, mut scan) = connected();
    read_until_it_pauses(&peer, &mut lidar, &mut scan);
    peer.order(Order::GoOn);
    let sequence = scan.sequence;
    for next in 1..=3 {
        lidar.read_scan(&mut scan, soon()).unwrap();
        assert_eq!(scan.sequence, sequence + next);
    }
    assert_eq!(lidar.counters().truncated, 0);
}

#[test]
fn a_vanished_device_is_disconnected_and_another_one_connects() {
    let (mut peer, mut lidar, mut scan) = connected();
    peer.unplug();
    let started = Instant::now();
    let deadline = monotonic_ns() + 5_000_000_000;
    let mut last = lidar.read_scan(&mut scan, deadline);
    while last.is_ok() {
        last = lidar.read_scan(&mut scan, deadline);
    }
    assert_eq!(last, Err(ReadError::Disconnected));
    assert_eq!(
        lidar.read_scan(&mut scan, deadline),
        Err(ReadError::Disconnected)
    );
    drop(lidar);
    assert!(started.elapsed() < WATCHDOG);
    connected();
}

#[test]
fn stamps_follow_the_device_and_not_the_arrival() {
    let (peer, mut lidar, mut scan) = connected();
    let turn_ns = lidar.scan_period().as_nanos() as i64;
    let mut last_ns = scan.stamp_ns as i64;
    for round in 0..30 {
        if round % 7 == 3 {
            // Nobody reads for a while: scans wait and arrive together.
            std::thread::sleep(Duration::from_millis(50));
        }
        let received = lidar.read_scan(&mut scan, soon()).unwrap();
        let stamp_ns = scan.stamp_ns as i64;
        // The device counts whole milliseconds.
        assert!(
            (stamp_ns - last_ns - turn_ns).abs() < 1_500_000,
            "{}",
            stamp_ns - last_ns
        );
        assert!(
            stamp_ns < received.arrival_ns as i64 && received.arrival_ns <= received.complete_ns
        );
        assert_eq!(received.missed, 0);
        last_ns = stamp_ns;
    }
    assert_eq!(lidar.counters().clock_jumps, 0);
    read_until_it_pauses(&peer, &mut lidar, &mut scan);
    last_ns = scan.stamp_ns as i64;
    peer.order(Order::Clock(3));
    peer.order(Order::GoOn);
    for _ in 0..10 {
        lidar.read_scan(&mut scan, soon()).unwrap();
        assert!(scan.stamp_ns as i64 > last_ns);
        assert!(scan.stamp_ns < monotonic_ns());
        last_ns = scan.stamp_ns as i64;
    }
    assert!(lidar.counters().clock_jumps > 0);
}

#[test]
fn dropping_it_stops_the_stream() {
    let (peer, lidar, _) = connected();
    drop(lidar);
    let deadline = Instant::now() + WATCHDOG;
    while peer.commands().last().map(String::as_str) != Some("QT") {
        assert!(Instant::now() < deadline, "{:?}", peer.commands());
        std::thread::sleep(Duration::from_millis(5));
    }
}
