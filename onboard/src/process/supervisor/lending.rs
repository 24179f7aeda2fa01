//! Who drives the robot by hand: one at a time, until that one leaves, an operator stops or pauses the robot, or the
//! program ends. After that the robot is paused.

use coordination::activity::LifeCycleEvent;
use description::threads::ActivityKind;

use super::lease::Lease;
use super::supervision::Supervisor;
use crate::activities::port::Command;
use crate::process::ctl::{Done, Refusal, Reply};
use crate::realtime::clock::SECOND_NS;
use crate::symbols::values::Mode;

/// How long the teleoperator's desk may take to show a session, or be silent in it.
const DESK_NS: u64 = SECOND_NS;

impl Supervisor {
    /// Takes the robot into somebody's hands.
    pub(super) fn lend(&mut self, now_ns: u64) -> Reply {
        if self.lease.is_some() {
            return Err(Refusal::AnotherTeleoperator);
        }
        if self.mode_value.mode == Mode::Configuring as u64 {
            return Err(Refusal::NotReady);
        }
        if self.is_reloading() {
            return Err(Refusal::AnotherReload);
        }
        self.sessions += 1;
        let session = self.sessions;
        self.lease = Some(Lease {
            session,
            since_ns: now_ns,
        });
        // From now on it goes on only when it is told to.
        self.operator_paused = true;
        Ok(Done::Lent(session))
    }

    /// Takes the robot out of the hands of who has left, or whose desk hangs.
    pub(super) fn watch_lease(&mut self, now_ns: u64) {
        let Some(Lease { session, since_ns }) = self.lease else {
            return;
        };
        let wish = self.symbols.wish.read();
        let shown = wish.value.session == session;
        let silent = now_ns.saturating_sub(wish.stamp_ns) > DESK_NS;
        let had_time = now_ns.saturating_sub(since_ns) > DESK_NS;
        if shown && wish.value.open == 0 {
            self.take_back("the teleoperator has left");
        } else if had_time && (silent || !shown) {
            self.take_back("nothing is heard from the teleoperator's desk");
        }
    }

    /// Takes the robot out of whose hands it is in, if it is in any.
    pub(super) fn take_back(&mut self, why: &str) {
        if let Some(Lease { session, .. }) = self.lease.take() {
            tracing::info!(
                "teleop: session {session} is over: {why}; `onboard ctl resume` goes on"
            );
            // Before the mode says so, so that navigation does not go on by itself in between.
            let pause = Command::LifeCycle(LifeCycleEvent::Pause);
            self.handles.tell(ActivityKind::Navigation, pause);
        }
    }

    /// Says what the robot is doing now.
    pub(super) fn tell_mode(&mut self) {
        if self.mode_value.mode != Mode::Configuring as u64 {
            self.mode_value.mode = self.mode() as u64;
        }
        self.mode_value.teleop = self.lease.map_or(0, |lease| lease.session);
    }
}
