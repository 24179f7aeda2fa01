//! What is done with a store: one of several threads measures, the others are busy.

use std::fmt;
use std::hint::black_box;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Scope;
use std::time::Duration;

use coordination::symbols::Datatype;
use onboard::cli::Failure;
use sim::rt::monotonic_ns;

use super::stores::{Read, Store, Write};
use crate::bench::samples::Sample;
use crate::bench::windows::Contender;

/// So many calls make one sample when nobody else uses the value: one alone is shorter than the clock takes to be read.
const BATCH: u64 = 1_000;
/// One call in so many is measured when there are others: enough samples in a window, and little time for the clock.
const ONE_IN: u64 = 64;
/// From one write to the next beside those who read: a hundred times as often as the fastest of a robot's threads.
const WRITE_NS: u64 = 10_000;

/// What is done with a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    /// Reads of one reader, and nobody else.
    Alone,
    /// Reads of a reader among so many, while one writes every [`WRITE_NS`].
    Read(usize),
    /// Writes while so many read as fast as they can.
    Write(usize),
}

impl fmt::Display for Use {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Alone => f.write_str("read alone"),
            Self::Read(readers) => write!(f, "read by one of {readers}, one writes"),
            Self::Write(readers) => write!(f, "written, {readers} read"),
        }
    }
}

/// A store, in one use.
pub(super) struct Used<T, S> {
    what: Use,
    write: Write<T>,
    reads: Vec<Read<T>>,
    value: T,
    _store: S,
}

impl<T: Datatype, S: Store<T>> Used<T, S> {
    /// Makes the store.
    ///
    /// # Errors
    /// As of [`Store::ends`].
    pub(super) fn new(what: Use) -> Result<Self, Failure> {
        let readers = match what {
            Use::Alone => 1,
            Use::Read(readers) | Use::Write(readers) => readers,
        };
        let (write, reads, store) = S::ends(T::zeroed(), readers)?;
        Ok(Self {
            what,
            write,
            reads,
            value: T::zeroed(),
            _store: store,
        })
    }
}

impl<T: Datatype, S: Store<T>> Contender for Used<T, S> {
    fn name(&self) -> String {
        S::NAME.to_owned()
    }

    fn window(&mut self, length: Duration, into: &mut Vec<Sample>) -> Result<(), Failure> {
        let end_ns = monotonic_ns() + length.as_nanos() as u64;
        let (value, write) = (self.value, &mut self.write);
        let mut write = || write(black_box(&value));
        let Some((first, others)) = self.reads.split_first_mut() else {
            return Ok(());
        };
        let mut first = || once(&mut *first);
        if self.what == Use::Alone {
            measure(end_ns, BATCH, BATCH, &mut first, into);
            return Ok(());
        }
        let over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            for other in others {
                busy(scope, &over, || once(&mut *other));
            }
            if matches!(self.what, Use::Write(_)) {
                busy(scope, &over, first);
                measure(end_ns, ONE_IN, 1, &mut write, into);
            } else {
                let mut next_ns = monotonic_ns();
                busy(scope, &over, move || {
                    write();
                    next_ns += WRITE_NS;
                    while monotonic_ns() < next_ns {
                        std::hint::spin_loop();
                    }
                });
                measure(end_ns, ONE_IN, 1, &mut first, into);
            }
            over.store(true, Ordering::Relaxed);
        });
        Ok(())
    }
}

/// Reads once, whatever becomes of the value.
fn once<T>(mut read: impl FnMut() -> T) {
    black_box(read());
}

/// Calls it on a thread of its own until it is over.
fn busy<'scope>(
    scope: &'scope Scope<'scope, '_>,
    over: &'scope AtomicBool,
    mut call: impl FnMut() + Send + 'scope,
) {
    scope.spawn(move || {
        while !over.load(Ordering::Relaxed) {
            call();
        }
    });
}

/// Calls it until then; of each `of` calls the last `measured` make a sample, which is of one.
fn measure(end_ns: u64, of: u64, measured: u64, call: &mut impl FnMut(), into: &mut Vec<Sample>) {
    loop {
        for _ in measured..of {
            call();
        }
        let begin_ns = monotonic_ns();
        for _ in 0..measured {
            call();
        }
        let now_ns = monotonic_ns();
        into.push(Sample::mean_of(measured, begin_ns, now_ns));
        if now_ns >= end_ns {
            return;
        }
    }
}

/// What reading the clock adds to a sample of one call, nanoseconds: the mean of many.
#[must_use]
pub(super) fn clock_ns() -> f64 {
    let mut samples = Vec::new();
    measure(0, BATCH, BATCH, &mut || once(monotonic_ns), &mut samples);
    samples.first().map_or(0.0, |sample| sample.value)
}
