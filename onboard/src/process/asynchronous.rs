//! The thread of the communication activity: the 5C loop on a tokio runtime with one worker.
//!
//! The loop runs with its period, and at once when there is [`News`], or when a real-time thread has used [`Alarm::wake`],
//! which a thread of our own passes on: waking tokio takes a lock. [`AsynchronousLoop`] is what also runs on a simulated clock.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use coordination::symbols::Writer;
use tokio::time::sleep;

use crate::activities::news::{Alarm, News};
use crate::activities::robot_activity::ThreadActivities;
use crate::process::runner::{ThreadSetup, Timing, Trigger};
use crate::process::wakes::{Passing, Wakes};
use crate::realtime::clock::{MILLISECOND_NS, Monotonic, now_ns};
use crate::realtime::memory::STACK_BYTES;
use crate::realtime::scheduling::promote;
use crate::symbols::values::ThreadReport;

/// How soon the thread that passes wake-ups on notices the end.
const GLANCE_NS: u64 = 100 * MILLISECOND_NS;
/// The loop's period where its trigger has none.
const PERIOD_NS: u64 = 50 * MILLISECOND_NS;

/// Starts the thread. zenoh refuses tokio's current-thread scheduler, so there is one worker beside it.
///
/// # Errors
/// The operating system's.
pub fn spawn_asynchronous(
    setup: ThreadSetup,
    activities: ThreadActivities,
    alarm: Alarm,
) -> std::io::Result<JoinHandle<()>> {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .thread_name(format!("{}-tokio", setup.name))
        .thread_stack_size(STACK_BYTES)
        .enable_all()
        .build()?;
    let passing = pass_on(&setup, &alarm)?;
    let thread = Builder::new().name(setup.name.clone());
    thread.stack_size(STACK_BYTES).spawn(move || {
        for warning in promote(&setup.wanted) {
            setup.log.warn(format!("thread {}: {warning}", setup.name));
        }
        runtime.block_on(run(setup, activities, &alarm.news));
        // A connection that hangs does not keep the robot's process alive.
        runtime.shutdown_timeout(Duration::from_secs(1));
        // It only sleeps and looks at the flag that has ended this loop.
        let _ = passing.join();
    })
}

/// Turns wake-ups into news, on a thread of its own.
fn pass_on(setup: &ThreadSetup, alarm: &Alarm) -> std::io::Result<JoinHandle<()>> {
    let (stop, Alarm { news, wake }) = (Arc::clone(&setup.stop), alarm.clone());
    let name = format!("{}-wake", setup.name);
    // Counted here: a wake-up before the thread's first moment is passed on too.
    let mut passing = Passing::new(&wake);
    let thread = Builder::new().name(name).stack_size(STACK_BYTES);
    thread.spawn(move || {
        while !stop.load(Ordering::Relaxed) {
            let count = wake.wait_beyond(&Monotonic, passing.seen(), now_ns() + GLANCE_NS);
            if passing.look(count) {
                news.tell();
            }
        }
    })
}

/// The period of the loop with this trigger.
fn loop_period_ns(trigger: &Trigger) -> u64 {
    match trigger {
        Trigger::Period(period_ns) => *period_ns,
        Trigger::Device | Trigger::Wake(..) => PERIOD_NS,
    }
}

/// The loop without its thread: when it runs, and what its supervisor sees of it.
pub struct AsynchronousLoop {
    activities: ThreadActivities,
    report: Writer<ThreadReport>,
    timing: Timing,
    wakes: Wakes,
}

impl AsynchronousLoop {
    /// Nothing has run yet; the first tick is at `now_ns`.
    #[must_use]
    pub fn new(
        trigger: &Trigger,
        activities: ThreadActivities,
        report: Writer<ThreadReport>,
        now_ns: u64,
    ) -> Self {
        Self {
            activities,
            report,
            timing: Timing::new(trigger, now_ns),
            wakes: Wakes::new(loop_period_ns(trigger), now_ns),
        }
    }

    /// When the next tick is.
    #[must_use]
    pub fn tick_ns(&self) -> u64 {
        self.wakes.tick_ns()
    }

    /// Whether a turn is to be made now, as [`Wakes::look`] says; since when.
    #[must_use]
    pub fn due_ns(&mut self, now_ns: u64, told_ns: Option<u64>) -> Option<u64> {
        let due = self.wakes.look(now_ns, told_ns)?;
        Some(now_ns.saturating_sub(due.late_ns))
    }

    /// Runs every activity's event loop once, which was to be done at `due_ns`, and measures that.
    pub fn turn(&mut self, due_ns: u64, now_ns: impl Fn() -> u64) {
        let begin_ns = now_ns();
        self.timing.woken(due_ns, begin_ns.saturating_sub(due_ns));
        self.timing
            .runs(self.activities.running(), &mut self.report, begin_ns);
        self.activities.step(&now_ns);
        self.timing.executed(begin_ns..now_ns(), 0, true);
        self.timing.publish(&mut self.report, now_ns());
    }

    /// Publishes the last report.
    pub fn end(&mut self, now_ns: u64) {
        self.timing.publish_now(&mut self.report, now_ns);
    }
}

async fn run(setup: ThreadSetup, activities: ThreadActivities, news: &News) {
    let mut own = AsynchronousLoop::new(&setup.trigger, activities, setup.report, now_ns());
    let stop = setup.stop;
    while !stop.load(Ordering::Relaxed) {
        let until_tick = Duration::from_nanos(own.tick_ns().saturating_sub(now_ns()));
        tokio::select! {
            () = sleep(until_tick) => {}
            () = news.wait() => {}
        }
        if let Some(due_ns) = own.due_ns(now_ns(), news.take()) {
            own.turn(due_ns, now_ns);
        }
    }
    own.end(now_ns());
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicU64;

    use coordination::activity::{Activity, LifeCycle};

    use super::*;
    use crate::activities::robot_activity::RobotActivity;
    use crate::process::bench::{Bench, wait_for};
    use crate::realtime::clock::SECOND_NS;

    /// Counts its turns.
    struct Counter(LifeCycle, Arc<AtomicU64>);

    impl Activity for Counter {
        fn name(&self) -> &'static str {
            "counter"
        }

        fn life_cycle(&self) -> &LifeCycle {
            &self.0
        }

        fn rest(&mut self, _now_ns: u64) {
            self.1.fetch_add(1, Ordering::Relaxed);
        }
    }

    impl RobotActivity for Counter {}

    #[test]
    fn a_wake_up_before_the_passing_thread_runs_is_not_lost() {
        let (bench, setup) = Bench::with_thread(Trigger::Period(SECOND_NS));
        let passing: Vec<_> = (0..20)
            .map(|_| {
                let alarm = Alarm::default();
                let thread = pass_on(&setup, &alarm).expect("a thread");
                alarm.wake.wake(now_ns());
                (alarm, thread)
            })
            .collect();
        for (alarm, _) in &passing {
            wait_for(|| alarm.news.take().is_some());
        }
        bench.stop.store(true, Ordering::Relaxed);
        for (_, thread) in passing {
            thread.join().expect("ends");
        }
    }

    #[test]
    fn news_and_wake_ups_make_the_loop_run_long_before_its_period() {
        let (bench, setup) = Bench::with_thread(Trigger::Period(3600 * SECOND_NS));
        let turns = Arc::<AtomicU64>::default();
        let counter = Counter(LifeCycle::new(), Arc::clone(&turns));
        let alarm = Alarm::default();
        let activities = ThreadActivities::new(vec![Box::new(counter)], None);
        let thread = spawn_asynchronous(setup, activities, alarm.clone()).expect("a thread");
        let reaches = |wanted: u64| wait_for(|| turns.load(Ordering::Relaxed) >= wanted);
        // The first tick is at once.
        reaches(1);
        alarm.news.tell();
        reaches(2);
        alarm.wake.wake(now_ns());
        reaches(3);
        bench.stop.store(true, Ordering::Relaxed);
        alarm.news.tell();
        thread.join().expect("ends");
    }
}
