//! The life cycle that every activity has, as a state machine.

use core::fmt;

use crate::event::{EventId, EventTable};
use crate::fsm::{Machine, MachineModel, StateId};

/// Where an activity is in its life. The numbers are stable, for use in shared memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum LifeCycleState {
    /// It exists and holds no resources.
    Created = 0,
    /// It acquires its resources, at first or again after a fault; outputs are disabled.
    Configuring = 1,
    /// It could run.
    Ready = 2,
    /// It does its work; real-time rules hold.
    Running = 3,
    /// It holds its resources and its outputs are at rest.
    Paused = 4,
    /// It takes over new parameters; outputs are disabled.
    Reconfiguring = 5,
    /// It has ended; only an operator can have it configured again.
    Stopped = 6,
}

impl LifeCycleState {
    /// All states, in the order of their numbers.
    pub const ALL: [Self; 7] = [
        Self::Created,
        Self::Configuring,
        Self::Ready,
        Self::Running,
        Self::Paused,
        Self::Reconfiguring,
        Self::Stopped,
    ];

    /// The state's name as people read it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Created => "created",
            Self::Configuring => "configuring",
            Self::Ready => "ready",
            Self::Running => "running",
            Self::Paused => "paused",
            Self::Reconfiguring => "reconfiguring",
            Self::Stopped => "stopped",
        }
    }

    /// The state with this number.
    #[must_use]
    pub fn from_u8(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }

    /// Whether resources are being acquired or exchanged, so that real-time rules are suspended
    /// and outputs disabled.
    #[must_use]
    pub const fn is_configuring(self) -> bool {
        matches!(self, Self::Configuring | Self::Reconfiguring)
    }
}

impl fmt::Display for LifeCycleState {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

/// What drives a life cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum LifeCycleEvent {
    /// Acquire the resources.
    Configure = 0,
    /// The resources, or the new parameters, are there.
    Configured = 1,
    /// Start or continue to work.
    Run = 2,
    /// Rest, and keep the resources.
    Pause = 3,
    /// Take over new parameters.
    Reconfigure = 4,
    /// A resource is lost and has to be acquired again.
    Fault = 5,
    /// End.
    Stop = 6,
}

impl LifeCycleEvent {
    /// All events, in the order of their numbers.
    pub const ALL: [Self; 7] = [
        Self::Configure,
        Self::Configured,
        Self::Run,
        Self::Pause,
        Self::Reconfigure,
        Self::Fault,
        Self::Stop,
    ];

    /// The event's name as people read it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Configure => "configure",
            Self::Configured => "configured",
            Self::Run => "run",
            Self::Pause => "pause",
            Self::Reconfigure => "reconfigure",
            Self::Fault => "fault",
            Self::Stop => "stop",
        }
    }
}

impl fmt::Display for LifeCycleEvent {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

/// The life cycle's transitions. After a fault, and after new parameters, an activity is *ready*;
/// others decide whether it runs again.
const TRANSITIONS: &[(LifeCycleState, LifeCycleEvent, LifeCycleState)] = {
    use LifeCycleEvent::{Configure, Configured, Fault, Pause, Reconfigure, Run, Stop};
    use LifeCycleState::{Configuring, Created, Paused, Ready, Reconfiguring, Running, Stopped};
    &[
        (Created, Configure, Configuring),
        (Created, Stop, Stopped),
        (Configuring, Configured, Ready),
        (Configuring, Fault, Configuring),
        (Configuring, Stop, Stopped),
        (Ready, Configure, Configuring),
        (Ready, Run, Running),
        (Ready, Reconfigure, Reconfiguring),
        (Ready, Fault, Configuring),
        (Ready, Stop, Stopped),
        (Running, Pause, Paused),
        (Running, Reconfigure, Reconfiguring),
        (Running, Fault, Configuring),
        (Running, Stop, Stopped),
        (Paused, Configure, Configuring),
        (Paused, Run, Running),
        (Paused, Reconfigure, Reconfiguring),
        (Paused, Fault, Configuring),
        (Paused, Stop, Stopped),
        (Reconfiguring, Configured, Ready),
        (Reconfiguring, Fault, Configuring),
        (Reconfiguring, Stop, Stopped),
        (Stopped, Configure, Configuring),
    ]
};

/// The life cycle of one activity.
///
/// ```
/// use coordination::activity::{LifeCycle, LifeCycleEvent, LifeCycleState};
///
/// let mut life = LifeCycle::new();
/// life.step(LifeCycleEvent::Configure);
/// life.step(LifeCycleEvent::Configured);
/// let change = life.step(LifeCycleEvent::Run);
/// assert_eq!(change, Some((LifeCycleState::Ready, LifeCycleState::Running)));
/// assert_eq!(life.step(LifeCycleEvent::Run), None);
/// assert_eq!(life.ignored(), 1);
/// ```
#[derive(Clone, Debug)]
pub struct LifeCycle {
    machine: Machine,
}

impl LifeCycle {
    /// A life that begins in [`LifeCycleState::Created`]. Allocates.
    #[must_use]
    pub fn new() -> Self {
        let mut model = MachineModel::new("life cycle");
        for state in LifeCycleState::ALL {
            model.state(state.name());
        }
        model.initial(LifeCycleState::Created.name());
        for &(from, on, to) in TRANSITIONS {
            model.transition(from.name(), on.name(), to.name(), &[]);
        }
        // Interning in the order of `ALL` makes an event's number its id.
        let mut events = EventTable::new();
        for event in LifeCycleEvent::ALL {
            events
                .intern(event.name())
                .expect("seven events fit into an empty table");
        }
        Self {
            machine: model
                .compile(&mut events)
                .expect("the life cycle is a constant that the tests compile"),
        }
    }

    /// The present state.
    #[must_use]
    pub fn state(&self) -> LifeCycleState {
        Self::state_of(self.machine.state())
    }

    /// Processes one event: the states before and after, or `None` if the present state ignores
    /// it, which is counted. Real time.
    pub fn step(&mut self, event: LifeCycleEvent) -> Option<(LifeCycleState, LifeCycleState)> {
        let step = self.machine.step(EventId(event as u16));
        (!step.ignored).then(|| (Self::state_of(step.from), Self::state_of(step.to)))
    }

    /// Whether the present state would react to `event`.
    #[must_use]
    pub fn accepts(&self, event: LifeCycleEvent) -> bool {
        self.machine.accepts(EventId(event as u16))
    }

    /// How many events were ignored.
    #[must_use]
    pub fn ignored(&self) -> u64 {
        self.machine.ignored()
    }

    /// The machine underneath, for printing.
    #[must_use]
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    fn state_of(id: StateId) -> LifeCycleState {
        LifeCycleState::ALL[id.index()]
    }
}

impl Default for LifeCycle {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::LifeCycleEvent::*;
    use super::LifeCycleState::*;
    use super::*;

    fn life_after(events: &[LifeCycleEvent]) -> LifeCycle {
        let mut life = LifeCycle::new();
        for &event in events {
            assert!(life.step(event).is_some(), "{event} in {}", life.state());
        }
        life
    }

    #[test]
    fn a_whole_life() {
        let mut life = life_after(&[Configure, Configured, Run, Pause, Run, Reconfigure]);
        assert_eq!(life.state(), Reconfiguring);
        assert_eq!(life.step(Configured), Some((Reconfiguring, Ready)));
        assert_eq!(life.step(Run), Some((Ready, Running)));
        assert_eq!(life.step(Stop), Some((Running, Stopped)));
        assert_eq!(life.ignored(), 0);
    }

    #[test]
    fn a_fault_leads_to_configuring_and_never_straight_back_to_running() {
        for prefix in [&[Run][..], &[Run, Pause], &[], &[Run, Reconfigure]] {
            let mut events = vec![Configure, Configured];
            events.extend_from_slice(prefix);
            let mut life = life_after(&events);
            assert_eq!(life.step(Fault).unwrap().1, Configuring);
            assert_eq!(life.step(Fault).unwrap().1, Configuring);
            assert_eq!(life.step(Run), None);
            assert_eq!(life.step(Configured).unwrap().1, Ready);
        }
    }

    #[test]
    fn a_stopped_activity_only_hears_configure() {
        let mut life = life_after(&[Stop]);
        for event in [Configured, Run, Pause, Reconfigure, Fault, Stop] {
            assert_eq!(life.step(event), None);
            assert!(!life.accepts(event));
        }
        assert_eq!(life.ignored(), 6);
        assert_eq!(life.step(Configure), Some((Stopped, Configuring)));
    }

    #[test]
    fn every_state_but_stopped_can_be_stopped() {
        for state in LifeCycleState::ALL {
            let stops = TRANSITIONS.contains(&(state, Stop, Stopped));
            assert_eq!(stops, state != Stopped, "{state}");
        }
    }

    #[test]
    fn numbers_and_names_agree_with_the_machine() {
        let life = LifeCycle::new();
        for (index, state) in LifeCycleState::ALL.into_iter().enumerate() {
            assert_eq!(state as usize, index);
            assert_eq!(LifeCycleState::from_u8(index as u8), Some(state));
            assert_eq!(
                life.machine().state_name(StateId(index as u16)),
                state.name()
            );
        }
        assert_eq!(LifeCycleState::from_u8(7), None);
        for (index, event) in LifeCycleEvent::ALL.into_iter().enumerate() {
            assert_eq!(event as usize, index);
            assert_eq!(
                life.machine().input_name(EventId(index as u16)),
                event.name()
            );
        }
        assert_eq!(life.machine().transitions().count(), TRANSITIONS.len());
    }
}
