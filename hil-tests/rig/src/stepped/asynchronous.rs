//! The asynchronous thread on the simulated clock.

use onboard::activities::news::Alarm;
use onboard::activities::robot_activity::ThreadActivities;
use onboard::process::runner::Trigger;

/// The asynchronous thread: its loop runs on news, and with a period of its own.
pub(super) struct Asynchronous {
    activities: ThreadActivities,
    period_ns: u64,
    next_ns: u64,
    alarm: Alarm,
    woken: u32,
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
            period_ns: trigger.period_ns(),
            next_ns: now_ns,
            alarm: alarm.clone(),
            woken: alarm.wake.count(),
        }
    }

    pub(super) fn go_on(&mut self, now_ns: u64) {
        let count = self.alarm.wake.count();
        let woken = std::mem::replace(&mut self.woken, count) != count;
        let told = self.alarm.news.take().is_some() || woken;
        let ticked = now_ns >= self.next_ns;
        if ticked {
            // Periods that were missed are not made up for.
            self.next_ns = (self.next_ns + self.period_ns).max(now_ns);
        }
        if told || ticked {
            self.activities.step(|| now_ns);
        }
    }
}
