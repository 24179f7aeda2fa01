//! What a thread asks of an activity beyond its event loop, and the activities of one thread in their order.

use std::panic::{AssertUnwindSafe, catch_unwind};

use coordination::activity::{Activity, LifeCycleState, event_loop_once};

use super::scans::ScanIntake;

/// An activity as a thread runs it.
pub trait RobotActivity: Activity {
    /// Where the thread puts its scan intake for the time of an event loop; `None` in an activity that looks at no scans.
    fn scans(&mut self) -> Option<&mut Option<Box<ScanIntake>>> {
        None
    }

    /// Time that the last event loop spent waiting for its device, to be left out of the execution time.
    fn waited_ns(&self) -> u64 {
        0
    }

    /// One step of what must still be done after a panic in this thread; returns whether that is finished.
    fn after_panic(&mut self, _now_ns: u64) -> bool {
        true
    }
}

/// The activities of one thread, in the order in which they run, and the scan intake that they share.
pub struct ThreadActivities {
    activities: Vec<Box<dyn RobotActivity>>,
    scans: Option<Box<ScanIntake>>,
}

impl ThreadActivities {
    /// `scans` is for those of the activities that look at scans.
    #[must_use]
    pub fn new(activities: Vec<Box<dyn RobotActivity>>, scans: Option<Box<ScanIntake>>) -> Self {
        Self { activities, scans }
    }

    /// One turn of each activity's event loop, which begins at the `now_ns` of that moment. The scan is read and aligned
    /// before them, once for all. Does not allocate unless an activity does.
    pub fn step(&mut self, now_ns: impl Fn() -> u64) {
        if let Some(scans) = &mut self.scans {
            scans.look();
        }
        for activity in &mut self.activities {
            exchange(activity.as_mut(), &mut self.scans);
            event_loop_once(activity.as_mut(), now_ns());
            exchange(activity.as_mut(), &mut self.scans);
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.activities.is_empty()
    }

    /// Whether all are in state *running*.
    #[must_use]
    pub fn running(&self) -> bool {
        { self.activities.iter() }
            .all(|activity| activity.life_cycle().state() == LifeCycleState::Running)
    }

    /// Time that the last turns spent waiting for their devices.
    #[must_use]
    pub fn waited_ns(&self) -> u64 {
        { self.activities.iter() }
            .map(|activity| activity.waited_ns())
            .sum()
    }

    /// One step of what must still be done after a panic in this thread; returns whether that is finished.
    pub fn after_panic(&mut self, now_ns: u64) -> bool {
        self.activities.iter_mut().all(|activity| {
            // A panic in here too leaves the stop to the drive's own watchdog.
            catch_unwind(AssertUnwindSafe(|| activity.after_panic(now_ns))).unwrap_or(true)
        })
    }
}

/// Hands the scan intake to an activity that looks at scans, or takes it back.
fn exchange(activity: &mut dyn RobotActivity, scans: &mut Option<Box<ScanIntake>>) {
    if let Some(slot) = activity.scans() {
        std::mem::swap(slot, scans);
    }
}
