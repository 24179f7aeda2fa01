//! What a site file says about state machines, and which robot runs which.

use crate::geometry::PoseConfig;

/// `[fsm.<role>]`: a Mealy machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FsmConfig {
    /// The first state, unless a robot's entry names another.
    pub initial: String,
    /// Events that no monitor raises: they come from an operator or the network.
    pub external: Vec<String>,
    /// Its states.
    pub states: Vec<FsmState>,
    /// Its transitions; at most one for a state and an event.
    pub transitions: Vec<FsmTransition>,
}

/// `[fsm.<role>.states.<name>]`
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FsmState {
    /// Unique in the machine.
    pub name: String,
    /// The area that the state is about.
    pub area: String,
    /// Further areas whose floor the robot takes in this state.
    pub also: Vec<String>,
    /// The lane to drive on, or onto, when it is not the area's.
    pub lane: Option<String>,
    /// The skill that runs in it.
    pub skill: String,
}

/// One entry of `transitions`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FsmTransition {
    /// In this state,
    pub from: String,
    /// on this event,
    pub on: String,
    /// go to this state
    pub to: String,
    /// and raise these events.
    pub outputs: Vec<String>,
}

/// `[robots.<id>]`
#[derive(Clone, Debug, PartialEq)]
pub struct SiteRobot {
    /// Which state machine it runs.
    pub role: String,
    /// Where it starts.
    pub start: PoseConfig,
    /// In which state; by default the machine's initial one.
    pub start_state: Option<String>,
}

impl FsmConfig {
    /// The state with this name.
    pub fn state(&self, name: &str) -> Option<&FsmState> {
        self.states.iter().find(|state| state.name == name)
    }
}

impl FsmState {
    /// All areas whose floor the robot takes in this state.
    pub fn areas(&self) -> impl Iterator<Item = &str> {
        std::iter::once(self.area.as_str()).chain(self.also.iter().map(String::as_str))
    }
}
