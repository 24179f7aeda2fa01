//! Names of states, areas and skills for the symbol table, looked up once.

use coordination::event::EventId;
use skills::navigator::Navigator;

use crate::symbols::values::Name;

/// Event of the machine that an operator's reset raises, if the machine knows it.
const RESET_EVENT: &str = "reset";
/// Output of the machine that counts laps.
const LAP_OUTPUT: &str = "lap";

/// Names for the symbol table, looked up once.
#[derive(Debug)]
pub(super) struct Names {
    pub(super) states: Vec<Name>,
    pub(super) areas: Vec<Name>,
    pub(super) skills: Vec<Name>,
    pub(super) reset: Option<EventId>,
    pub(super) lap: Option<EventId>,
}

impl Names {
    pub(super) fn of(navigator: &Navigator) -> Self {
        let machine = navigator.machine();
        let skills = machine
            .states()
            .filter_map(|(state, _)| navigator.schedule(state))
            .map(|schedule| schedule.skill)
            .max()
            .map_or(0, |last| last + 1);
        Self {
            states: machine.states().map(|(_, name)| Name::new(name)).collect(),
            areas: navigator
                .map()
                .areas()
                .iter()
                .map(|area| Name::new(&area.id))
                .collect(),
            skills: (0..skills)
                .map(|skill| Name::new(navigator.skill_name(skill)))
                .collect(),
            reset: machine.input(RESET_EVENT),
            lap: machine.output(LAP_OUTPUT),
        }
    }
}
