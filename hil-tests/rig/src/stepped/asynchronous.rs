//! The asynchronous thread on the simulated clock.

use onboard::activities::news::Alarm;
use onboard::activities::robot_activity::ThreadActivities;
use onboard::process::asynchronous::loop_period_ns;
use onboard::process::runner::Trigger;
use onboard::process::wakes::{Passing, Wakes};

/// The asynchronous thread: its loop runs on news, and with a period of its own.
pub(super) struct Asynchronous {
    activities: ThreadActivities,
    wakes: Wakes,
    passing: Passing,
    alarm: Alarm,
}

impl Asynchronous {
    pub(super) fn new(
        activities: ThreadActivities,
        trigger: &Trigger,
        alarm: &Alarm,
        now_ns: u64,
    ) -> Self {
        Self {
            activities,
            wakes: Wakes::new(loop_period_ns(trigger), now_ns),
            passing: Passing::new(&alarm.wake),
            alarm: alarm.clone(),
        }
    }

    pub(super) fn go_on(&mut self, now_ns: u64) {
        if self.passing.look(self.alarm.wake.count()) {
            self.alarm.news.tell();
        }
        if self.wakes.look(now_ns, self.alarm.news.take()).is_some() {
            self.activities.step(|| now_ns);
        }
    }
}
