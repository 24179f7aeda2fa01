//! State machines, and which robot runs which.

use crate::geometry::Pose2;
use crate::keys::{List, Map, Name, Need, Optional, POSITION, Pose, Text, Texts};
use crate::section;

section! {
    /// A Mealy machine.
    #[derive(Default)]
    pub struct FsmConfig {
        /// The first state, unless a robot's entry names another.
        pub initial: String as Text("the name of a state"),
        /// Events that no monitor raises: they come from an operator or the network.
        pub external: Vec<String> as Texts("an event's name"),
        /// Its states.
        pub states: Vec<FsmState> as Map("sections [fsm.<role>.states.<name>]", Need::Required),
        /// Its transitions; at most one for a state and an event.
        pub transitions: Vec<FsmTransition> as List("tables { from = …, on = …, to = … }", Need::Required),
    }
}

section! {
    /// What a state of the machine means.
    #[derive(Eq)]
    pub struct FsmState {
        /// Unique in the machine.
        pub name: String as Name,
        /// The area that the state is about.
        pub area: String as Text("an area's id"),
        /// Further areas whose floor the robot takes in this state.
        pub also: Vec<String> as Texts("an area's id"),
        /// The lane to drive on, or onto, when it is not the area's.
        pub lane: Option<String> as Optional(Text("a lane's id")),
        /// The skill that runs in it.
        pub skill: String as Text("a skill's id"),
    }
}

section! {
    /// A transition of the machine.
    #[derive(Eq)]
    pub struct FsmTransition {
        /// In this state,
        pub from: String as Text("the name of a state"),
        /// on this event,
        pub on: String as Text("an event's name"),
        /// go to this state
        pub to: String as Text("the name of a state"),
        /// and raise these events.
        pub outputs: Vec<String> as Texts("an event's name"),
    }
}

section! {
    /// A robot on this site.
    pub struct SiteRobot {
        /// Which state machine it runs.
        pub role: String as Text("the name of a state machine, as in [fsm.<role>]"),
        /// Where it starts, in `map`.
        pub start: Pose2 as Pose(POSITION),
        /// In which state; left out: the machine's initial one.
        pub start_state: Option<String> as Optional(Text("the name of a state")),
    }
}

impl FsmConfig {
    /// The state with this name.
    #[must_use]
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
