//! The compiled machine: dense tables and one present state.

use alloc::boxed::Box;

use crate::event::EventId;

/// A dense state id, valid in the [`Machine`] that gave it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct StateId(pub u16);

impl StateId {
    /// The id as an index into an array with one entry per state.
    #[must_use]
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// Outputs are events of the same table as the inputs, so one machine's output can be another's
/// input.
pub type OutputId = EventId;

pub(super) const NO_STATE: u16 = u16::MAX;
pub(super) const NO_COLUMN: u16 = u16::MAX;

/// What one state does on one input; `outputs[first_output..end_output]` are fired.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub(super) to: u16,
    pub(super) first_output: u16,
    pub(super) end_output: u16,
}

impl Cell {
    pub(super) const NONE: Self = Self {
        to: NO_STATE,
        first_output: 0,
        end_output: 0,
    };
}

/// What one input did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step<'a> {
    /// The state before.
    pub from: StateId,
    /// The state after; the same as before for a transition onto itself and for an ignored input.
    pub to: StateId,
    /// The outputs fired, in the model's order.
    pub outputs: &'a [OutputId],
    /// The present state has no transition for this input; nothing happened.
    pub ignored: bool,
}

/// One transition of a machine, for printing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transition<'a> {
    /// The state that it leaves.
    pub from: StateId,
    /// The input that triggers it.
    pub on: EventId,
    /// The state that it enters.
    pub to: StateId,
    /// The outputs that it fires.
    pub outputs: &'a [OutputId],
}

/// A machine that runs; see [the module](super).
#[derive(Clone, Debug)]
pub struct Machine {
    name: Box<str>,
    states: Box<[Box<str>]>,
    initial: u16,
    inputs: Box<[(EventId, Box<str>)]>,
    output_names: Box<[(EventId, Box<str>)]>,
    /// Event index to column of `cells`.
    columns: Box<[u16]>,
    /// One row per state, one column per input.
    cells: Box<[Cell]>,
    outputs: Box<[EventId]>,
    present: u16,
    ignored: u64,
}

impl Machine {
    #[expect(
        clippy::too_many_arguments,
        reason = "the one caller fills one field each"
    )]
    pub(super) fn new(
        name: Box<str>,
        states: Box<[Box<str>]>,
        initial: u16,
        inputs: Box<[(EventId, Box<str>)]>,
        output_names: Box<[(EventId, Box<str>)]>,
        columns: Box<[u16]>,
        cells: Box<[Cell]>,
        outputs: Box<[EventId]>,
    ) -> Self {
        Self {
            name,
            states,
            initial,
            inputs,
            output_names,
            columns,
            cells,
            outputs,
            present: initial,
            ignored: 0,
        }
    }

    /// Processes one input. Real time: constant time, no allocation.
    pub fn step(&mut self, event: EventId) -> Step<'_> {
        let from = StateId(self.present);
        match self.cell(from, event) {
            Some(cell) => {
                self.present = cell.to;
                Step {
                    from,
                    to: StateId(cell.to),
                    outputs: self.outputs_of(cell),
                    ignored: false,
                }
            }
            None => {
                self.ignored = self.ignored.saturating_add(1);
                Step {
                    from,
                    to: from,
                    outputs: &[],
                    ignored: true,
                }
            }
        }
    }

    /// Whether the present state has a transition for `event`.
    #[must_use]
    pub fn accepts(&self, event: EventId) -> bool {
        self.cell(self.state(), event).is_some()
    }

    /// The present state.
    #[must_use]
    pub fn state(&self) -> StateId {
        StateId(self.present)
    }

    /// The state that the machine starts in.
    #[must_use]
    pub fn initial(&self) -> StateId {
        StateId(self.initial)
    }

    /// How many inputs were ignored since the machine was made.
    #[must_use]
    pub fn ignored(&self) -> u64 {
        self.ignored
    }

    /// Back to the initial state, without firing anything.
    pub fn reset(&mut self) {
        self.present = self.initial;
    }

    /// Continues in `state`, without firing anything; `false`, and no change, if this machine has
    /// no such state.
    pub fn restart_in(&mut self, state: StateId) -> bool {
        let known = state.index() < self.states.len();
        if known {
            self.present = state.0;
        }
        known
    }

    /// The machine's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The name of a state, or `?` for an id of another machine.
    #[must_use]
    pub fn state_name(&self, state: StateId) -> &str {
        self.states.get(state.index()).map_or("?", |name| name)
    }

    /// The id of the state called `name`. Searches; meant for start-up.
    #[must_use]
    pub fn state_id(&self, name: &str) -> Option<StateId> {
        let index = self.states.iter().position(|state| **state == *name)?;
        Some(StateId(index as u16))
    }

    /// The id of the input called `name`, if a transition uses it. Searches; meant for start-up.
    #[must_use]
    pub fn input(&self, name: &str) -> Option<EventId> {
        id_of(&self.inputs, name)
    }

    /// The name of an input, or `?` if no transition uses that event.
    #[must_use]
    pub fn input_name(&self, event: EventId) -> &str {
        name_of(&self.inputs, event)
    }

    /// The id of the output called `name`, if a transition fires it. Searches; meant for start-up.
    #[must_use]
    pub fn output(&self, name: &str) -> Option<OutputId> {
        id_of(&self.output_names, name)
    }

    /// The name of an output, or `?` if no transition fires that event.
    #[must_use]
    pub fn output_name(&self, event: OutputId) -> &str {
        name_of(&self.output_names, event)
    }

    /// All states with their names, in the model's order.
    pub fn states(&self) -> impl Iterator<Item = (StateId, &str)> {
        let numbered = self.states.iter().enumerate();
        numbered.map(|(index, name)| (StateId(index as u16), &**name))
    }

    /// All inputs with their names, in the order of their first use.
    pub fn inputs(&self) -> impl Iterator<Item = (EventId, &str)> {
        self.inputs.iter().map(|(id, name)| (*id, &**name))
    }

    /// All outputs with their names, in the order of their ids.
    pub fn outputs(&self) -> impl Iterator<Item = (OutputId, &str)> {
        self.output_names.iter().map(|(id, name)| (*id, &**name))
    }

    /// All transitions, by state and then by input.
    pub fn transitions(&self) -> impl Iterator<Item = Transition<'_>> {
        self.states().flat_map(move |(from, _)| {
            self.inputs().filter_map(move |(on, _)| {
                let cell = self.cell(from, on)?;
                Some(Transition {
                    from,
                    on,
                    to: StateId(cell.to),
                    outputs: self.outputs_of(cell),
                })
            })
        })
    }

    fn cell(&self, from: StateId, event: EventId) -> Option<Cell> {
        let column = *self.columns.get(event.index())?;
        if column == NO_COLUMN {
            return None;
        }
        let cell = self.cells[from.index() * self.inputs.len() + usize::from(column)];
        (cell.to != NO_STATE).then_some(cell)
    }

    fn outputs_of(&self, cell: Cell) -> &[OutputId] {
        &self.outputs[usize::from(cell.first_output)..usize::from(cell.end_output)]
    }
}

fn id_of(names: &[(EventId, Box<str>)], wanted: &str) -> Option<EventId> {
    let (id, _) = names.iter().find(|(_, name)| **name == *wanted)?;
    Some(*id)
}

fn name_of(names: &[(EventId, Box<str>)], wanted: EventId) -> &str {
    names
        .iter()
        .find(|(id, _)| *id == wanted)
        .map_or("?", |(_, name)| name)
}
