//! An allocator that counts what each thread allocates and frees. Test programs of other crates include this file too.

#![allow(dead_code, reason = "each test program uses its own part")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

struct Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

thread_local! {
    // Initialised at compile time and without a destructor: counting allocates nothing, however late it happens.
    static CALLS: Cell<u64> = const { Cell::new(0) };
    static LIVE_BYTES: Cell<i64> = const { Cell::new(0) };
}

fn count(bytes: i64) {
    CALLS.set(CALLS.get() + 1);
    LIVE_BYTES.set(LIVE_BYTES.get() + bytes);
}

// SAFETY: every call goes to the system's allocator unchanged; counting uses no heap.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as i64);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(-(layout.size() as i64));
        // SAFETY: the caller keeps the contract of `dealloc`, and `pointer` came from `System`.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size as i64 - layout.size() as i64);
        // SAFETY: the caller keeps the contract of `realloc`, and `pointer` came from `System`.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

/// Allocations, reallocations and releases by this thread so far.
pub fn so_far() -> u64 {
    CALLS.get()
}

/// How often `work` allocated, reallocated or freed on this thread.
pub fn allocations(work: impl FnOnce()) -> u64 {
    let before = so_far();
    work();
    so_far() - before
}

/// Bytes that this thread has allocated less those that it has freed.
pub fn live_bytes() -> i64 {
    LIVE_BYTES.get()
}

#[test]
fn allocating_and_freeing_count() {
    assert_eq!(allocations(|| drop(std::hint::black_box(Box::new(1)))), 2);
    let before = live_bytes();
    let held = std::hint::black_box(vec![0u8; 100]);
    assert_eq!(live_bytes() - before, 100);
    drop(held);
    assert_eq!(live_bytes() - before, 0);
}
