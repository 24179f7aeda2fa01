//! The asynchronous thread on the simulated clock.

use coordination::symbols::Writer;
use onboard::activities::news::Alarm;
use onboard::activities::robot_activity::ThreadActivities;
use onboard::process::asynchronous::AsynchronousLoop;
use onboard::process::runner::Trigger;
use onboard::process::wakes::Passing;
use onboard::symbols::values::ThreadReport;

use super::late::Late;
use super::late::Lateness;

/// The asynchronous thread: its loop runs on news, and with a period of its own.
pub(super) struct Asynchronous {
    own: AsynchronousLoop,
    /// Since when the turn is due that it makes next.
    due_ns: Option<u64>,
    passing: Passing,
    alarm: Alarm,
    late: Late,
}

impl Asynchronous {
    pub(super) fn new(
        (activities, report): (ThreadActivities, Writer<ThreadReport>),
        trigger: &Trigger,
        (alarm, late): (&Alarm, Late),
        now_ns: u64,
    ) -> Self {
        Self {
            own: AsynchronousLoop::new(trigger, activities, report, now_ns),
            due_ns: None,
            passing: Passing::new(&alarm.wake),
            alarm: alarm.clone(),
            late,
        }
    }

    /// Runs its loop when that is due; `late`: how the robot's threads are late, and its name.
    pub(super) fn go_on(&mut self, late: (&[Lateness], &str), now_ns: u64) {
        if self.passing.look(self.alarm.wake.count()) {
            self.alarm.news.tell();
        }
        // Looked at in each step; the kernel's time, which the news has, is none of this clock's.
        let told_ns = self.alarm.news.take().map(|_| now_ns);
        let due_ns = self.own.due_ns(now_ns, told_ns);
        // What is due again before it has run is one with that.
        self.due_ns = self.due_ns.or(due_ns);
        if self.late.runs(due_ns.is_some(), late, now_ns)
            && let Some(due_ns) = self.due_ns.take()
        {
            self.own.turn(due_ns, || now_ns);
        }
    }
}
