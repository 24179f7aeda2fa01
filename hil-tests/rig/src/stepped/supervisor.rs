//! Stands in for the supervisor: life cycles, commands to the activities, and what they report.

use coordination::activity::{LifeCycleEvent, LifeCycleState};
use coordination::event::EventId;
use coordination::fsm::{Machine, StateId};
use onboard::activities::port::{Command, Report};
use onboard::process::supervisor::Handle;
use onboard::symbols::faults::Fault;
use skills::navigator::Instructed;

/// Something an activity reported.
#[derive(Clone, Debug, PartialEq)]
pub enum Note {
    /// The robot's machine moved.
    Moved {
        /// The state it left.
        from: String,
        /// The state it entered.
        to: String,
    },
    /// A fault came, with a figure that describes it.
    Raised(Fault, f64),
    /// A fault went.
    Cleared(Fault),
    /// What became of an instruction.
    Instructed(Instructed),
}

/// The activities that run.
pub(super) struct Supervisor {
    handles: Vec<Handle>,
    /// The robot's machine, for its names; navigation steps it.
    machine: Machine,
    lost: u64,
}

impl Supervisor {
    /// Tells all of `handles` to acquire what they need.
    pub(super) fn new(handles: Vec<Handle>, machine: Machine) -> Self {
        let mut supervisor = Self {
            handles,
            machine,
            lost: 0,
        };
        supervisor.tell(Command::LifeCycle(LifeCycleEvent::Configure), |_| true);
        supervisor
    }

    /// A command to some of the activities.
    pub(super) fn tell(&mut self, command: Command, to: impl Fn(&Handle) -> bool) {
        for handle in self.handles.iter_mut().filter(|handle| to(handle)) {
            self.lost += u64::from(handle.commands.send(command).is_err());
        }
    }

    /// The number of an input of the machine.
    pub(super) fn event(&self, name: &str) -> Option<EventId> {
        self.machine.input(name)
    }

    /// Takes in all reports, and starts activities that are ready.
    pub(super) fn cycle(&mut self, mut note: impl FnMut(Note)) {
        for handle in &mut self.handles {
            while let Some(report) = handle.reports.receive() {
                match report {
                    Report::LifeCycle(state) => handle.state = state,
                    Report::Raised(fault, figure) => note(Note::Raised(fault, figure)),
                    Report::Cleared(fault) => note(Note::Cleared(fault)),
                    Report::Instructed(what) => note(Note::Instructed(what)),
                    Report::Moved { from, to } => {
                        let name = |state: StateId| self.machine.state_name(state).to_owned();
                        note(Note::Moved {
                            from: name(from),
                            to: name(to),
                        });
                    }
                }
            }
        }
        let all_ready = self.handles.iter().all(|handle| {
            matches!(
                handle.state,
                LifeCycleState::Ready | LifeCycleState::Running
            )
        });
        self.tell(Command::LifeCycle(LifeCycleEvent::Run), |handle| {
            all_ready && handle.state == LifeCycleState::Ready
        });
    }

    /// Commands that found a full queue.
    pub(super) fn lost(&self) -> u64 {
        self.lost
    }
}
