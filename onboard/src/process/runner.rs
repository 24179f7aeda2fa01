//! Runs the event loops of one thread's activities: trigger, measurement, real-time rules, panics.
//!
//! [`EventLoop`] is what also runs on a simulated clock; the rest needs a thread of the system.

use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use bytemuck::Zeroable;
use coordination::symbols::Writer;
use description::threads::{self, ThreadConfig};

use crate::activities::communication;
use crate::activities::robot_activity::ThreadActivities;
use crate::realtime::clock::{Clock, MILLISECOND_NS, Monotonic};
use crate::realtime::guard;
use crate::realtime::log::LogSender;
use crate::realtime::memory::{STACK_BYTES, page_faults, prefault_stack};
use crate::realtime::panic::Panicked;
use crate::realtime::scheduling::{Wanted, granted, promote};
use crate::realtime::system_calls;
use crate::realtime::wake::Wake;
use crate::symbols::values::ThreadReport;

/// How often a thread publishes its report.
const REPORT_PERIOD_NS: u64 = 100 * MILLISECOND_NS;
/// Cadence of the loop that remains after a panic.
const AFTER_PANIC_PERIOD_NS: u64 = MILLISECOND_NS;

/// What makes a thread's loop run.
#[derive(Clone, Debug)]
pub enum Trigger {
    /// Absolute times, this far apart.
    Period(u64),
    /// The activity's own device, on which it waits itself for a bounded time.
    Device,
    /// A wake-up, and at the latest after this many nanoseconds.
    Wake(Wake, u64),
}

impl Trigger {
    /// That of a thread of the robot file. `scan_wake` wakes those that wait for scans.
    #[must_use]
    pub fn of(thread: &ThreadConfig, scan_wake: &Wake) -> Self {
        let ns = |duration: Duration| u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX);
        match thread.trigger {
            threads::Trigger::Period { period } => Self::Period(ns(period)),
            threads::Trigger::Lidar => Self::Device,
            threads::Trigger::Scan { at_least } => Self::Wake(scan_wake.clone(), ns(at_least)),
            threads::Trigger::Async => Self::Period(ns(communication::PERIOD)),
        }
    }

    /// The longest time from one loop to the next; 0 where that is the device's.
    #[must_use]
    pub fn period_ns(&self) -> u64 {
        match self {
            Self::Period(period_ns) | Self::Wake(_, period_ns) => *period_ns,
            Self::Device => 0,
        }
    }
}

/// One thread, ready to be started.
#[derive(Debug)]
pub struct ThreadSetup {
    /// Its name.
    pub name: String,
    /// When it runs.
    pub trigger: Trigger,
    /// What it asks the scheduler for.
    pub wanted: Wanted,
    /// Where it publishes its timing.
    pub report: Writer<ThreadReport>,
    /// Ends the loop.
    pub stop: Arc<AtomicBool>,
    /// Takes its warnings.
    pub log: LogSender,
    /// Raised when it panics.
    pub panicked: Panicked,
}

impl ThreadSetup {
    /// Starts the thread with its activities.
    ///
    /// # Errors
    /// The operating system's, when it has no thread to give.
    pub fn spawn(self, activities: ThreadActivities) -> std::io::Result<JoinHandle<()>> {
        let name = self.name.clone();
        Builder::new()
            .name(name)
            .stack_size(STACK_BYTES)
            .spawn(move || run(self, activities))
    }
}

fn run(setup: ThreadSetup, activities: ThreadActivities) {
    prefault_stack();
    for warning in promote(&setup.wanted) {
        setup.log.warn(format!("thread {}: {warning}", setup.name));
    }
    if setup.wanted.fifo_priority.is_some()
        && system_calls::wanted()
        && let Err(error) = system_calls::guard_this_thread(&setup.name)
    {
        let text = format!(
            "thread {}: its system calls are not guarded: {error}",
            setup.name
        );
        setup.log.warn(text);
    }
    let clock: Arc<dyn Clock> = Arc::new(Monotonic);
    let mut event_loop = EventLoop::new(setup.trigger, activities, setup.report, clock);
    event_loop.run(|| !setup.stop.load(Ordering::Relaxed), &setup.panicked);
    event_loop.end();
}

/// The event loops of one thread's activities: what a thread of the system runs, and what runs on a simulated clock.
pub struct EventLoop {
    trigger: Trigger,
    activities: ThreadActivities,
    report: Writer<ThreadReport>,
    timing: Timing,
    clock: Arc<dyn Clock>,
}

impl EventLoop {
    /// Nothing has run yet. To be made by the thread itself, once it is promoted.
    #[must_use]
    pub fn new(
        trigger: Trigger,
        activities: ThreadActivities,
        report: Writer<ThreadReport>,
        clock: Arc<dyn Clock>,
    ) -> Self {
        Self {
            timing: Timing::new(&trigger, clock.now_ns()),
            trigger,
            activities,
            report,
            clock,
        }
    }

    /// Runs for as long as it `goes_on`. After a panic, in an activity or in that question, only what stops the robot is still done.
    pub fn run(&mut self, mut goes_on: impl FnMut() -> bool, panicked: &Panicked) {
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            while goes_on() {
                self.cycle();
            }
        }));
        if outcome.is_err() {
            // The hook of a process has raised it already; without one nobody has.
            panicked.raise();
            self.finish_after_panic(goes_on);
        }
    }

    /// The drive ramps to a stop.
    fn finish_after_panic(&mut self, mut goes_on: impl FnMut() -> bool) {
        let clock = self.clock.as_ref();
        let mut next_ns = clock.now_ns();
        let mut finished = false;
        while !finished && goes_on() {
            next_ns += AFTER_PANIC_PERIOD_NS;
            clock.sleep_until(next_ns);
            finished = self.activities.after_panic(clock.now_ns());
        }
    }

    /// Waits for the trigger, runs every activity's event loop once, and measures that.
    pub fn cycle(&mut self) {
        let clock = self.clock.as_ref();
        guard::real_time_if(self.activities.running(), || {
            self.timing.wait(&self.trigger, clock);
        });
        let running = self.activities.running();
        let begin_ns = clock.now_ns();
        self.timing.runs(running, &mut self.report, begin_ns);
        guard::real_time_if(running, || self.activities.step(|| clock.now_ns()));
        let span_ns = begin_ns..clock.now_ns();
        let measured = running && self.activities.running();
        self.timing
            .executed(span_ns.clone(), self.activities.waited_ns(), measured);
        self.timing.publish(&mut self.report, span_ns.end);
    }

    /// Publishes the last report.
    pub fn end(&mut self) {
        self.timing
            .publish_now(&mut self.report, self.clock.now_ns());
    }
}

/// Plans and measures the cycles of one thread.
#[derive(Debug)]
pub struct Timing {
    report: ThreadReport,
    planned_ns: u64,
    seen: u32,
    wakeup_ns: u64,
    published_ns: u64,
}

impl Timing {
    /// Nothing was measured yet at `now_ns`. To be made by the thread itself, once it is promoted.
    #[must_use]
    pub fn new(trigger: &Trigger, now_ns: u64) -> Self {
        let mut report = ThreadReport::zeroed();
        report.granted = granted();
        report.thread = rustix::thread::gettid().as_raw_nonzero().get() as u64;
        report.period_ns = trigger.period_ns();
        Self {
            report,
            planned_ns: now_ns,
            seen: 0,
            wakeup_ns: 0,
            published_ns: 0,
        }
    }

    fn wait(&mut self, trigger: &Trigger, clock: &dyn Clock) {
        match trigger {
            Trigger::Period(period_ns) => {
                self.planned_ns += period_ns;
                clock.sleep_until(self.planned_ns);
                self.wakeup_ns = clock.now_ns() - self.planned_ns;
            }
            Trigger::Wake(wake, at_least_ns) => {
                self.planned_ns = clock.now_ns() + at_least_ns;
                let seen = wake.wait_beyond(clock, self.seen, self.planned_ns);
                let since_ns = if seen == self.seen {
                    self.planned_ns
                } else {
                    wake.woken_at_ns()
                };
                self.seen = seen;
                self.wakeup_ns = clock.now_ns().saturating_sub(since_ns);
                // From there on it has one period.
                self.planned_ns = since_ns;
            }
            Trigger::Device => self.wakeup_ns = 0,
        }
    }

    /// Whether the cycle that begins drives the robot. Who watches knows before it can hang.
    pub fn runs(&mut self, running: bool, writer: &mut Writer<ThreadReport>, now_ns: u64) {
        if self.report.running != u64::from(running) {
            self.report.running = u64::from(running);
            self.report.faults_before = page_faults();
            self.publish_now(writer, now_ns);
        }
    }

    /// A wake-up that was planned for `planned_ns` and came `late_ns` later.
    pub fn woken(&mut self, planned_ns: u64, late_ns: u64) {
        (self.planned_ns, self.wakeup_ns) = (planned_ns, late_ns);
    }

    /// A cycle of this span has ended; it counts when `measured`.
    pub fn executed(&mut self, span_ns: Range<u64>, waited_ns: u64, measured: bool) {
        let (begin_ns, end_ns) = (span_ns.start, span_ns.end);
        let period_ns = self.report.period_ns;
        let late_ns = end_ns.saturating_sub(self.planned_ns);
        let late_cycles = late_ns.checked_div(period_ns).unwrap_or(0);
        if late_cycles > 0 {
            // What was missed is skipped, not made up for: stale cycles move nothing.
            self.planned_ns += late_cycles * period_ns;
        }
        self.report.cycles += 1;
        if measured {
            self.report.overruns += u64::from(late_cycles > 0);
            self.report.missed += late_cycles;
            self.report
                .exec
                .record((end_ns - begin_ns).saturating_sub(waited_ns));
            if period_ns > 0 {
                self.report.wakeup.record(self.wakeup_ns);
            }
        }
    }

    /// Publishes the report when it is time to.
    pub fn publish(&mut self, writer: &mut Writer<ThreadReport>, now_ns: u64) {
        if now_ns >= self.published_ns + REPORT_PERIOD_NS {
            self.publish_now(writer, now_ns);
        }
    }

    /// Publishes the report.
    pub fn publish_now(&mut self, writer: &mut Writer<ThreadReport>, now_ns: u64) {
        self.published_ns = now_ns;
        writer.write(self.published_ns, &self.report);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicU64;

    use coordination::activity::{Activity, LifeCycle, LifeCycleEvent};

    use super::*;
    use crate::activities::robot_activity::RobotActivity;
    use crate::process::bench::{Bench, wait_for};

    /// Counts its turns, panics when told to, and then needs three steps to come to rest.
    struct Fragile {
        life_cycle: LifeCycle,
        turns: Arc<AtomicU64>,
        panics_at: u64,
        steps_after: Arc<AtomicU64>,
    }

    impl Activity for Fragile {
        fn name(&self) -> &'static str {
            "fragile"
        }

        fn life_cycle(&self) -> &LifeCycle {
            &self.life_cycle
        }

        fn compute(&mut self, _now_ns: u64) {
            let turns = self.turns.fetch_add(1, Ordering::Relaxed) + 1;
            assert!(turns < self.panics_at, "told to panic");
        }
    }

    impl RobotActivity for Fragile {
        fn after_panic(&mut self, _now_ns: u64) -> bool {
            self.steps_after.fetch_add(1, Ordering::Relaxed) + 1 == 3
        }
    }

    /// A fragile activity on a thread of its own.
    struct Scene {
        bench: Bench,
        thread: JoinHandle<()>,
        turns: Arc<AtomicU64>,
        steps_after: Arc<AtomicU64>,
    }

    fn start(panics_at: u64) -> Scene {
        let (bench, setup) = Bench::with_thread(Trigger::Period(MILLISECOND_NS));
        let (turns, steps_after) = (Arc::default(), Arc::default());
        let mut life_cycle = LifeCycle::new();
        for event in [
            LifeCycleEvent::Configure,
            LifeCycleEvent::Configured,
            LifeCycleEvent::Run,
        ] {
            life_cycle.step(event);
        }
        let activity = Fragile {
            life_cycle,
            turns: Arc::clone(&turns),
            panics_at,
            steps_after: Arc::clone(&steps_after),
        };
        let activities = ThreadActivities::new(vec![Box::new(activity)], None);
        Scene {
            bench,
            thread: setup.spawn(activities).expect("a thread"),
            turns,
            steps_after,
        }
    }

    #[test]
    fn a_loop_runs_until_it_is_stopped_and_reports_its_timing() {
        let mut scene = start(u64::MAX);
        wait_for(|| scene.turns.load(Ordering::Relaxed) > 20);
        scene.bench.stop.store(true, Ordering::Relaxed);
        scene.thread.join().expect("ends");
        let report = scene.bench.report.read().value;
        assert_eq!(report.cycles, scene.turns.load(Ordering::Relaxed));
        assert_eq!(
            (report.period_ns, report.exec.count()),
            (MILLISECOND_NS, report.cycles)
        );
        assert_eq!(scene.steps_after.load(Ordering::Relaxed), 0);
    }

    #[test]
    fn after_a_panic_the_activity_is_brought_to_rest_and_the_thread_ends() {
        let scene = start(3);
        scene.thread.join().expect("the panic is caught");
        assert_eq!(scene.turns.load(Ordering::Relaxed), 3);
        assert_eq!(
            scene.steps_after.load(Ordering::Relaxed),
            3,
            "until it said that it is at rest"
        );
    }
}
