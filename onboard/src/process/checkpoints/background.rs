//! Checkpoints kept on a thread of their own: a disk that stalls holds up nobody else, and a supervisor that hangs leaves its robot to an
//! operator.

use std::io;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use super::{CheckpointStore, Ended};
use crate::realtime::memory::STACK_BYTES;

/// How long the last one may take to be kept when the program ends.
const PATIENCE: Duration = Duration::from_secs(1);

/// One that takes longer is as bad as one that fails: the robot goes on and leaves behind what the next process would find.
const SLOW: Duration = Duration::from_secs(2);

/// Without a checkpoint for so long the supervisor hangs, and keeps no fault any more that waits for an operator: one may have come.
pub const UNATTENDED: Duration = Duration::from_secs(1);

/// What a checkpoint becomes then.
type Unattended = fn(&[u8]) -> Option<Vec<u8>>;

/// A store that is used from a thread of its own. Only the newest checkpoint waits for it.
pub struct Background<S> {
    shared: Arc<Shared>,
    /// Gives the store back when it ends.
    thread: Option<JoinHandle<S>>,
}

#[derive(Default)]
struct Shared {
    slot: Mutex<Slot>,
    news: Condvar,
}

#[derive(Default)]
struct Slot {
    waiting: Option<Vec<u8>>,
    /// Since when one is being kept.
    begun: Option<Instant>,
    /// Of the last one that was tried.
    failed: Option<io::Error>,
    /// As the store says after it.
    noted: bool,
    ends: bool,
}

impl Shared {
    /// Locked for no longer than it takes to exchange what is in it.
    fn lock(&self) -> MutexGuard<'_, Slot> {
        self.slot.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<S: CheckpointStore + 'static> Background<S> {
    /// Starts the thread. Where no checkpoint follows another one for a second, what `unattended` makes of that is kept.
    ///
    /// # Errors
    /// The operating system's, when it has no thread to give.
    pub fn of(mut store: S, unattended: Unattended) -> io::Result<Self> {
        let shared = Arc::<Shared>::default();
        let own = Arc::clone(&shared);
        let keep = move || {
            let mut last = None;
            loop {
                let mut slot = own.lock();
                let bytes = loop {
                    if let Some(bytes) = slot.waiting.take() {
                        last = Some(bytes.clone());
                        break bytes;
                    }
                    if slot.ends {
                        return store;
                    }
                    let woken = own.news.wait_timeout(slot, UNATTENDED);
                    let (woken, waited) = woken.unwrap_or_else(PoisonError::into_inner);
                    slot = woken;
                    if waited.timed_out() && slot.waiting.is_none() && !slot.ends {
                        // Once: the next one comes when the supervisor runs again.
                        let left = last.take().and_then(|last| unattended(&last));
                        if let Some(left) = left {
                            break left;
                        }
                    }
                };
                slot.begun = Some(Instant::now());
                drop(slot);
                let result = store.save(&bytes);
                let mut slot = own.lock();
                slot.begun = None;
                (slot.failed, slot.noted) = (result.err(), store.is_noted());
            }
        };
        let thread = Builder::new().name("checkpoint".to_owned());
        let thread = thread.stack_size(STACK_BYTES).spawn(keep)?;
        Ok(Self {
            shared,
            thread: Some(thread),
        })
    }

    /// The store, once what waits is kept.
    fn end(&mut self) -> io::Result<S> {
        self.shared.lock().ends = true;
        self.shared.news.notify_one();
        let until = Instant::now() + PATIENCE;
        let slow = || io::Error::new(io::ErrorKind::TimedOut, "the disk takes too long");
        while let Some(thread) = &self.thread {
            if thread.is_finished() {
                break;
            }
            if Instant::now() > until {
                return Err(slow());
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        let ended = self.thread.take().map(JoinHandle::join);
        ended.and_then(Result::ok).ok_or_else(slow)
    }
}

impl<S: CheckpointStore + 'static> CheckpointStore for Background<S> {
    /// Never waits. An error is that of the one before.
    fn save(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut slot = self.shared.lock();
        slot.waiting = Some(bytes.to_vec());
        self.shared.news.notify_one();
        slot.failed.take().map_or(Ok(()), Err)
    }

    fn arrive(&mut self, ended: Ended) -> io::Result<()> {
        self.end()?.arrive(ended)
    }

    /// Not while one takes long: what the next process would find is of then.
    fn is_noted(&self) -> bool {
        let slot = self.shared.lock();
        let is_slow = { slot.begun }.is_some_and(|begun| begun.elapsed() > SLOW);
        slot.noted && !is_slow
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, Sender, channel};

    use super::*;

    /// Takes as long as a test wants, and fails when told to.
    struct Slow {
        turns: Receiver<bool>,
        begun: Sender<Vec<u8>>,
        kept: Option<Vec<u8>>,
    }

    impl CheckpointStore for Slow {
        fn save(&mut self, bytes: &[u8]) -> io::Result<()> {
            let _ = self.begun.send(bytes.to_vec());
            if self.turns.recv() == Ok(true) {
                self.kept = Some(bytes.to_vec());
                return Ok(());
            }
            Err(io::Error::other("full"))
        }

        fn arrive(&mut self, _ended: Ended) -> io::Result<()> {
            self.kept = None;
            Ok(())
        }

        fn is_noted(&self) -> bool {
            self.kept.is_some()
        }
    }

    fn slow() -> (Background<Slow>, Sender<bool>, Receiver<Vec<u8>>) {
        let ((turn, turns), (begun, begins)) = (channel(), channel());
        let store = Slow {
            turns,
            begun,
            kept: None,
        };
        let unattended = |last: &[u8]| Some([last, b" stopped"].concat());
        let background = Background::of(store, unattended).expect("a thread");
        (background, turn, begins)
    }

    /// Ends it, however late its thread is.
    fn ended(store: &mut Background<Slow>) -> Slow {
        let ended = (0..20).find_map(|_| store.end().ok());
        ended.expect("it ends")
    }

    /// Once, until it runs again.
    #[test]
    fn of_a_supervisor_that_hangs_a_robot_is_kept_that_stays_stopped() {
        const LONG: Duration = Duration::from_secs(20);
        let (mut store, turn, begins) = slow();
        for number in [b"1", b"2"] {
            store.save(number).expect("no error yet");
            assert_eq!(begins.recv_timeout(LONG).expect("begun"), number);
            turn.send(true).expect("waits");
            let stopped = [&number[..], b" stopped"].concat();
            assert_eq!(begins.recv_timeout(LONG).expect("begun"), stopped);
            turn.send(true).expect("waits");
        }
        let again = begins.recv_timeout(UNATTENDED + Duration::from_millis(500));
        assert!(again.is_err(), "it is kept once");
        drop(turn);
        assert_eq!(ended(&mut store).kept, Some(b"2 stopped".to_vec()));
    }

    #[test]
    fn nobody_waits_for_a_slow_disk_and_the_newest_is_kept() {
        let (mut store, turn, begins) = slow();
        store.save(b"1").expect("no error yet");
        assert_eq!(begins.recv().expect("begun"), b"1");
        for number in 2..=9 {
            store.save(&[b'0' + number]).expect("no error yet");
        }
        turn.send(true).expect("waits");
        assert_eq!(begins.recv().expect("begun"), b"9");
        turn.send(true).expect("waits");
        drop(turn);
        assert_eq!(ended(&mut store).kept, Some(b"9".to_vec()));
    }

    #[test]
    fn that_it_fails_is_said_with_the_next_one() {
        let (mut store, turn, begins) = slow();
        store.save(b"1").expect("no error yet");
        begins.recv().expect("begun");
        turn.send(false).expect("waits");
        let told = (0..1000).any(|_| {
            std::thread::sleep(Duration::from_millis(1));
            let failed = store.shared.lock().failed.is_some();
            failed && store.save(b"2").is_err()
        });
        assert!(told);
        drop(turn);
        assert_eq!(ended(&mut store).kept, None);
    }

    #[test]
    fn a_disk_that_hangs_keeps_nothing_any_more() {
        let (mut store, turn, begins) = slow();
        store.save(b"1").expect("no error yet");
        begins.recv().expect("begun");
        turn.send(true).expect("waits");
        store.save(b"2").expect("no error yet");
        begins.recv().expect("begun, so the first one is kept");
        assert!(store.is_noted());
        let long_ago = Instant::now().checked_sub(SLOW + Duration::from_secs(1));
        store.shared.lock().begun = long_ago;
        assert!(!store.is_noted());
        turn.send(true).expect("waits");
        ended(&mut store);
        assert!(store.is_noted());
    }

    #[test]
    fn a_disk_that_hangs_does_not_keep_the_program_from_ending() {
        let (mut store, turn, begins) = slow();
        store.save(b"1").expect("no error yet");
        begins.recv().expect("begun");
        let error = store.arrive(Ended::default()).expect_err("it hangs");
        assert_eq!(error.kind(), io::ErrorKind::TimedOut);
        drop(turn);
    }
}
