//! In the place of the supervisor: life cycles, commands to the activities, and what they report.

use coordination::activity::{LifeCycleEvent, LifeCycleState};
use coordination::event::{Receiver, Sender, queue};
use description::threads::ActivityKind;
use onboard::activities::port::{COMMANDS, Command, Instructed, Port, REPORTS, Report};
use onboard::symbols::faults::Fault;
use onboard::symbols::values::ActivityState;

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

struct Handle {
    kind: ActivityKind,
    commands: Sender<Command>,
    reports: Receiver<Report>,
    state: LifeCycleState,
}

/// Handles of the activities that run.
#[derive(Default)]
pub(super) struct Supervisor {
    handles: Vec<Handle>,
    states: Vec<String>,
    lost: u64,
}

impl Supervisor {
    /// The port of one more activity.
    pub(super) fn port(
        &mut self,
        kind: ActivityKind,
        state: coordination::symbols::Writer<ActivityState>,
    ) -> Port {
        let (commands, commands_end) = queue(COMMANDS);
        let (reports_end, reports) = queue(REPORTS);
        self.handles.push(Handle {
            kind,
            commands,
            reports,
            state: LifeCycleState::Created,
        });
        Port::new(commands_end, reports_end, state)
    }

    /// Names of the machine's states, by number.
    pub(super) fn name_states(&mut self, states: Vec<String>) {
        self.states = states;
    }

    /// Has all activities acquire what they need.
    pub(super) fn configure(&mut self) {
        for handle in &mut self.handles {
            self.lost += u64::from(
                handle
                    .commands
                    .send(Command::LifeCycle(LifeCycleEvent::Configure))
                    .is_err(),
            );
        }
    }

    /// A command to one activity.
    pub(super) fn tell(&mut self, kind: ActivityKind, command: Command) {
        for handle in self.handles.iter_mut().filter(|handle| handle.kind == kind) {
            self.lost += u64::from(handle.commands.send(command).is_err());
        }
    }

    /// Takes in all reports, and lets run what is ready.
    pub(super) fn cycle(&mut self, mut note: impl FnMut(Note)) {
        for handle in &mut self.handles {
            while let Some(report) = handle.reports.receive() {
                match report {
                    Report::LifeCycle(state) => handle.state = state,
                    Report::Raised(fault, figure) => note(Note::Raised(fault, figure)),
                    Report::Cleared(fault) => note(Note::Cleared(fault)),
                    Report::Instructed(what) => note(Note::Instructed(what)),
                    Report::Moved { from, to } => {
                        let name = |number: u16| {
                            self.states
                                .get(usize::from(number))
                                .cloned()
                                .unwrap_or_default()
                        };
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
        for handle in &mut self.handles {
            if all_ready && handle.state == LifeCycleState::Ready {
                self.lost += u64::from(
                    handle
                        .commands
                        .send(Command::LifeCycle(LifeCycleEvent::Run))
                        .is_err(),
                );
            }
        }
    }

    /// Commands that found a full queue.
    pub(super) fn lost(&self) -> u64 {
        self.lost
    }
}
