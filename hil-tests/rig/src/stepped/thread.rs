//! Threads on the simulated clock: coroutines, each with a clock of its own, which run until they wait.
//!
//! Time passes in steps. In each, every thread whose wait ends within the step goes on, in its own time, until it waits for
//! something beyond the step's end; computing takes no time.

use std::cell::Cell;
use std::ptr::NonNull;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use corosensei::{Coroutine, CoroutineResult, Yielder};
use drivers::Clock;

use super::work::while_it_waits;

/// How often a thread that looks in every step is asked how late it is.
const ASK_NS: u64 = 10_000_000;

/// What a thread waits for.
#[derive(Clone, Copy, Debug)]
enum Wait {
    /// A time.
    Until(u64),
    /// Something that another thread or a device does: it looks in every step.
    Look,
}

type Suspender = Yielder<(), Wait>;

thread_local! {
    /// The coroutine that runs now.
    static RUNNING: Cell<Option<NonNull<Suspender>>> = const { Cell::new(None) };
}

/// Suspends the coroutine that runs now. False outside of one, and in one that is being dropped: there nothing waits.
fn suspend(wait: Wait) -> bool {
    let Some(suspender) = RUNNING.get() else {
        return false;
    };
    // SAFETY: `Thread::go_on` sets it to the yielder of the coroutine that it resumes, and takes it away when that one is
    // suspended or has ended: the yielder lives on the stack that runs here.
    while_it_waits(|| unsafe { suspender.as_ref() }.suspend(wait));
    true
}

/// Whether what asks is a thread that runs, and none that is being dropped.
pub(super) fn runs() -> bool {
    RUNNING.get().is_some()
}

/// The clock of a thread.
#[derive(Debug)]
pub(super) struct ThreadClock {
    now_ns: AtomicU64,
    step_end_ns: AtomicU64,
    /// How far the world's clock is ahead of this one; wraps.
    world_ahead_ns: AtomicU64,
}

/// A step of a thread.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// From here,
    pub(super) begin_ns: u64,
    /// to before here, by the thread's clock.
    pub(super) end_ns: u64,
    /// When it begins by the world's.
    pub(super) world_ns: u64,
}

impl ThreadClock {
    pub(super) fn new(now_ns: u64) -> Self {
        Self {
            now_ns: AtomicU64::new(now_ns),
            step_end_ns: AtomicU64::new(now_ns),
            world_ahead_ns: AtomicU64::new(0),
        }
    }

    /// What time it is in the world.
    pub(super) fn world_ns(&self) -> u64 {
        let ahead_ns = self.world_ahead_ns.load(Ordering::Relaxed);
        self.now_ns().wrapping_add(ahead_ns)
    }

    /// Sleeps until a time of the world, or of its own.
    pub(super) fn sleep_until_world(&self, world_ns: Option<u64>, at_ns: u64) {
        let ahead_ns = self.world_ahead_ns.load(Ordering::Relaxed);
        let own_ns = world_ns.map_or(at_ns, |world_ns| world_ns.wrapping_sub(ahead_ns));
        self.sleep_until(own_ns.min(at_ns));
    }

    /// Waits for a device that says nothing of when it will have something: until the next step, `until_ns` at the latest.
    pub(super) fn wait_a_step(&self, until_ns: u64) {
        let within_step = until_ns < self.step_end_ns.load(Ordering::Relaxed);
        if within_step || !suspend(Wait::Look) {
            self.catch_up(until_ns);
        }
    }

    fn catch_up(&self, at_ns: u64) {
        self.now_ns.fetch_max(at_ns, Ordering::Relaxed);
    }
}

impl Clock for ThreadClock {
    fn now_ns(&self) -> u64 {
        self.now_ns.load(Ordering::Relaxed)
    }

    fn sleep_until(&self, at_ns: u64) {
        if at_ns >= self.step_end_ns.load(Ordering::Relaxed) {
            suspend(Wait::Until(at_ns));
        }
        self.catch_up(at_ns);
    }

    fn wait_on(&self, word: &AtomicU32, seen: u32, until_ns: u64) {
        // Nothing else runs meanwhile: within a step the word does not change.
        if word.load(Ordering::Acquire) == seen && self.now_ns() < until_ns {
            self.wait_a_step(until_ns);
        }
    }
}

/// No coroutine runs any more, also when what ran has panicked.
struct Resumed;

impl Drop for Resumed {
    fn drop(&mut self) {
        RUNNING.set(None);
    }
}

/// A thread.
pub(super) struct Thread {
    coroutine: Coroutine<(), Wait, ()>,
    suspender: Rc<Cell<Option<NonNull<Suspender>>>>,
    clock: Arc<ThreadClock>,
    wait: Wait,
    /// It is late, and goes on then.
    held_until_ns: Option<u64>,
    /// When it was last asked how late it is, while it looked in every step.
    asked_ns: u64,
}

impl Thread {
    /// A thread that will run `body` when its clock's time has come.
    pub(super) fn new(clock: Arc<ThreadClock>, body: impl FnOnce() + 'static) -> Self {
        let suspender = Rc::<Cell<Option<NonNull<Suspender>>>>::default();
        let own = Rc::clone(&suspender);
        let coroutine = Coroutine::new(move |yielder: &Suspender, ()| {
            own.set(Some(NonNull::from(yielder)));
            RUNNING.set(own.get());
            body();
        });
        Self {
            coroutine,
            suspender,
            wait: Wait::Until(clock.now_ns()),
            clock,
            held_until_ns: None,
            asked_ns: 0,
        }
    }

    /// Lets it go on through a step, if its wait ends there. `late_ns` says how late it is when it wakes up.
    pub(super) fn go_on(&mut self, step: Step, late_ns: impl FnOnce() -> u64) {
        let Step {
            begin_ns,
            end_ns,
            world_ns,
        } = step;
        if matches!(self.wait, Wait::Until(at_ns) if at_ns >= end_ns) || self.coroutine.done() {
            return;
        }
        let held_until_ns = self.held_until_ns.unwrap_or_else(|| {
            let looks = matches!(self.wait, Wait::Look);
            if looks && begin_ns < self.asked_ns + ASK_NS {
                return 0;
            }
            self.asked_ns = begin_ns;
            match late_ns() {
                0 => 0,
                late_ns => begin_ns + late_ns,
            }
        });
        self.held_until_ns = (held_until_ns >= end_ns).then_some(held_until_ns);
        if self.held_until_ns.is_some() {
            return;
        }
        let clock = &self.clock;
        clock.catch_up(begin_ns.max(held_until_ns));
        clock.step_end_ns.store(end_ns, Ordering::Relaxed);
        let ahead_ns = world_ns.wrapping_sub(begin_ns);
        clock.world_ahead_ns.store(ahead_ns, Ordering::Relaxed);
        RUNNING.set(self.suspender.get());
        let resumed = Resumed;
        let result = self.coroutine.resume(());
        drop(resumed);
        if let CoroutineResult::Yield(wait) = result {
            self.wait = wait;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    const MS: u64 = 1_000_000;

    /// Runs a thread through steps of a millisecond, from 10 ms on.
    fn run(thread: &mut Thread, steps: u64) {
        for at in 10..10 + steps {
            thread.go_on(step(at), || 0);
        }
    }

    /// A step of a millisecond, which begins at this one.
    fn step(at: u64) -> Step {
        Step {
            begin_ns: at * MS,
            end_ns: (at + 1) * MS,
            world_ns: at * MS,
        }
    }

    #[test]
    fn a_thread_sleeps_exactly_as_long_as_it_asks_for() {
        let clock = Arc::new(ThreadClock::new(10 * MS));
        let woken = Rc::<RefCell<Vec<u64>>>::default();
        let (own, seen) = (Arc::clone(&clock), Rc::clone(&woken));
        let mut thread = Thread::new(clock, move || {
            for at_ns in [10 * MS + 300, 0, 12 * MS, 12 * MS + 5, 14 * MS + 999_999] {
                own.sleep_until(at_ns);
                seen.borrow_mut().push(own.now_ns());
            }
        });
        run(&mut thread, 3);
        assert_eq!(
            *woken.borrow(),
            [10 * MS + 300, 10 * MS + 300, 12 * MS, 12 * MS + 5]
        );
        run(&mut thread, 10);
        assert_eq!(woken.borrow().last(), Some(&(14 * MS + 999_999)));
    }

    #[test]
    fn a_thread_that_waits_on_a_word_sees_it_change_or_its_deadline() {
        let clock = Arc::new(ThreadClock::new(10 * MS));
        let word = Arc::new(AtomicU32::new(0));
        let woken = Rc::<RefCell<Vec<u64>>>::default();
        let (own, seen, watched) = (Arc::clone(&clock), Rc::clone(&woken), Arc::clone(&word));
        let mut thread = Thread::new(clock, move || {
            for until_ns in [15 * MS, 17 * MS + 5] {
                while watched.load(Ordering::Relaxed) == 0 && own.now_ns() < until_ns {
                    own.wait_on(&watched, 0, until_ns);
                }
                seen.borrow_mut().push(own.now_ns());
                watched.store(0, Ordering::Relaxed);
            }
        });
        thread.go_on(step(10), || 0);
        word.store(1, Ordering::Relaxed);
        thread.go_on(step(11), || 0);
        assert_eq!(*woken.borrow(), [11 * MS]);
        for at in 12..20 {
            thread.go_on(step(at), || 0);
        }
        assert_eq!(*woken.borrow(), [11 * MS, 17 * MS + 5]);
    }

    #[test]
    fn a_thread_that_is_dropped_while_it_waits_gives_back_what_it_holds() {
        struct Sleeper(Arc<ThreadClock>, Rc<Cell<bool>>);
        impl Drop for Sleeper {
            fn drop(&mut self) {
                self.0.sleep_until(u64::MAX);
                self.1.set(true);
            }
        }
        let clock = Arc::new(ThreadClock::new(0));
        let dropped = Rc::<Cell<bool>>::default();
        let sleeper = Sleeper(Arc::clone(&clock), Rc::clone(&dropped));
        let mut thread = Thread::new(clock, move || sleeper.0.sleep_until(9 * MS));
        thread.go_on(step(0), || 0);
        drop(thread);
        assert!(dropped.get());
    }

    #[test]
    fn a_late_thread_wakes_up_late_and_a_clock_may_differ_from_the_worlds() {
        let clock = Arc::new(ThreadClock::new(10 * MS));
        let woken = Rc::<RefCell<Vec<(u64, u64)>>>::default();
        let (own, seen) = (Arc::clone(&clock), Rc::clone(&woken));
        let mut thread = Thread::new(clock, move || {
            for at_ms in 11..14 {
                own.sleep_until(at_ms * MS);
                seen.borrow_mut().push((own.now_ns(), own.world_ns()));
            }
        });
        for at in 10..20 {
            let late_ns = if at == 11 { 3 * MS + 7 } else { 0 };
            let ahead = Step {
                world_ns: (at + 100) * MS,
                ..step(at)
            };
            thread.go_on(ahead, || late_ns);
        }
        let late = (14 * MS + 7, 114 * MS + 7);
        assert_eq!(*woken.borrow(), [late, late, late]);
    }

    #[test]
    fn a_panic_in_a_thread_is_the_steps_own_and_nothing_runs_afterwards() {
        let clock = Arc::new(ThreadClock::new(0));
        let mut thread = Thread::new(clock, || panic!("in a thread"));
        let stepped = std::panic::AssertUnwindSafe(|| thread.go_on(step(0), || 0));
        let panic = std::panic::catch_unwind(stepped).expect_err("it panics");
        assert_eq!(panic.downcast_ref(), Some(&"in a thread"));
        assert!(!runs());
    }
}
