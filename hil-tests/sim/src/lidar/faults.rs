//! Faults of a lidar, to be injected while it runs, and what it counts.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::disturbance::Disturbance;
use crate::rt::Granted;

/// Most requests that may wait; further ones are dropped. The server takes them within milliseconds.
const MAX_REQUESTS: usize = 1024;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Request {
    Unplug,
    Replug,
    Disturb(Disturbance),
}

/// What the lidar has done so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// The cable is in.
    pub plugged: bool,
    /// The laser is on.
    pub measuring: bool,
    /// A stream runs.
    pub streaming: bool,
    /// Bit rate of the device's line.
    pub bit_rate: u32,
    /// Bit rate the host has set on its side.
    pub host_bit_rate: u32,
    /// Turns measured.
    pub measured_turns: u64,
    /// Turns that passed while the simulator was not running.
    pub missed_turns: u64,
    /// Scans of a stream put on the line.
    pub scans: u64,
    /// Scans of a stream dropped because the line was too slow or nobody read.
    pub dropped_scans: u64,
    /// When the last byte of the newest scan was handed to the host, on the monotonic clock; 0 before the first.
    pub scan_ended_ns: u64,
    /// Bytes handed to the host, garbled ones included.
    pub bytes: u64,
    /// Bytes garbled because the bit rates differed, in both directions.
    pub garbled_bytes: u64,
    /// Bytes thrown away because nobody read them.
    pub unread_bytes: u64,
    /// Replies' bytes lost because too much was waiting.
    pub lost_bytes: u64,
}

#[derive(Debug, Default)]
pub(super) struct Shared {
    pub(super) stop: AtomicBool,
    pub(super) requests: Mutex<VecDeque<Request>>,
    pub(super) counters: Mutex<Counters>,
    pub(super) slave: Mutex<Option<PathBuf>>,
    pub(super) error: Mutex<Option<String>>,
    pub(super) granted: Mutex<Option<Granted>>,
}

/// Every value behind these locks is valid after each statement, so a panic elsewhere does not spoil it.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Injects faults from any thread; each takes effect within 5 ms.
#[derive(Debug, Clone)]
pub struct FaultHandle {
    shared: Arc<Shared>,
}

impl FaultHandle {
    pub(super) fn new(shared: Arc<Shared>) -> FaultHandle {
        FaultHandle { shared }
    }

    /// Pulls the cable: the terminal hangs up, its path disappears, the device loses power.
    pub fn unplug(&self) {
        self.request(Request::Unplug);
    }

    /// Puts the cable back: a new terminal under the same symbolic link, the device powers up.
    pub fn replug(&self) {
        self.request(Request::Replug);
    }

    /// Sends this number of random bytes between scans.
    pub fn garbage(&self, bytes: usize) {
        self.disturb(Disturbance::Garbage { bytes });
    }

    /// Loses the second half of the next scans.
    pub fn truncate_scans(&self, scans: u32) {
        self.disturb(Disturbance::TruncateScans { scans });
    }

    /// Flips a bit in the data of the next scans, so that a checksum is wrong.
    pub fn corrupt_checksums(&self, scans: u32) {
        self.disturb(Disturbance::CorruptScans { scans });
    }

    /// The device hangs: it neither receives nor sends.
    pub fn freeze(&self) {
        self.disturb(Disturbance::Freeze { frozen: true });
    }

    /// Ends [`freeze`](Self::freeze): the device continues where it stopped.
    pub fn thaw(&self) {
        self.disturb(Disturbance::Freeze { frozen: false });
    }

    /// Covers its window: no beam has an echo.
    pub fn cover(&self) {
        self.disturb(Disturbance::Cover { covered: true });
    }

    /// Ends [`cover`](Self::cover).
    pub fn uncover(&self) {
        self.disturb(Disturbance::Cover { covered: false });
    }

    /// It says itself that it does not work well, until [`recover`](Self::recover).
    pub fn sicken(&self) {
        self.disturb(Disturbance::Unwell { unwell: true });
    }

    /// It works well again.
    pub fn recover(&self) {
        self.disturb(Disturbance::Unwell { unwell: false });
    }

    /// Interrupts the wire to the host for a time: the device receives and works, but nothing arrives.
    pub fn silence(&self, duration: Duration) {
        self.disturb(Disturbance::Silence { duration });
    }

    /// What the lidar has done so far.
    #[must_use]
    pub fn counters(&self) -> Counters {
        *lock(&self.shared.counters)
    }

    /// What went wrong last, such as a link that could not be made again.
    #[must_use]
    pub fn last_error(&self) -> Option<String> {
        lock(&self.shared.error).clone()
    }

    fn disturb(&self, disturbance: Disturbance) {
        self.request(Request::Disturb(disturbance));
    }

    fn request(&self, request: Request) {
        let mut requests = lock(&self.shared.requests);
        if requests.len() < MAX_REQUESTS && !self.shared.stop.load(Ordering::Relaxed) {
            requests.push_back(request);
        }
    }
}
