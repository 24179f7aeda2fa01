//! `read_scan` allocates nothing, whatever the device sends.

use std::time::Duration;

use drivers::hokuyo::{Hokuyo, ReadError, Scan};
use drivers::monotonic_ns;

use super::counting::so_far;
use super::peer::{Order, Peer, Setup};
use super::scripted_connect::options;

fn read(lidar: &mut Hokuyo, scan: &mut Scan) -> Result<(), ReadError> {
    let before = so_far();
    let result = lidar.read_scan(scan, monotonic_ns() + 30_000_000);
    assert_eq!(so_far(), before, "{result:?}");
    result.map(drop)
}

#[test]
fn reading_allocates_nothing() {
    let mut peer = Peer::start(Setup::default());
    let mut lidar = Hokuyo::connect(peer.path(), &options()).unwrap();
    let mut scan = Scan::new();
    let mut results = Vec::new();
    let mut read_until =
        |peer: &mut Peer, order: Order, seen: fn(Result<(), ReadError>) -> bool| {
            let ordered = format!("{order:?}");
            peer.order(order);
            // Scans wait in the line while this thread does not run.
            let mut last = (0..100).map(|_| read(&mut lidar, &mut scan));
            assert!(last.any(seen), "{ordered} was never seen");
            // The next order is not to be taken for a part of this one.
            results.extend((0..4).map(|_| read(&mut lidar, &mut scan)));
        };
    read_until(&mut peer, Order::WrongChecksum, |own| {
        own == Err(ReadError::Checksum)
    });
    read_until(&mut peer, Order::Truncate(300), |own| {
        own == Err(ReadError::Truncated)
    });
    read_until(&mut peer, Order::Garbage(vec![0xaa; 2000]), |own| {
        own == Err(ReadError::Garbage)
    });
    read_until(&mut peer, Order::Status("50"), |own| {
        matches!(own, Err(ReadError::DeviceError(_)))
    });
    read_until(
        &mut peer,
        Order::PauseWithin(Duration::from_millis(70)),
        |_| true,
    );
    read_until(&mut peer, Order::Clock(5), |_| true);
    peer.order(Order::Freeze);
    while read(&mut lidar, &mut scan) != Err(ReadError::Timeout) {}
    peer.unplug();
    while read(&mut lidar, &mut scan) != Err(ReadError::Disconnected) {}
    assert!(results.contains(&Ok(())));
    assert!(lidar.counters().clock_jumps > 0);
}
