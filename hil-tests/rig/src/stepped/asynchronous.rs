//! The asynchronous thread on the simulated clock.

use onboard::activities::news::Alarm;
use onboard::activities::robot_activity::ThreadActivities;
use onboard::process::asynchronous::loop_period_ns;
use onboard::process::runner::Trigger;
use onboard::process::wakes::{Passing, Wakes};

use super::faults::Lateness;
use super::late::Late;

/// The asynchronous thread: its loop runs on news, and with a period of its own.
pub(super) struct Asynchronous {
    activities: ThreadActivities,
    wakes: Wakes,
    passing: Passing,
    alarm: Alarm,
    late: Late,
}

impl Asynchronous {
    pub(super) fn new(
        activities: ThreadActivities,
        trigger: &Trigger,
        (alarm, late): (&Alarm, Late),
        now_ns: u64,
    ) -> Self {
        Self {
            activities,
            wakes: Wakes::new(loop_period_ns(trigger), now_ns),
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
        let due = self.wakes.look(now_ns, self.alarm.news.take());
        if self.late.runs(due.is_some(), late, now_ns) {
            self.activities.step(|| now_ns);
        }
    }
}
