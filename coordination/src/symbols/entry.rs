//! The handles through which symbols are written and read.

use std::fmt;
use std::sync::atomic::{Ordering, fence};

use iceoryx2::port::reader::EntryHandle;
use iceoryx2::port::writer::EntryHandleMut;

use super::blackboard::Key;
use super::service::Service;
use super::{Datatype, Stamped};

/// The right to write one symbol; there is one per symbol.
///
/// Its owner acquires it from the table and releases it by dropping it; then it can be acquired again, and begins with a value that was
/// never written. It keeps the shared memory alive, so the order in which handles and the table are dropped does not matter.
///
/// Dropping it takes a lock and is not for real-time threads.
pub struct Writer<T: Datatype> {
    handle: EntryHandleMut<Service, Key, Stamped<T>>,
    /// After `handle`, which lies in it.
    _hold: Box<dyn Send + Sync>,
}

impl<T: Datatype> Writer<T> {
    /// `hold` keeps the memory, and gives the symbol back when it is dropped.
    pub(super) fn new(
        handle: EntryHandleMut<Service, Key, Stamped<T>>,
        hold: Box<dyn Send + Sync>,
    ) -> Self {
        let mut writer = Self {
            handle,
            _hold: hold,
        };
        // Touches both buffers, so that the first real writes find their pages mapped.
        for _ in 0..2 {
            writer.write(0, &T::zeroed());
        }
        writer
    }

    /// Publishes `value`, which was true at `stamp_ns`.
    ///
    /// Real time: no reader can hold it up; it copies the value and adds one to a counter. That is
    /// wait-free on x86. On 32-bit ARM the addition is an exclusive access that a reader at the very
    /// same instant can make repeat.
    pub fn write(&mut self, stamp_ns: u64, value: &T) {
        // iceoryx2 alternates between two buffers and releases each with its counter. Nothing in
        // it keeps the next write into the older buffer from becoming visible before that counter
        // on a weakly ordered processor (the ARM target), so readers could accept a torn value.
        // This fence does; it costs nothing on x86.
        fence(Ordering::Release);
        self.handle.update_with_copy(Stamped {
            stamp_ns,
            value: *value,
        });
    }
}

impl<T: Datatype> fmt::Debug for Writer<T> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "Writer<{}>", T::NAME)
    }
}

/// Beside the value of an added symbol: whether the symbol was removed.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Presence {
    pub(super) removed: u64,
}

const _: () = assert!(size_of::<Presence>() == 8 && align_of::<Presence>() == align_of::<u64>());

impl Datatype for Presence {
    const NAME: &'static str = "symbol_presence";
}

/// The right to read one symbol, for one thread at a time; any number exist.
///
/// Dropping it lets the directory show that this activity reads no more, which takes a lock and is not for real-time threads.
pub struct Reader<T: Datatype> {
    handle: EntryHandle<Service, Key, Stamped<T>>,
    /// Of an added symbol: whether it was removed.
    presence: Option<EntryHandle<Service, Key, Stamped<Presence>>>,
    retries: u64,
    /// After the handles, which lie in it.
    _hold: Box<dyn Send + Sync>,
}

impl<T: Datatype> Reader<T> {
    pub(super) fn new(
        handle: EntryHandle<Service, Key, Stamped<T>>,
        presence: Option<EntryHandle<Service, Key, Stamped<Presence>>>,
        hold: Box<dyn Send + Sync>,
    ) -> Self {
        Self {
            handle,
            presence,
            retries: 0,
            _hold: hold,
        }
    }

    /// Whether the symbol was removed from the table: then the value stays what it is. Never of a symbol that was declared before
    /// the table was built. Real time: copies 16 bytes from shared memory.
    #[must_use]
    pub fn is_removed(&self) -> bool {
        let presence = self.presence.as_ref();
        presence.is_some_and(|presence| presence.get().value.removed != 0)
    }

    /// The newest value. Real time: lock-free; it is read again when the owner published during
    /// the copy, so it ends unless the owner publishes faster than one copy takes, every time.
    pub fn read(&mut self) -> Stamped<T> {
        let value = self.handle.get();
        // The handle notes the counter before the first copy; it has moved if a write came in.
        if !self.handle.is_up_to_date(&value) {
            self.retries = self.retries.saturating_add(1);
        }
        *value
    }

    /// How many reads met a write, each of which may have been a second copy.
    ///
    /// iceoryx2 repeats inside and does not say how often. This counts, at the cost of one load,
    /// the reads during which the symbol changed: never fewer than those repeated, and a few more,
    /// because a write just before or just after the copy looks the same.
    #[must_use]
    pub fn retries(&self) -> u64 {
        self.retries
    }
}

impl<T: Datatype> fmt::Debug for Reader<T> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "Reader<{}>", T::NAME)
    }
}
