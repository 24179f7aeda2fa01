//! `read_scan` allocates nothing, whatever the device sends.

use std::cell::Cell;
use std::sync::mpsc::channel;

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
        |peer: &Peer, order: Order, seen: &dyn Fn(Result<(), ReadError>) -> bool| {
            let ordered = format!("{order:?}");
            peer.order(order);
            // Scans wait in the line while this thread does not run.
            let mut last = (0..100).map(|_| read(&mut lidar, &mut scan));
            assert!(last.any(seen), "{ordered} was never seen");
            // The next order is not to be taken for a part of this one.
            results.extend((0..4).map(|_| read(&mut lidar, &mut scan)));
        };
    read_until(&peer, Order::WrongChecksum, &|own| {
        own == Err(ReadError::Checksum)
    });
    read_until(&peer, Order::Truncate(300), &|own| {
        own == Err(ReadError::Truncated)
    });
    read_until(&peer, Order::Garbage(vec![0xaa; 2000]), &|own| {
        own == Err(ReadError::Garbage)
    });
    read_until(&peer, Order::Status("50"), &|own| {
        matches!(own, Err(ReadError::DeviceError(_)))
    });
    let (begun, begins) = channel();
    let is_half = Cell::new(false);
    read_until(&peer, Order::PauseWithin(begun), &|own| {
        let was_half = is_half.replace(is_half.get() || begins.try_recv().is_ok());
        was_half && own == Err(ReadError::Timeout)
    });
    read_until(&peer, Order::GoOn, &|own| own.is_ok());
    peer.order(Order::Clock(5));
    // Scans of before wait in the line while this thread does not run.
    let mut jumps = (0..100).map(|_| {
        let _ = read(&mut lidar, &mut scan);
        lidar.counters().clock_jumps
    });
    assert!(jumps.any(|jumps| jumps > 0));
    peer.order(Order::Freeze);
    while read(&mut lidar, &mut scan) != Err(ReadError::Timeout) {}
    peer.unplug();
    while read(&mut lidar, &mut scan) != Err(ReadError::Disconnected) {}
    assert!(results.contains(&Ok(())));
}
