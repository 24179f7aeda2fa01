//! `read_scan` allocates nothing, whatever the device sends.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::time::Duration;

use drivers::hokuyo::{Hokuyo, ReadError, Scan};
use drivers::monotonic_ns;

use super::peer::{Order, Peer, Setup};
use super::scripted_connect::options;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

/// Counts the allocations and releases of each thread.
struct Counting;

fn count() {
    ALLOCATIONS.set(ALLOCATIONS.get() + 1);
}

// SAFETY: every call goes to the system's allocator unchanged; counting touches only a constant-initialised
// thread-local integer, which needs no allocation.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count();
        // SAFETY: the caller keeps the contract of `dealloc`, and `pointer` came from `System`.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller keeps the contract of `realloc`, and `pointer` came from `System`.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn read(lidar: &mut Hokuyo, scan: &mut Scan) -> Result<(), ReadError> {
    let before = ALLOCATIONS.get();
    let result = lidar.read_scan(scan, monotonic_ns() + 30_000_000);
    assert_eq!(ALLOCATIONS.get(), before, "{result:?}");
    result.map(drop)
}

#[test]
fn the_counter_counts() {
    let before = ALLOCATIONS.get();
    drop(std::hint::black_box(vec![1u8; 10]));
    assert_eq!(ALLOCATIONS.get(), before + 2);
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
