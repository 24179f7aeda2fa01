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
    for order in [
        Order::WrongChecksum,
        Order::Truncate(300),
        Order::Garbage(vec![0xaa; 2000]),
        Order::Status("50"),
        Order::PauseWithin(Duration::from_millis(70)),
        Order::Clock(5),
    ] {
        peer.order(order);
        results.extend((0..6).map(|_| read(&mut lidar, &mut scan)));
    }
    peer.order(Order::Freeze);
    while read(&mut lidar, &mut scan) != Err(ReadError::Timeout) {}
    peer.unplug();
    while read(&mut lidar, &mut scan) != Err(ReadError::Disconnected) {}
    // All the ways out were taken.
    assert!(results.contains(&Ok(())));
    for error in [
        ReadError::Checksum,
        ReadError::Truncated,
        ReadError::Garbage,
    ] {
        assert!(results.contains(&Err(error)), "{error}: {results:?}");
    }
    assert!(
        results
            .iter()
            .any(|result| matches!(result, Err(ReadError::DeviceError(_))))
    );
    assert!(lidar.counters().clock_jumps > 0);
}
