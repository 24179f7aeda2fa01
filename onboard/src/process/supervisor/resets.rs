//! Resets that wait for their answer: what is still wrong shows only once the activities have looked again.

use crate::process::ctl::Pending;
use crate::realtime::clock::MILLISECOND_NS;

/// How long activities have to look again. The slowest to believe what it sees is the drive, with 200 ms for motors that it was told
/// to power; what it found has reached the supervisor a period of 100 ms later. Of two cycles that are equally near, jitter must not
/// make it the later: half a period less.
const LOOKED_AGAIN_NS: u64 = 250 * MILLISECOND_NS;

/// Resets that were carried out and not yet answered.
#[derive(Default)]
pub(super) struct Resets(Vec<(Pending, u64)>);

impl Resets {
    /// Answers this one later.
    pub(super) fn wait(&mut self, pending: Pending, now_ns: u64) {
        self.0.push((pending, now_ns + LOOKED_AGAIN_NS));
    }

    /// Those whose time has come.
    pub(super) fn due(&mut self, now_ns: u64) -> Vec<Pending> {
        let due = self.0.extract_if(.., |(_, due_ns)| now_ns >= *due_ns);
        due.map(|(pending, _)| pending).collect()
    }
}
