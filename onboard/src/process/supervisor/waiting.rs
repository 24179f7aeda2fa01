//! Requests that wait for their answer: what came of them shows only once the activities have looked again.

use crate::process::ctl::Pending;
use crate::realtime::clock::MILLISECOND_NS;

/// How long activities have to look again after a reset. The slowest to believe what it sees is the drive, with 200 ms for motors
/// that it was told to power; what it found has reached the supervisor a period of 100 ms later. Of two cycles that are equally
/// near, jitter must not make it the later: half a period less.
pub(super) const RESET_NS: u64 = 250 * MILLISECOND_NS;
/// How long navigation has to look at the walls around the place where it was told that it stands: ten scans.
pub(super) const PLACED_NS: u64 = 950 * MILLISECOND_NS;

/// Requests that were carried out and not yet answered.
#[derive(Default)]
pub(super) struct Waiting(Vec<(Pending, u64)>);

impl Waiting {
    /// Answers this one then.
    pub(super) fn wait(&mut self, pending: Pending, due_ns: u64) {
        self.0.push((pending, due_ns));
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Those whose time has come.
    pub(super) fn due(&mut self, now_ns: u64) -> Vec<Pending> {
        let due = self.0.extract_if(.., |(_, due_ns)| now_ns >= *due_ns);
        due.map(|(pending, _)| pending).collect()
    }
}
