//! The symbolic model of a machine, and its checks.

use alloc::borrow::ToOwned;
use alloc::boxed::Box;
use alloc::collections::{BTreeMap, BTreeSet, VecDeque};
use alloc::format;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;

use thiserror::Error;

use super::machine::{Cell, Machine, NO_COLUMN, NO_STATE};
use crate::event::{EventId, EventTable, TooManyEvents};
use crate::listed::listed;

/// What is wrong with a [`MachineModel`].
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum ModelError {
    /// The model has no state at all.
    #[error("machine `{machine}` has no states")]
    NoStates { machine: String },
    /// No state was made the initial one.
    #[error("machine `{machine}` has no initial state")]
    NoInitialState { machine: String },
    /// Two different states were made the initial one.
    #[error("machine `{machine}` has two initial states, `{first}` and `{second}`")]
    TwoInitialStates {
        machine: String,
        first: String,
        second: String,
    },
    /// A state or an event has an empty name.
    #[error("machine `{machine}` has {what} without a name")]
    EmptyName { machine: String, what: &'static str },
    /// Two states have the same name.
    #[error("machine `{machine}` has two states named `{state}`")]
    DuplicateState { machine: String, state: String },
    /// A transition or the initial state names a state that does not exist.
    #[error(
        "machine `{machine}`: {place} names the unknown state `{state}`; known states: {known}"
    )]
    UnknownState {
        machine: String,
        place: String,
        state: String,
        known: String,
    },
    /// One state has two transitions for the same event.
    #[error(
        "machine `{machine}`: state `{state}` has two transitions on `{event}`, to `{first}` and to `{second}`"
    )]
    TwoTransitions {
        machine: String,
        state: String,
        event: String,
        first: String,
        second: String,
    },
    /// No sequence of events leads from the initial state to this one.
    #[error("machine `{machine}`: state `{state}` can never be reached from `{initial}`")]
    UnreachableState {
        machine: String,
        state: String,
        initial: String,
    },
    /// The machine is larger than its tables can be.
    #[error("machine `{machine}` has {found} {what}; at most {limit} fit")]
    TooLarge {
        machine: String,
        what: &'static str,
        found: usize,
        limit: usize,
    },
    /// The event table is full.
    #[error("machine `{machine}`: {reason}")]
    Events {
        machine: String,
        reason: TooManyEvents,
    },
}

#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
struct Arc {
    from: String,
    on: String,
    to: String,
    #[cfg_attr(feature = "serde", serde(default))]
    outputs: Vec<String>,
}

/// A machine in names. Adding to it never fails; [`check`](Self::check) and
/// [`compile`](Self::compile) say what is wrong with the whole.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct MachineModel {
    name: String,
    states: Vec<String>,
    initial: Vec<String>,
    #[cfg_attr(feature = "serde", serde(default, rename = "transitions"))]
    arcs: Vec<Arc>,
}

impl MachineModel {
    /// The most states, and the most entries of all output lists together, that a machine has.
    pub const LIMIT: usize = u16::MAX as usize - 1;

    /// The most cells, states times inputs, that a machine's table has.
    pub const CELL_LIMIT: usize = 1 << 20;

    /// A model without states.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            states: Vec::new(),
            initial: Vec::new(),
            arcs: Vec::new(),
        }
    }

    /// The machine's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Adds a state.
    pub fn state(&mut self, name: impl Into<String>) -> &mut Self {
        self.states.push(name.into());
        self
    }

    /// Makes `name`, which is added as a state elsewhere, the initial state.
    pub fn initial(&mut self, name: impl Into<String>) -> &mut Self {
        self.initial.push(name.into());
        self
    }

    /// Adds a transition: in state `from`, input `on` leads to state `to` and fires `outputs` in
    /// their order.
    pub fn transition(&mut self, from: &str, on: &str, to: &str, outputs: &[&str]) -> &mut Self {
        self.arcs.push(Arc {
            from: from.to_owned(),
            on: on.to_owned(),
            to: to.to_owned(),
            outputs: outputs.iter().map(|&output| output.to_owned()).collect(),
        });
        self
    }

    /// Everything that is wrong with the model; nothing if it compiles.
    #[must_use]
    pub fn check(&self) -> Vec<ModelError> {
        let mut errors = Vec::new();
        self.check_names(&mut errors);
        let known: BTreeSet<&str> = self.states.iter().map(String::as_str).collect();
        self.check_initial(&known, &mut errors);
        self.check_transitions(&known, &mut errors);
        if errors.is_empty() {
            self.check_reachable(&mut errors);
        }
        errors
    }

    /// Checks the model and makes the machine, whose events are entered into `events`. After an
    /// error `events` is as before, unless it ran full. Not for real-time threads.
    ///
    /// # Errors
    /// The first problem that [`check`](Self::check) finds, or that the table is full.
    pub fn compile(&self, events: &mut EventTable) -> Result<Machine, ModelError> {
        if let Some(error) = self.check().into_iter().next() {
            return Err(error);
        }
        let mut intern = |name: &str| {
            events.intern(name).map_err(|reason| ModelError::Events {
                machine: self.name.clone(),
                reason,
            })
        };
        let numbers = self.state_numbers();
        let mut columns: Vec<u16> = Vec::new();
        let mut inputs: Vec<(EventId, Box<str>)> = Vec::new();
        let mut output_names: BTreeMap<EventId, Box<str>> = BTreeMap::new();
        let mut outputs: Vec<EventId> = Vec::new();
        let mut rows = Vec::with_capacity(self.arcs.len());
        for arc in &self.arcs {
            let on = intern(&arc.on)?;
            if columns.len() <= on.index() {
                columns.resize(on.index() + 1, NO_COLUMN);
            }
            if columns[on.index()] == NO_COLUMN {
                columns[on.index()] = inputs.len() as u16;
                inputs.push((on, arc.on.as_str().into()));
            }
            let first_output = outputs.len() as u16;
            for name in &arc.outputs {
                let output = intern(name)?;
                output_names
                    .entry(output)
                    .or_insert_with(|| name.as_str().into());
                outputs.push(output);
            }
            let cell = Cell {
                to: numbers[arc.to.as_str()],
                first_output,
                end_output: outputs.len() as u16,
            };
            rows.push((numbers[arc.from.as_str()], columns[on.index()], cell));
        }
        let mut cells = vec![Cell::NONE; self.states.len() * inputs.len()];
        for (from, column, cell) in rows {
            cells[usize::from(from) * inputs.len() + usize::from(column)] = cell;
        }
        let mut output_names: Vec<_> = output_names.into_iter().collect();
        output_names.sort_unstable_by_key(|&(id, _)| id);
        Ok(Machine::new(
            self.name.as_str().into(),
            self.states
                .iter()
                .map(|name| name.as_str().into())
                .collect(),
            numbers[self.initial[0].as_str()],
            inputs.into(),
            output_names.into(),
            columns.into(),
            cells.into(),
            outputs.into(),
        ))
    }

    fn state_numbers(&self) -> BTreeMap<&str, u16> {
        let names = self.states.iter().map(String::as_str);
        names.zip(0..NO_STATE).collect()
    }

    fn check_names(&self, errors: &mut Vec<ModelError>) {
        let machine = || self.name.clone();
        if self.states.is_empty() {
            errors.push(ModelError::NoStates { machine: machine() });
        }
        let mut seen = BTreeSet::new();
        for state in &self.states {
            if state.is_empty() {
                errors.push(ModelError::EmptyName {
                    machine: machine(),
                    what: "a state",
                });
            } else if !seen.insert(state) {
                errors.push(ModelError::DuplicateState {
                    machine: machine(),
                    state: state.clone(),
                });
            }
        }
        let mut event_names = self
            .arcs
            .iter()
            .flat_map(|arc| core::iter::once(&arc.on).chain(&arc.outputs));
        if event_names.any(String::is_empty) {
            errors.push(ModelError::EmptyName {
                machine: machine(),
                what: "an event",
            });
        }
        let outputs = self.arcs.iter().map(|arc| arc.outputs.len()).sum();
        let inputs: BTreeSet<&str> = self.arcs.iter().map(|arc| arc.on.as_str()).collect();
        let cells = self.states.len().saturating_mul(inputs.len());
        for (what, found, limit) in [
            ("states", self.states.len(), Self::LIMIT),
            ("outputs", outputs, Self::LIMIT),
            ("cells of state and input", cells, Self::CELL_LIMIT),
        ] {
            if found > limit {
                errors.push(ModelError::TooLarge {
                    machine: machine(),
                    what,
                    found,
                    limit,
                });
            }
        }
    }

    fn check_initial(&self, known: &BTreeSet<&str>, errors: &mut Vec<ModelError>) {
        match self.initial.split_first() {
            None => errors.push(ModelError::NoInitialState {
                machine: self.name.clone(),
            }),
            Some((first, others)) => {
                if let Some(second) = others.iter().find(|&other| other != first) {
                    errors.push(ModelError::TwoInitialStates {
                        machine: self.name.clone(),
                        first: first.clone(),
                        second: second.clone(),
                    });
                }
                self.check_known(known, first, &|| "the initial state".to_owned(), errors);
            }
        }
    }

    fn check_transitions(&self, known: &BTreeSet<&str>, errors: &mut Vec<ModelError>) {
        let mut targets: BTreeMap<(&str, &str), &str> = BTreeMap::new();
        for arc in &self.arcs {
            let place = || format!("the transition from `{}` on `{}`", arc.from, arc.on);
            self.check_known(known, &arc.from, &place, errors);
            self.check_known(known, &arc.to, &place, errors);
            if let Some(first) = targets.insert((&arc.from, &arc.on), &arc.to) {
                errors.push(ModelError::TwoTransitions {
                    machine: self.name.clone(),
                    state: arc.from.clone(),
                    event: arc.on.clone(),
                    first: first.to_owned(),
                    second: arc.to.clone(),
                });
            }
        }
    }

    fn check_known(
        &self,
        known: &BTreeSet<&str>,
        state: &str,
        place: &dyn Fn() -> String,
        errors: &mut Vec<ModelError>,
    ) {
        if !known.contains(state) {
            errors.push(ModelError::UnknownState {
                machine: self.name.clone(),
                place: place(),
                state: state.to_owned(),
                known: listed(self.states.iter().map(String::as_str)),
            });
        }
    }

    fn check_reachable(&self, errors: &mut Vec<ModelError>) {
        let initial = self.initial[0].as_str();
        let mut next: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for arc in &self.arcs {
            next.entry(&arc.from).or_default().push(&arc.to);
        }
        let mut reached = BTreeSet::from([initial]);
        let mut waiting = VecDeque::from([initial]);
        while let Some(state) = waiting.pop_front() {
            for &to in next.get(state).into_iter().flatten() {
                if reached.insert(to) {
                    waiting.push_back(to);
                }
            }
        }
        for state in &self.states {
            if !reached.contains(state.as_str()) {
                errors.push(ModelError::UnreachableState {
                    machine: self.name.clone(),
                    state: state.clone(),
                    initial: initial.to_owned(),
                });
            }
        }
    }
}
