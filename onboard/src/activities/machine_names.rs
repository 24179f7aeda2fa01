//! Names and numbers of the robot's machine, for those who talk about it.

use coordination::event::EventId;
use skills::navigator::Navigator;

/// What others need to know of the robot's machine to talk about it: names and numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MachineNames {
    /// Names of its states, by number.
    pub states: Vec<String>,
    /// Its input events.
    pub inputs: Vec<(String, EventId)>,
    /// Its output events.
    pub outputs: Vec<(String, EventId)>,
}

impl MachineNames {
    /// Of a navigator's machine.
    #[must_use]
    pub fn of(navigator: &Navigator) -> Self {
        let machine = navigator.machine();
        Self {
            states: machine.states().map(|(_, name)| name.to_owned()).collect(),
            inputs: machine
                .inputs()
                .map(|(event, name)| (name.to_owned(), event))
                .collect(),
            outputs: machine
                .outputs()
                .map(|(event, name)| (name.to_owned(), event))
                .collect(),
        }
    }

    /// The name of a state.
    #[must_use]
    pub fn state(&self, number: u16) -> &str {
        let name = self.states.get(usize::from(number));
        name.map_or("?", String::as_str)
    }

    /// The number of an event.
    #[must_use]
    pub fn input(&self, name: &str) -> Option<EventId> {
        let found = self.inputs.iter().find(|(known, _)| known == name);
        found.map(|(_, event)| *event)
    }

    /// The name of an output.
    #[must_use]
    pub fn output(&self, event: EventId) -> Option<&str> {
        let found = self.outputs.iter().find(|(_, known)| *known == event);
        found.map(|(name, _)| name.as_str())
    }
}
