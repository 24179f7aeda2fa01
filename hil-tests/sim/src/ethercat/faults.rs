//! Faults that happen on real buses, injected while the segment runs.
//!
//! A [`FaultHandle`] can be cloned and used from any thread. Requests take effect with the next frame, or within a few
//! milliseconds when there is none; durations count from then.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use super::al::{AlCode, AlState};

/// Most actions that may wait for the segment; further ones are dropped.
const MAX_WAITING: usize = 1024;

/// Injects faults into one segment.
#[derive(Debug, Clone, Default)]
pub struct FaultHandle(Arc<Mutex<Faults>>);

/// A condition that holds for a time.
#[derive(Debug, Clone, Copy, Default)]
enum Window {
    #[default]
    Closed,
    Requested(Duration),
    Until(u64),
}

impl Window {
    fn is_open(&mut self, now_ns: u64) -> bool {
        match *self {
            Window::Closed => false,
            Window::Requested(duration) => {
                let ns = u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX);
                *self = Window::Until(now_ns.saturating_add(ns));
                ns > 0
            }
            Window::Until(end_ns) if now_ns < end_ns => true,
            Window::Until(_) => {
                *self = Window::Closed;
                false
            }
        }
    }
}

#[derive(Debug, Default)]
struct Faults {
    losing: Window,
    withholding: Window,
    lose: u32,
    lose_replies: u32,
    delay: (u32, Duration),
    duplicate: u32,
    corrupt: u32,
    foreign: u32,
    actions: Vec<Action>,
}

/// Something that happens to the SubDevice at a position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Action {
    Fall(usize, AlState, AlCode),
    Reset(usize),
    Connected(usize, bool),
    Powered(usize, bool),
    ClockStopped(usize, bool),
    WatchdogMissing(usize),
}

/// What happens to one frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct FramePlan {
    pub lost: bool,
    pub reply_lost: bool,
    pub process_data_withheld: bool,
    pub delay: Duration,
    pub duplicated: bool,
    pub corrupted: bool,
    pub foreign_before: bool,
}

impl FaultHandle {
    /// Loses every frame for a time, before any SubDevice sees it.
    pub fn lose_frames_for(&self, duration: Duration) {
        self.with(|f| f.losing = Window::Requested(duration));
    }

    /// Loses the next frames, before any SubDevice sees them.
    pub fn lose_next(&self, frames: u32) {
        self.with(|f| f.lose = frames);
    }

    /// Loses the next frames on their way back: SubDevices have acted on them.
    pub fn lose_next_replies(&self, frames: u32) {
        self.with(|f| f.lose_replies = frames);
    }

    /// Delays the next frames on their way back. At most 64 frames can be under way.
    pub fn delay_next(&self, frames: u32, delay: Duration) {
        self.with(|f| f.delay = (frames, delay));
    }

    /// Sends the replies to the next frames twice.
    pub fn duplicate_next(&self, frames: u32) {
        self.with(|f| f.duplicate = frames);
    }

    /// Breaks the structure of the next replies: cut, or with a wrong header, length or working counter. Process
    /// data is never changed alone: on a real wire the frame's check sum would tell.
    pub fn corrupt_next(&self, frames: u32) {
        self.with(|f| f.corrupt = frames);
    }

    /// Puts a frame of another protocol before each of the next replies.
    pub fn foreign_before_next(&self, frames: u32) {
        self.with(|f| f.foreign = frames);
    }

    /// Process data passes all SubDevices by for a time: the working counter is too low, outputs are not taken and
    /// inputs not given. Registers still answer.
    pub fn working_counter_low_for(&self, duration: Duration) {
        self.with(|f| f.withholding = Window::Requested(duration));
    }

    /// The SubDevice falls to SAFEOP with an error.
    pub fn drop_to_safeop(&self, position: usize) {
        self.act(Action::Fall(
            position,
            AlState::SafeOp,
            AlCode::SYNCHRONISATION_ERROR,
        ));
    }

    /// The SubDevice turns out to be built without a process-data watchdog: its SyncManagers do not take that bit.
    pub fn have_no_watchdog(&self, position: usize) {
        self.act(Action::WatchdogMissing(position));
    }

    /// The SubDevice's controller restarts: INIT, registers at their defaults.
    pub fn drop_to_init(&self, position: usize) {
        self.act(Action::Reset(position));
    }

    /// The cable before the SubDevice is pulled: nothing from there on answers. It keeps its power, and its
    /// watchdog runs.
    pub fn disappear(&self, position: usize) {
        self.act(Action::Connected(position, false));
    }

    /// The cable is plugged in again.
    pub fn reappear(&self, position: usize) {
        self.act(Action::Connected(position, true));
    }

    /// The SubDevice loses its power, and the bus ends before it.
    pub fn power_off(&self, position: usize) {
        self.act(Action::Powered(position, false));
    }

    /// Power comes back: the SubDevice starts in INIT with nothing configured.
    pub fn power_on(&self, position: usize) {
        self.act(Action::Powered(position, true));
    }

    /// The SubDevice's clock stops, or goes on.
    pub fn stop_clock(&self, position: usize, stopped: bool) {
        self.act(Action::ClockStopped(position, stopped));
    }

    /// Ends every condition and counter that concerns frames. States, cables, power and clocks stay.
    pub fn clear(&self) {
        self.with(|f| {
            *f = Faults {
                actions: std::mem::take(&mut f.actions),
                ..Faults::default()
            }
        });
    }

    /// What happens to the frame that arrives at `now_ns`.
    pub(super) fn plan(&self, now_ns: u64) -> FramePlan {
        self.with(|f| {
            let mut plan = FramePlan {
                lost: f.losing.is_open(now_ns),
                process_data_withheld: f.withholding.is_open(now_ns),
                ..FramePlan::default()
            };
            plan.lost |= take_one(&mut f.lose);
            if plan.lost {
                return plan;
            }
            plan.reply_lost = take_one(&mut f.lose_replies);
            if take_one(&mut f.delay.0) {
                plan.delay = f.delay.1;
            }
            plan.duplicated = take_one(&mut f.duplicate);
            plan.corrupted = take_one(&mut f.corrupt);
            plan.foreign_before = take_one(&mut f.foreign);
            plan
        })
    }

    /// Opens windows whose time begins, and moves the waiting actions to `into`.
    pub(super) fn take_actions(&self, now_ns: u64, into: &mut Vec<Action>) {
        self.with(|f| {
            f.losing.is_open(now_ns);
            f.withholding.is_open(now_ns);
            into.append(&mut f.actions);
        });
    }

    fn act(&self, action: Action) {
        self.with(|f| {
            if f.actions.len() < MAX_WAITING {
                f.actions.push(action);
            }
        });
    }

    fn with<R>(&self, change: impl FnOnce(&mut Faults) -> R) -> R {
        change(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

fn take_one(count: &mut u32) -> bool {
    let some = *count > 0;
    *count = count.saturating_sub(1);
    some
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn a_window_counts_from_the_first_frame() {
        let faults = FaultHandle::default();
        faults.lose_frames_for(Duration::from_millis(10));
        assert!(faults.plan(500 * MS).lost);
        assert!(faults.plan(510 * MS - 1).lost);
        assert!(!faults.plan(510 * MS).lost);
        assert!(!faults.plan(505 * MS).lost, "closed for good");
    }

    #[test]
    fn counted_faults_end() {
        let faults = FaultHandle::default();
        faults.lose_next(1);
        faults.delay_next(2, Duration::from_millis(3));
        faults.duplicate_next(1);
        assert_eq!(
            faults.plan(0),
            FramePlan {
                lost: true,
                ..FramePlan::default()
            }
        );
        let delayed = FramePlan {
            delay: Duration::from_millis(3),
            ..FramePlan::default()
        };
        assert_eq!(
            faults.plan(0),
            FramePlan {
                duplicated: true,
                ..delayed
            }
        );
        assert_eq!(faults.plan(0), delayed);
        assert_eq!(faults.plan(0), FramePlan::default());
    }

    #[test]
    fn clearing_ends_frames_faults_only() {
        let faults = FaultHandle::default();
        faults.lose_frames_for(Duration::MAX);
        faults.corrupt_next(u32::MAX);
        faults.drop_to_init(0);
        faults.clear();
        assert_eq!(faults.plan(0), FramePlan::default());
        let mut actions = Vec::new();
        faults.take_actions(0, &mut actions);
        assert_eq!(actions, [Action::Reset(0)]);
    }

    #[test]
    fn waiting_actions_are_bounded() {
        let faults = FaultHandle::default();
        for _ in 0..MAX_WAITING + 10 {
            faults.drop_to_safeop(0);
        }
        let mut actions = Vec::new();
        faults.take_actions(0, &mut actions);
        assert_eq!(actions.len(), MAX_WAITING);
    }
}
