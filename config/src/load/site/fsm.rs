//! `[fsm.<role>]` and `[robots.<id>]`

use crate::quantity::POSITION;
use crate::reader::Section;
use crate::site::{FsmConfig, FsmState, FsmTransition, SiteRobot};

pub(super) fn read(role: &str, s: &Section<'_>) -> (String, FsmConfig) {
    let fsm = FsmConfig {
        initial: s.text("initial", "the name of a state"),
        external: s.texts("external", "an event's name"),
        states: s.section("states", "sections [fsm.<role>.states.<name>]", |s| {
            s.each(state)
        }),
        transitions: s.list(
            "transitions",
            "tables { from = …, on = …, to = … }",
            transition,
        ),
    };
    (role.to_owned(), fsm)
}

fn state(name: &str, s: &Section<'_>) -> FsmState {
    FsmState {
        name: name.to_owned(),
        area: s.text("area", "an area's id"),
        also: s.texts("also", "an area's id"),
        lane: s.text_if("lane", "a lane's id"),
        skill: s.text("skill", "a skill's id"),
    }
}

fn transition(s: &Section<'_>) -> FsmTransition {
    FsmTransition {
        from: s.text("from", "the name of a state"),
        on: s.text("on", "an event's name"),
        to: s.text("to", "the name of a state"),
        outputs: s.texts("outputs", "an event's name"),
    }
}

pub(super) fn robot(id: &str, s: &Section<'_>) -> (String, SiteRobot) {
    let robot = SiteRobot {
        role: s.text("role", "the name of a state machine, as in [fsm.<role>]"),
        start: s.pose("start", POSITION),
        start_state: s.text_if("start_state", "the name of a state"),
    };
    (id.to_owned(), robot)
}
