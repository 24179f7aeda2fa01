//! The supervisor's loop, and how the program ends: first the robot stands, then its activities stop.

use std::sync::atomic::{AtomicBool, Ordering};

use coordination::activity::LifeCycleEvent;
use skills::drive::STANDING_RAD_S;

use super::holders::Who;
use super::supervision::{PERIOD_NS, Supervisor};
use crate::activities::port::Command;
use crate::process::ctl::{Pending, Server};
use crate::process::watchdogs::Pulse;
use crate::realtime::clock::{MILLISECOND_NS, SECOND_NS, now_ns, sleep_until, slept_ns};
use crate::symbols::faults::Fault;
use crate::symbols::values::Mode;

/// How long a robot may take to stand before the program ends anyway.
const STANDSTILL_NS: u64 = 3 * SECOND_NS;
/// How long activities may take to stop once the robot stands.
pub const STOPPING_NS: u64 = SECOND_NS;
/// How long after a panic of the supervisor itself the program ends: by then its drive has stopped the robot.
pub const UNSUPERVISED_NS: u64 = 2 * SECOND_NS;
/// An older encoder reading does not count.
pub(super) const ENCODER_AGE_NS: u64 = 200 * MILLISECOND_NS;

/// How the program ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// By a signal.
    Asked,
    /// A thread panicked.
    Panicked,
}

impl Supervisor {
    /// Supervises until the robot has been asked to end and stands.
    pub fn run(&mut self, asked_to_end: &AtomicBool, server: &Server, pulse: &Pulse) -> Ending {
        self.begin();
        let mut next_ns = now_ns();
        loop {
            next_ns = (next_ns + PERIOD_NS).max(now_ns());
            sleep_until(next_ns);
            let now_ns = now_ns();
            self.heed_sleep(slept_ns(), || server.next(), now_ns);
            if !self.watch.hangs() {
                pulse.beat(now_ns);
            }
            pulse.show(self.mode_value.mode, &self.table);
            let asked = asked_to_end.load(Ordering::Relaxed);
            if self.turn(now_ns, asked, || server.next()) {
                break;
            }
        }
        self.stop_activities();
        self.publish(now_ns());
        if self.panicked.is_raised() {
            Ending::Panicked
        } else {
            Ending::Asked
        }
    }

    /// What is due every [`PERIOD_NS`]. True when the robot stands after it was `asked` to end, or a part of it has panicked: then its
    /// activities may stop.
    pub fn turn(
        &mut self,
        now_ns: u64,
        asked: bool,
        next_request: impl FnMut() -> Option<Pending>,
    ) -> bool {
        if !asked && !self.panicked.is_raised() {
            self.cycle(now_ns, next_request);
            return false;
        }
        self.hear(now_ns);
        if self.panicked.is_raised() {
            self.keep_stopped(now_ns);
            self.log_panic();
        } else {
            // Where it has come to stand is where it ends.
            self.keep(self.mode_of_itself() as u64, now_ns);
        }
        let stands = self.end(now_ns);
        self.publish(now_ns);
        stands
    }

    /// Logs what a real-time thread that panicked had no time to say.
    pub fn log_panic(&self) {
        if let Some(words) = self.panicked.take_words() {
            tracing::error!("{words}");
        }
    }

    /// Keeps the robot as stopped: the process after one in which something panicked waits for an operator.
    pub fn keep_stopped(&mut self, now_ns: u64) {
        self.keep(Mode::Stopped as u64, now_ns);
    }

    /// Stops the robot; true when it stands, or when it has had its time.
    pub(super) fn end(&mut self, now_ns: u64) -> bool {
        if self.ending_since_ns == 0 {
            self.ending_since_ns = now_ns;
            self.take_back("the program ends");
            self.mode_value.mode = Mode::Ending as u64;
            self.mode_value.teleop = 0;
            tracing::info!("stopping the robot, then the program");
            if self.panicked.is_raised() {
                self.raise(Who::Supervisor, Fault::Panic, 0.0, now_ns);
            }
        }
        // A drive whose own thread has panicked says nothing more, and ramps all the same.
        let stands = if self.panicked.is_raised() {
            self.seen_standing(now_ns)
        } else {
            self.standing(now_ns)
        };
        stands || now_ns > self.ending_since_ns + STANDSTILL_NS
    }

    pub(super) fn standing(&mut self, now_ns: u64) -> bool {
        let drive = self.symbols.drive.read();
        let bus =
            drive.value.operational != 0 && now_ns.saturating_sub(drive.stamp_ns) < ENCODER_AGE_NS;
        self.seen_standing(now_ns) || !bus
    }

    /// Its encoders say so.
    fn seen_standing(&mut self, now_ns: u64) -> bool {
        let encoders = self.symbols.encoders.read();
        let fresh = now_ns.saturating_sub(encoders.stamp_ns) < ENCODER_AGE_NS;
        fresh && encoders.value.speeds.fastest_rad_s() < STANDING_RAD_S
    }

    /// Tells all activities to stop.
    pub fn tell_to_stop(&mut self) {
        self.handles
            .tell_all(Command::LifeCycle(LifeCycleEvent::Stop));
    }

    /// Whether all activities say that they have stopped.
    pub fn have_stopped(&mut self, now_ns: u64) -> bool {
        self.hear(now_ns);
        self.handles.not_stopped().next().is_none()
    }

    pub(super) fn stop_activities(&mut self) {
        self.tell_to_stop();
        let deadline_ns = now_ns() + STOPPING_NS;
        while now_ns() < deadline_ns && !self.have_stopped(now_ns()) {
            sleep_until(now_ns() + 5 * MILLISECOND_NS);
        }
        for kind in self.handles.not_stopped() {
            tracing::warn!("{kind} did not stop in time");
        }
    }
}
