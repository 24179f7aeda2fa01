//! A watch of the rig's own: tells a machine that stalls from a program that is late.
//!
//! On every core a thread above all others sleeps a millisecond at a time. What it oversleeps, nobody on that core had. One more thread
//! sends bytes through a terminal, as a lidar does: what the kernel keeps for long, no robot could have had.

mod terminal;

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

/// How often and how long the machine stalled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stalls {
    /// Times that a core was gone for more than 5 ms, or that the kernel kept a terminal's byte for more than 50 ms.
    pub count: usize,
    /// The longest, milliseconds.
    pub longest_ms: f64,
    /// Time that the host took from all cores together, as the kernel counts it, milliseconds.
    pub steal_ms: f64,
}

impl Stalls {
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
        })
    }
}

impl fmt::Display for Stalls {
    /// In a sentence.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (count, longest_ms) = (self.count, self.longest_ms);
        write!(
            f,
            "the machine stalled {count} times, {longest_ms:.0} ms at most"
        )
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
    threads: Threads,
}

impl StallWatch {
    /// Starts to watch. Without the privilege of real-time priority it sees the load of the machine as well.
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
        }
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
            let seen = Arc::clone(&watching.cores);
            let threads = &mut watching.threads;
            threads.spawn(format!("stalls-{core}"), move |stop| {
                let mut own = CpuSet::new();
                own.set(core);
                // Unpinned it still sees stalls of the whole machine.
                let _ = sched_setaffinity(None, &own);
                let _ = promote(PRIORITY);
                look(&seen, stop, monotonic_ns, sleep_until);
            })?;
        }
        Ok(watching)
    }

    fn start() -> std::io::Result<Self> {
        let mut watching = Self::of_cores()?;
        // Where no terminal is to be had, no lidar is simulated either.
        if let Ok(terminal) = Terminal::open() {
            let seen = Arc::clone(&watching.terminal);
            let work = move |stop: &AtomicBool| {
                let _ = promote(PRIORITY);
                let pass_byte = || terminal.pass_byte(BYTE_TIMEOUT).is_ok();
                send_bytes(&seen, stop, (monotonic_ns, sleep_until), pass_byte);
            };
            watching.threads.spawn("stalls-terminal".to_owned(), work)?;
        }
        Ok(watching)
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

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    /// A watch without threads, begun at a time, that saw these stalls.
    fn watch(start_ns: u64, seen: &[(u64, u64)]) -> StallWatch {
        let threads = Watching::default();
        lock(&threads.cores).extend(seen);
        StallWatch {
            start_ns,
            ..StallWatch::of(Arc::new(threads))
        }
    }

    #[test]
    fn stalls_are_counted_from_a_time_on() {
        let watch = watch(150, &[(100, 7_000_000), (200, 31_000_000)]);
        let of = |stalls: Stalls| (stalls.count, stalls.longest_ms);
        assert_eq!(of(watch.since(0)), (2, 31.0));
        assert_eq!(of(watch.since(101)), (1, 31.0));
        assert_eq!(watch.since(201), Stalls::default());
        // Not those of before its own start.
        let own = watch.stalls();
        assert_eq!(of(own), (1, 31.0));
        assert!(own.steal_ms >= 0.0);
    }

    #[test]
    fn all_watches_of_a_process_look_through_the_same_threads() {
        let watches = [(); 2].map(|()| StallWatch::start().expect("threads"));
        assert!(Arc::ptr_eq(&watches[0].threads, &watches[1].threads));
        assert!(watches[1].start_ns >= watches[0].start_ns);
    }

    #[test]
    fn what_is_overslept_by_more_than_five_milliseconds_is_a_stall() {
        const MS: u64 = 1_000_000;
        // How late each wake-up is, on a clock that begins at one second.
        let late_ns = [0, 5 * MS, 7 * MS, MS / 2, 31 * MS, 0, 0];
        let (clock_ns, wakes) = (Cell::new(1000 * MS), Cell::new(0));
        let (seen, stop) = (Mutex::default(), AtomicBool::new(false));
        let sleep_until = |until_ns: u64| {
            assert!(until_ns > clock_ns.get(), "it sleeps each time");
            clock_ns.set(until_ns + late_ns[wakes.get()]);
            wakes.set(wakes.get() + 1);
            stop.store(wakes.get() == late_ns.len(), Ordering::Relaxed);
        };
        look(&seen, &stop, || clock_ns.get(), sleep_until);
        assert_eq!(wakes.get(), late_ns.len());
        // The next period begins after a stall, which counts once.
        let seen = seen.into_inner().expect("not poisoned");
        let expected = [(1015 * MS, 7 * MS), (1048 * MS + MS / 2, 31 * MS)];
        assert_eq!(seen, expected);
    }

    #[test]
    fn a_byte_that_the_kernel_keeps_is_a_stall() {
        const MS: u64 = 1_000_000;
        let take_ms = [1, 50, 51, 2000];
        let (clock_ns, sent) = (Cell::new(1000 * MS), Cell::new(0));
        let (seen, stop) = (Mutex::default(), AtomicBool::new(false));
        let sleep_until = |until_ns: u64| clock_ns.set(until_ns.max(clock_ns.get()));
        let pass_byte = || {
            clock_ns.set(clock_ns.get() + take_ms[sent.get()] * MS);
            sent.set(sent.get() + 1);
            stop.store(sent.get() == take_ms.len(), Ordering::Relaxed);
            true
        };
        send_bytes(&seen, &stop, (|| clock_ns.get(), sleep_until), pass_byte);
        let expected = [(1111 * MS, 51 * MS), (3111 * MS, 2000 * MS)];
        assert_eq!(*lock(&seen), expected);
        // One that the kernel has taken away is not waited for.
        send_bytes(&seen, &AtomicBool::new(false), (|| 0, |_| ()), || false);

        let threads = Watching::default();
        lock(&threads.terminal).extend(expected);
        let watch = StallWatch::of(Arc::new(threads));
        let all = watch.since(0);
        assert_eq!((all.count, all.longest_ms, all.spoil()), (2, 2000.0, true));
        assert!(watch.stalled(1100 * MS, 1101 * MS) && !watch.stalled(0, 1059 * MS));
        // No core was gone.
        assert_eq!(watch.spans_since(0).first(), None);
    }

    #[test]
    fn only_long_stalls_spoil_a_run() {
        let stalls = |count, longest_ms| Stalls {
            count,
            longest_ms,
            steal_ms: 1.0,
        };
        assert!(!stalls(900, 14.9).spoil() && stalls(1, 15.0).spoil());
        let both = Stalls::together([stalls(2, 31.0), stalls(3, 7.0)].into_iter());
        assert_eq!((both.count, both.longest_ms, both.steal_ms), (5, 31.0, 2.0));
        let said = "the machine stalled 5 times, 31 ms at most";
        assert_eq!(both.to_string(), said);
    }

    #[test]
    fn a_stall_lasts_from_its_begin_to_its_end() {
        let watch = watch(0, &[(100, 20)]);
        assert_eq!(watch.spans_since(100).first(), Some(&(80..100)));
        assert_eq!(watch.spans_since(101).first(), None);
        for (from_ns, to_ns, expected) in [(0, 79, false), (0, 80, true), (90, 95, true)] {
            assert_eq!(
                watch.stalled(from_ns, to_ns),
                expected,
                "{from_ns}..{to_ns}"
            );
        }
        assert!(watch.stalled(100, 200) && !watch.stalled(101, 200));
    }
}
