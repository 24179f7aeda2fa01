//! A watch of the rig's own: tells a machine that stalls from a program that is late.
//!
//! On every core a thread above all others sleeps a millisecond at a time. What it oversleeps, nobody on that core had. One more thread
//! sends bytes through a terminal, as a lidar does: what the kernel keeps for long, no robot could have had.

mod terminal;
#[cfg(test)]
mod tests;

use std::fmt;
use std::fs;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use onboard::realtime::clock::sleep_until;
use onboard::symbols::faults::Fault;
use rustix::event::Timespec;
use rustix::thread::{CpuSet, sched_setaffinity};
use serde::{Deserialize, Serialize};
use sim::rt::{monotonic_ns, promote};

use self::terminal::Terminal;
use crate::threads::Threads;

const PERIOD_NS: u64 = 1_000_000;
/// What is overslept by more is a stall.
pub(crate) const STALL_NS: u64 = 5_000_000;
/// From one byte through the terminal to the next.
const BYTES_NS: u64 = 10_000_000;
/// A byte that takes longer is a stall: half of what a lidar takes for a turn.
const BYTE_STALL_NS: u64 = 50_000_000;
/// No longer is a byte waited for: what stops the watch waits for that too.
const BYTE_TIMEOUT: Timespec = Timespec {
    tv_sec: 2,
    tv_nsec: 0,
};
/// A stall this long costs a robot what it judges itself by: frames, setpoints, scans.
const SPOILS_MS: f64 = 15.0;
/// Above every thread of robots and devices.
const PRIORITY: u8 = 99;
/// Stalls that are kept: a machine with more of them is of no use.
const MOST: usize = 100_000;

/// Latches that a stall can cause: threads, frames and scans that come late. What motors, wheels and the program itself do is no matter
/// of time.
pub const LATCHES: [Fault; 5] = [
    Fault::Overruns,
    Fault::ThreadHung,
    Fault::BringUpLimit,
    Fault::DriveReturned,
    Fault::PoseUncertain,
];

/// A stall this long before a latch, or shorter, counts as its cause.
pub const LATCHES_WITHIN_NS: u64 = 2_000_000_000;
/// One this long before a violation, or shorter, may be its cause: after 2 s a robot believes the right thing of itself again, and in a
/// metre more, which takes it two or three, it has made good what it came off its way.
pub const VIOLATES_WITHIN_NS: u64 = 5_000_000_000;

/// How often and how long the machine stalled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stalls {
    /// Times that a core was gone for more than 5 ms, or that the kernel kept a terminal's byte for more than 50 ms.
    pub count: usize,
    /// The longest, milliseconds.
    pub longest_ms: f64,
    /// Time that the host took from all cores together, as the kernel counts it, milliseconds.
    pub steal_ms: f64,
    /// The watch was refused real-time priority, at least on one core: what other programs took of it counts, too.
    #[serde(default)]
    pub without_priority: bool,
}

impl Stalls {
    /// How often and how long, in words.
    #[must_use]
    pub fn in_words(&self) -> String {
        let (count, longest_ms) = (self.count, self.longest_ms);
        let load = if self.without_priority {
            ", seen without real-time priority: load counts, too"
        } else {
            ""
        };
        format!("{count} times, {longest_ms:.0} ms at most{load}")
    }

    /// Whether a robot's failure may be due to them: one of them cost it what it judges itself by.
    #[must_use]
    pub fn spoil(&self) -> bool {
        self.longest_ms >= SPOILS_MS
    }

    /// Those of several runs together.
    #[must_use]
    pub fn together(all: impl Iterator<Item = Self>) -> Self {
        all.fold(Self::default(), |sum, own| Self {
            count: sum.count + own.count,
            longest_ms: sum.longest_ms.max(own.longest_ms),
            steal_ms: sum.steal_ms + own.steal_ms,
            without_priority: sum.without_priority || own.without_priority,
        })
    }
}

impl fmt::Display for Stalls {
    /// In a sentence.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the machine stalled {}", self.in_words())
    }
}

/// A stall that was long enough to spoil a run. Times are seconds since the run's start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LongStall {
    /// When it began.
    pub from_s: f64,
    /// When it was over.
    pub to_s: f64,
}

impl LongStall {
    /// Whether it lasted at a time of the run, or was over at most so long before.
    #[must_use]
    pub fn is_near(&self, at_s: f64, within_ns: u64) -> bool {
        self.from_s <= at_s && at_s - self.to_s <= within_ns as f64 / 1e9
    }
}

/// Watches until it is dropped. All of a process look through the same threads, those that the first one of them has started.
pub struct StallWatch {
    threads: Arc<Watching>,
    start_ns: u64,
    steal_ms: f64,
}

/// When each stall ended, and how long it was, nanoseconds.
type Seen = Mutex<Vec<(u64, u64)>>;

/// A thread for each core and one for a terminal, and what they saw.
#[derive(Default)]
struct Watching {
    cores: Arc<Seen>,
    terminal: Arc<Seen>,
    /// One of the threads was refused its priority.
    refused: Arc<AtomicBool>,
    threads: Threads,
}

impl StallWatch {
    /// Starts to watch. Without the privilege of real-time priority it sees the load of the machine as well, and says so.
    ///
    /// # Errors
    /// The operating system's.
    pub fn start() -> std::io::Result<Self> {
        Self::shared(Watching::start)
    }

    /// The same of cores alone, for who measures microseconds: bytes through a terminal take some.
    ///
    /// # Errors
    /// The operating system's.
    pub fn of_cores() -> std::io::Result<Self> {
        Self::shared(Watching::of_cores)
    }

    fn shared(start: fn() -> std::io::Result<Watching>) -> std::io::Result<Self> {
        static SHARED: Mutex<Weak<Watching>> = Mutex::new(Weak::new());
        let mut shared = SHARED.lock().unwrap_or_else(PoisonError::into_inner);
        let threads = match shared.upgrade() {
            Some(threads) => threads,
            None => Arc::new(start()?),
        };
        *shared = Arc::downgrade(&threads);
        Ok(Self::of(threads))
    }

    fn of(threads: Arc<Watching>) -> Self {
        Self {
            threads,
            start_ns: monotonic_ns(),
            steal_ms: steal_ms(),
        }
    }

    /// What it has seen.
    #[must_use]
    pub fn stalls(&self) -> Stalls {
        Stalls {
            steal_ms: (steal_ms() - self.steal_ms).max(0.0),
            ..self.since(self.start_ns)
        }
    }

    /// Stalls that ended at or after a time.
    #[must_use]
    pub fn since(&self, start_ns: u64) -> Stalls {
        let seen = self.threads.all();
        let all = seen.iter().flat_map(|seen| seen.iter());
        let of = all.filter(|(end_ns, _)| *end_ns >= start_ns);
        let longest_ns = of.clone().map(|(_, length_ns)| *length_ns).max();
        Stalls {
            count: of.count(),
            longest_ms: longest_ns.unwrap_or(0) as f64 / 1e6,
            steal_ms: 0.0,
            without_priority: self.threads.refused.load(Ordering::Relaxed),
        }
    }

    /// From when to when each stall lasted that may spoil a run, of those that it has seen.
    #[must_use]
    pub fn long(&self) -> Vec<Range<u64>> {
        let seen = self.threads.all();
        let all = seen.iter().flat_map(|seen| seen.iter());
        let own = all.filter(|(end_ns, _)| *end_ns >= self.start_ns);
        let long = own.filter(|(_, length_ns)| *length_ns as f64 / 1e6 >= SPOILS_MS);
        long.map(|&(end_ns, length_ns)| end_ns - length_ns..end_ns)
            .collect()
    }

    /// From when to when a core was gone, each, for stalls that ended at or after a time.
    #[must_use]
    pub fn spans_since(&self, start_ns: u64) -> Vec<Range<u64>> {
        let seen = lock(&self.threads.cores);
        let of = seen.iter().filter(|(end_ns, _)| *end_ns >= start_ns);
        of.map(|&(end_ns, length_ns)| end_ns - length_ns..end_ns)
            .collect()
    }

    /// Whether the machine stalled at any time from one to another.
    #[must_use]
    pub fn stalled(&self, from_ns: u64, to_ns: u64) -> bool {
        let seen = self.threads.all();
        let mut all = seen.iter().flat_map(|seen| seen.iter());
        all.any(|&(end_ns, length_ns)| end_ns >= from_ns && end_ns - length_ns <= to_ns)
    }
}

impl Watching {
    fn all(&self) -> [MutexGuard<'_, Vec<(u64, u64)>>; 2] {
        [&self.cores, &self.terminal].map(|seen| lock(seen))
    }

    fn of_cores() -> std::io::Result<Self> {
        let mut watching = Self::default();
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        for core in 0..cores {
            let (seen, refused) = (Arc::clone(&watching.cores), Arc::clone(&watching.refused));
            let threads = &mut watching.threads;
            threads.spawn(format!("stalls-{core}"), move |stop| {
                let mut own = CpuSet::new();
                own.set(core);
                // Unpinned it still sees stalls of the whole machine.
                let _ = sched_setaffinity(None, &own);
                promote_or_note(&refused);
                look(&seen, stop, monotonic_ns, sleep_until);
            })?;
        }
        Ok(watching)
    }

    fn start() -> std::io::Result<Self> {
        let mut watching = Self::of_cores()?;
        // Where no terminal is to be had, no lidar is simulated either.
        if let Ok(terminal) = Terminal::open() {
            let (seen, refused) = (
                Arc::clone(&watching.terminal),
                Arc::clone(&watching.refused),
            );
            let work = move |stop: &AtomicBool| {
                promote_or_note(&refused);
                let pass_byte = || terminal.pass_byte(BYTE_TIMEOUT).is_ok();
                send_bytes(&seen, stop, (monotonic_ns, sleep_until), pass_byte);
            };
            watching.threads.spawn("stalls-terminal".to_owned(), work)?;
        }
        Ok(watching)
    }
}

/// Above all others, or noted.
fn promote_or_note(refused: &AtomicBool) {
    if promote(PRIORITY).refused.is_some() {
        refused.store(true, Ordering::Relaxed);
    }
}

fn lock(seen: &Seen) -> MutexGuard<'_, Vec<(u64, u64)>> {
    seen.lock().unwrap_or_else(PoisonError::into_inner)
}

fn note(seen: &Seen, end_ns: u64, length_ns: u64) {
    let mut seen = lock(seen);
    if seen.len() < MOST {
        seen.push((end_ns, length_ns));
    }
}

/// Looks at a clock and sleeps on it until it is told to stop.
fn look(seen: &Seen, stop: &AtomicBool, now_ns: impl Fn() -> u64, sleep_until: impl Fn(u64)) {
    let mut next_ns = now_ns();
    while !stop.load(Ordering::Relaxed) {
        next_ns += PERIOD_NS;
        sleep_until(next_ns);
        let now_ns = now_ns();
        if now_ns > next_ns + STALL_NS {
            note(seen, now_ns, now_ns - next_ns);
        }
        next_ns = next_ns.max(now_ns);
    }
}

/// Sends bytes through a terminal until it is told to stop, or the terminal fails.
fn send_bytes(
    seen: &Seen,
    stop: &AtomicBool,
    (now_ns, sleep_until): (impl Fn() -> u64, impl Fn(u64)),
    pass_byte: impl Fn() -> bool,
) {
    let mut next_ns = now_ns();
    while !stop.load(Ordering::Relaxed) {
        let sent_ns = now_ns();
        if !pass_byte() {
            return;
        }
        let arrived_ns = now_ns();
        if arrived_ns > sent_ns + BYTE_STALL_NS {
            note(seen, arrived_ns, arrived_ns - sent_ns);
        }
        next_ns = (next_ns + BYTES_NS).max(arrived_ns);
        sleep_until(next_ns);
    }
}

/// The eighth number of the first line of `/proc/stat` (proc(5)), in ticks of 10 ms.
fn steal_ms() -> f64 {
    let text = fs::read_to_string("/proc/stat").unwrap_or_default();
    let line = text.lines().next().unwrap_or_default();
    let ticks = line.split_whitespace().nth(8);
    ticks
        .and_then(|ticks| ticks.parse::<f64>().ok())
        .unwrap_or(0.0)
        * 10.0
}
