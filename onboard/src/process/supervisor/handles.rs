//! The supervisor's side of the activities: commands to them, reports and states from them.

use coordination::activity::LifeCycleState;
use coordination::event::{Receiver, Sender, queue};
use coordination::symbols::Writer;
use description::threads::ActivityKind;

use crate::activities::port::{COMMANDS, Command, Port, REPORTS, Report};
use crate::symbols::values::ActivityState;
use crate::symbols::wiring::ACTIVITIES;

/// The supervisor's side of one activity.
#[derive(Debug)]
pub struct Handle {
    /// Which.
    pub kind: ActivityKind,
    /// Commands to it.
    pub commands: Sender<Command>,
    /// Reports from it.
    pub reports: Receiver<Report>,
    /// Its state, as last reported.
    pub state: LifeCycleState,
}

impl Handle {
    /// Says again what still holds, unless what was said before has not been heard yet: there must be room for what is said once.
    pub(super) fn repeat(&mut self, command: Command) {
        if self.commands.free() > COMMANDS / 2 {
            self.tell(command);
        }
    }

    /// Sends a command. One that finds its queue full is lost, which the log says at once and a fault afterwards.
    pub(super) fn tell(&mut self, command: Command) {
        if self.commands.send(command).is_err() {
            tracing::error!(
                "{} does not take its commands: {command:?} is lost",
                self.kind
            );
        }
    }
}

/// A port for each activity, and the supervisor's side of it. `states` are in the order of [`ACTIVITIES`].
#[must_use]
pub fn ports(states: Vec<Writer<ActivityState>>) -> (Vec<(ActivityKind, Port)>, Vec<Handle>) {
    { ACTIVITIES.into_iter().zip(states) }
        .map(|(kind, state)| {
            let (commands, command_receiver) = queue(COMMANDS);
            let (report_sender, reports) = queue(REPORTS);
            let handle = Handle {
                kind,
                commands,
                reports,
                state: LifeCycleState::Created,
            };
            let port = Port::new(command_receiver, report_sender, state);
            ((kind, port), handle)
        })
        .unzip()
}

/// All activities.
#[derive(Debug)]
pub(super) struct Handles(pub(super) Vec<Handle>);

impl Handles {
    /// The next report, with the activity that it comes from.
    pub(super) fn next_report(&mut self) -> Option<(ActivityKind, Report)> {
        self.0.iter_mut().find_map(|handle| {
            let report = handle.reports.receive()?;
            if let Report::LifeCycle(state) = report {
                handle.state = state;
            }
            Some((handle.kind, report))
        })
    }

    /// A command to one activity.
    pub(super) fn tell(&mut self, kind: ActivityKind, command: Command) {
        for handle in self.0.iter_mut().filter(|handle| handle.kind == kind) {
            handle.tell(command);
        }
    }

    /// A command to all.
    pub(super) fn tell_all(&mut self, command: Command) {
        self.0.iter_mut().for_each(|handle| handle.tell(command));
    }

    /// Commands that found their queue full, since the program began.
    pub(super) fn refused(&self) -> u64 {
        { self.0.iter() }
            .map(|handle| handle.commands.refused())
            .sum()
    }

    /// Whether each of `kinds` is in one of `states`.
    pub(super) fn are(&self, kinds: &[ActivityKind], states: &[LifeCycleState]) -> bool {
        { self.0.iter().filter(|handle| kinds.contains(&handle.kind)) }
            .all(|handle| states.contains(&handle.state))
    }

    /// Activities that have not stopped.
    pub(super) fn not_stopped(&self) -> impl Iterator<Item = ActivityKind> + '_ {
        { self.0.iter() }
            .filter(|handle| handle.state != LifeCycleState::Stopped)
            .map(|handle| handle.kind)
    }
}
