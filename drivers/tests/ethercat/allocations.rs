//! Counts what the current thread allocates.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

struct Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
    static LIVE_BYTES: Cell<i64> = const { Cell::new(0) };
}

fn count(bytes: i64) {
    // The thread may be ending, when its counters are gone.
    let _ = COUNT.try_with(|count| count.set(count.get() + 1));
    let _ = LIVE_BYTES.try_with(|live| live.set(live.get() + bytes));
}

// SAFETY: hands everything to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as i64);
        // SAFETY: the caller's promises are those of the system's allocator.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(-(layout.size() as i64));
        // SAFETY: as above, and the pointer came from there.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size as i64 - layout.size() as i64);
        // SAFETY: as above.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

/// Allocations, reallocations and releases of this thread until now.
pub fn so_far() -> u64 {
    COUNT.with(Cell::get)
}

/// Bytes this thread has allocated less those it has freed.
pub fn live_bytes() -> i64 {
    LIVE_BYTES.with(Cell::get)
}

#[test]
fn allocating_and_freeing_count() {
    let before = so_far();
    drop(std::hint::black_box(Box::new(1)));
    assert_eq!(so_far() - before, 2);
    let before = live_bytes();
    let held = std::hint::black_box(vec![0u8; 100]);
    assert_eq!(live_bytes() - before, 100);
    drop(held);
    assert_eq!(live_bytes() - before, 0);
}
