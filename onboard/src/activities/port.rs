//! An activity's port: its life cycle, the queue of commands to it, the queue of reports from it.
//!
//! Real-time contract: after construction nothing here allocates, locks or makes a system call.

use coordination::activity::{LifeCycle, LifeCycleEvent, LifeCycleState};
use coordination::event::{Receiver, Sender};
use coordination::fsm::StateId;
use coordination::symbols::Writer;
use description::geometry::Pose2;
use drivers::kelo::EncoderContradiction;
use skills::drive::Disobedience;
use skills::navigator::{Instructed, Instruction};
use skills::odometry::Slip;

use crate::symbols::faults::{FAULTS, Fault};
use crate::symbols::values::ActivityState;

/// What the supervisor tells an activity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Steps the life cycle.
    LifeCycle(LifeCycleEvent),
    /// The operator has seen to the faults: forget those that waited for it.
    Reset,
    /// Drive at most this share of every speed, in thousandths.
    LimitSpeed(u16),
    /// An external event for the robot's machine, with what holds in the state that it enters.
    Instruct(Instruction),
    /// Somebody has put the robot there, or sees it stand there.
    Place(Placed),
    /// Somebody sees that the floor straight behind the robot is free for so many metres.
    FreeBehind(f64),
}

/// Where the robot stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placed {
    /// Where it starts, by the files, and in which state of its machine.
    AtStart,
    /// Elsewhere.
    At {
        /// `base_link` in `map`.
        pose: Pose2,
        /// The state that the machine goes on in; the present one if not given.
        state: Option<StateId>,
    },
}

/// What an activity tells the supervisor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Report {
    /// It is in another state of its life cycle.
    LifeCycle(LifeCycleState),
    /// A fault came, with a figure that describes it.
    Raised(Fault, f64),
    /// A fault went.
    Cleared(Fault),
    /// The robot's machine moved between two states, by an event.
    Moved {
        /// The state it left.
        from: StateId,
        /// The state it entered.
        to: StateId,
    },
    /// What became of a [`Command::Instruct`].
    Instructed(Instructed),
    /// A wheel does not do what it was told.
    Disobeyed(Disobedience),
    /// A wheel's encoder moves otherwise than its speed.
    Contradicted(EncoderContradiction),
    /// A wheel turns farther than it drives.
    Slipped(Slip),
}

/// Capacity of a queue of commands.
pub const COMMANDS: usize = 32;
/// Capacity of a queue of reports: the supervisor drains it ten times a second.
pub const REPORTS: usize = 256;

/// One activity's side of its queues, and its life cycle.
#[derive(Debug)]
pub struct Port {
    life_cycle: LifeCycle,
    commands: Receiver<Command>,
    reports: Sender<Report>,
    state: Writer<ActivityState>,
    present: [bool; FAULTS],
    cycles: u64,
    queue_was_full: bool,
}

impl Port {
    /// A port in state *created*.
    #[must_use]
    pub fn new(
        commands: Receiver<Command>,
        reports: Sender<Report>,
        state: Writer<ActivityState>,
    ) -> Self {
        Self {
            life_cycle: LifeCycle::new(),
            commands,
            reports,
            state,
            present: [false; FAULTS],
            cycles: 0,
            queue_was_full: false,
        }
    }

    /// The life cycle.
    #[must_use]
    pub fn life_cycle(&self) -> &LifeCycle {
        &self.life_cycle
    }

    /// State of the life cycle.
    #[must_use]
    pub fn state(&self) -> LifeCycleState {
        self.life_cycle.state()
    }

    /// Whether the activity is in state *running*.
    #[must_use]
    pub fn running(&self) -> bool {
        self.state() == LifeCycleState::Running
    }

    /// The next command that is not about the life cycle; life-cycle commands are carried out on the way.
    pub fn next_command(&mut self) -> Option<Command> {
        while let Some(command) = self.commands.receive() {
            match command {
                Command::LifeCycle(event) => self.step(event),
                other => return Some(other),
            }
        }
        None
    }

    /// Steps the life cycle and reports the change.
    pub fn step(&mut self, event: LifeCycleEvent) {
        if let Some((_, to)) = self.life_cycle.step(event) {
            self.report(Report::LifeCycle(to));
        }
    }

    /// Says that `fault` is present; only the first time is reported.
    pub fn raise(&mut self, fault: Fault, figure: f64) {
        if !std::mem::replace(&mut self.present[fault as usize], true) {
            self.report(Report::Raised(fault, figure));
        }
    }

    /// Says that `fault` is gone; only a change is reported.
    pub fn clear(&mut self, fault: Fault) {
        if std::mem::replace(&mut self.present[fault as usize], false) {
            self.report(Report::Cleared(fault));
        }
    }

    /// Raises or clears `fault`.
    pub fn set(&mut self, fault: Fault, present: bool, figure: f64) {
        if present {
            self.raise(fault, figure);
        } else {
            self.clear(fault);
        }
    }

    /// Reports something that happened and is over, such as one broken scan.
    pub fn note(&mut self, fault: Fault, figure: f64) {
        self.report(Report::Raised(fault, figure));
        self.report(Report::Cleared(fault));
    }

    /// Puts a report into the queue. A full queue is itself a fault, reported as soon as there is room.
    pub fn report(&mut self, report: Report) {
        if self.reports.send(report).is_err() {
            self.queue_was_full = true;
        }
    }

    /// A report was lost: once there is room, says so, and repeats all levels, since any of them may be the lost one.
    fn repair_reports(&mut self) {
        if self.reports.free() < FAULTS + 4 {
            return;
        }
        self.queue_was_full = false;
        self.note(Fault::QueueFull, self.reports.refused() as f64);
        for fault in Fault::ALL
            .into_iter()
            .filter(|&fault| fault != Fault::QueueFull)
        {
            let present = self.present[fault as usize];
            self.report(if present {
                Report::Raised(fault, 0.0)
            } else {
                Report::Cleared(fault)
            });
        }
        self.report(Report::LifeCycle(self.life_cycle.state()));
    }

    /// Publishes the state at the end of an event loop.
    pub fn publish(&mut self, now_ns: u64) {
        self.cycles += 1;
        if self.queue_was_full {
            self.repair_reports();
        }
        let state = ActivityState {
            state: self.life_cycle.state() as u64,
            ignored_events: self.life_cycle.ignored(),
            cycles: self.cycles,
        };
        self.state.write(now_ns, &state);
    }
}
