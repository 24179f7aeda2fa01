//! The robot as a whole: mode, life cycles, threads, and how it stands with the mediator.

use super::{Line, Name};
use crate::realtime::histogram::Histogram;
use crate::realtime::scheduling::Granted;

/// What the robot as a whole is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum Mode {
    /// Activities acquire their resources.
    Configuring = 0,
    /// It drives, or would if nothing were in the way.
    Running = 1,
    /// An operator paused it.
    Paused = 2,
    /// A fault or an operator stopped it; it waits for a reset.
    Stopped = 3,
    /// It stops, then the program ends.
    Ending = 4,
    /// Somebody drives it by hand.
    Teleop = 5,
}

impl Mode {
    /// Its name on the network and in `inspect`.
    #[must_use]
    pub fn name_of(number: u64) -> &'static str {
        match number {
            0 => "configuring",
            1 => "running",
            2 => "paused",
            3 => "stopped",
            5 => "teleop",
            _ => "ending",
        }
    }
}

value! {
    /// The supervisor's view of the robot.
    RobotMode, "robot_mode" {
        /// 0 configuring, 1 running, 2 paused, 3 stopped, 4 ending, 5 driven by hand.
        mode: u64,
        /// 1: it is to stand, with the deceleration of stops, whatever navigation wants.
        halt: u64,
        /// 1 while nobody knows where the robot stands.
        lost: u64,
        /// Number of the session of who drives it by hand, 0 for none.
        teleop: u64,
        /// Tells this start of the process from others.
        boot_epoch: u64,
        /// Process id.
        pid: u64,
        /// Robot, as its file names it.
        robot: Name,
    }
}

value! {
    /// What people say that the robot carries.
    Load, "load" {
        /// What it is; empty: nothing.
        name: Name,
        /// Its mass; 0: not known.
        mass_kg: f64,
    }
}

value! {
    /// Life cycle of one activity.
    ActivityState, "activity_state" {
        /// Number of the life-cycle state.
        state: u64,
        /// Events that arrived in a state that has no use for them.
        ignored_events: u64,
        /// How often its event loop ran.
        cycles: u64,
    }
}

value! {
    /// Scheduling and timing of one thread.
    ThreadReport, "thread_report" {
        /// Configured period; 0 when it has none.
        period_ns: u64,
        /// How often its loop ran.
        cycles: u64,
        /// 1 while it drives the robot, and must not wait for anything but its trigger.
        running: u64,
        /// Cycles that ended after the next should have begun.
        overruns: u64,
        /// Periods that were skipped for that.
        missed: u64,
        /// The kernel's number of the thread.
        thread: u64,
        /// Page faults that it had before it began to drive the robot.
        faults_before: u64,
        /// What the kernel granted.
        granted: Granted,
        /// Lateness of wake-ups while running, in µs when described.
        wakeup: Histogram,
        /// Execution times while running, in µs when described.
        exec: Histogram,
    }
}

value! {
    /// How the robot stands with the mediator.
    FleetState, "fleet_state" {
        /// 0: nobody manages the site's areas, and everything is granted.
        managed: u64,
        /// The mediator's epoch, 0 before its first message.
        mediator_epoch: u64,
        /// The registration, 0 without one.
        session: u64,
        /// 1 when nothing was heard from the mediator for too long.
        silent: u64,
        /// 1 while the mediator has the discrete control.
        acquired: u64,
        /// The coordination under way, 0 for none.
        coordination: u64,
        /// Its net, with the flags set so far.
        net: Line,
        /// Areas that the robot may be in.
        holds: Line,
        /// Areas that it waits for and why, and orders that wait for its machine; or why the mediator refuses it.
        waits: Line,
        /// Reports sent.
        sent: u64,
        /// Messages of the mediator.
        received: u64,
        /// Messages of the mediator that were lost here, or could not be read.
        dropped: u64,
    }
}
