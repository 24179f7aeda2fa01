//! The machine that is equivalent to a small net: the way back from [`Machine::to_net`](super::Machine::to_net).

mod error;
mod settle;

use alloc::borrow::ToOwned;
use alloc::collections::{BTreeMap, BTreeSet, VecDeque};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

pub use error::OfNetError;
use settle::{Marking, Settled, Settling};

use super::model::MachineModel;
use crate::event::EventId;
use crate::petri::{Binding, Net, PlaceId};

/// How large a machine of a net may become, and what becomes of events that the net cannot use yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OfNetLimits {
    /// The most states.
    pub states: usize,
    /// The most markings that are looked at on the way from state to state.
    pub markings: usize,
    /// What happens with an event that stays in its source.
    pub unused: Unused,
}

impl Default for OfNetLimits {
    fn default() -> Self {
        Self {
            states: 1_024,
            markings: 65_536,
            unused: Unused::Refuse,
        }
    }
}

/// What becomes of an event that no transition uses when it comes. A net keeps it and counts further ones, which no machine does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unused {
    /// Such a net has no machine: [`OfNetError::Unused`].
    #[default]
    Refuse,
    /// It is forgotten, as by [`Executor::void_source`](crate::petri::Executor::void_source) after each event.
    Forget,
    /// It is kept, so that a full source is part of the state's name; while one of its sources is full the event is ignored, as
    /// by someone who offers it only when it can be taken.
    Keep,
}

impl MachineModel {
    /// The machine that does what `net` does when events are offered one at a time: the net is evaluated until it is quiet, its
    /// sinks are emptied, and so on until nothing happens any more.
    ///
    /// States are the markings of internal places that are reached so, named by their marked places, joined by ` + `; `-` if none
    /// is marked. Inputs are the events of sources, outputs the events of sinks. A net knows no order among the sinks that
    /// it fills; the machine fires what they hold in the order of their declaration. An input that changes nothing has a transition if the
    /// net consumes it, and none if it is [forgotten](Unused::Forget).
    ///
    /// The number of states grows exponentially with the tokens of a net. Not for real-time threads.
    ///
    /// # Errors
    /// What no machine can express, or more states than `limits` allows: see [`OfNetError`].
    ///
    /// ```
    /// use coordination::event::EventTable;
    /// use coordination::fsm::{MachineModel, OfNetLimits, Unused};
    /// use coordination::petri::{Binding, NetModel};
    ///
    /// let mut gate = NetModel::new("gate");
    /// gate.source("asked", Binding::event("ask")).sink("granted", Binding::event("grant"));
    /// gate.place("free").mark("free").place("taken");
    /// gate.source("left", Binding::event("leave"));
    /// gate.transition("enter", &["asked", "free"], &["taken", "granted"]);
    /// gate.transition("leave", &["left", "taken"], &["free"]);
    ///
    /// let mut events = EventTable::new();
    /// let net = gate.compile(&mut events).expect("the model is sound");
    /// let limits = OfNetLimits { unused: Unused::Forget, ..OfNetLimits::default() };
    /// let mut machine = MachineModel::of_net(&net, &limits)?.compile(&mut events)?;
    /// let step = machine.step(events.id("ask").expect("the net uses it"));
    /// assert_eq!(step.outputs, [events.id("grant").expect("the net uses it")]);
    /// assert_eq!(machine.state_name(machine.state()), "taken");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of_net(net: &Net, limits: &OfNetLimits) -> Result<Self, OfNetError> {
        refuse_flags(net)?;
        let mut search = Search {
            net,
            limits,
            settling: Settling::new(net, limits.markings),
            numbers: BTreeMap::new(),
            names: BTreeSet::new(),
            states: Vec::new(),
            waiting: VecDeque::new(),
            model: Self::new(net.name()),
        };
        search.run()?;
        Ok(search.model)
    }
}

fn refuse_flags(net: &Net) -> Result<(), OfNetError> {
    let model = net.model();
    let flag = model.places().find_map(|place| match place.binding {
        Some(binding @ Binding::Flag { .. }) => Some((place.name.to_owned(), binding.event_name())),
        _ => None,
    });
    flag.map_or(Ok(()), |(place, flag)| {
        Err(OfNetError::Flag {
            net: net.name().to_owned(),
            place,
            flag,
        })
    })
}

/// From state to state, breadth first.
struct Search<'a> {
    net: &'a Net,
    limits: &'a OfNetLimits,
    settling: Settling<'a>,
    numbers: BTreeMap<Marking, usize>,
    names: BTreeSet<String>,
    /// Names, by number.
    states: Vec<String>,
    waiting: VecDeque<Marking>,
    model: MachineModel,
}

impl Search<'_> {
    fn run(&mut self) -> Result<(), OfNetError> {
        let inputs = inputs(self.net);
        let first = Marking::initial(self.net);
        let start = Where {
            event: "the start",
            state: self.describe(&first),
        };
        let Settled { at, outputs, .. } = self.settle(first, &start)?;
        if let Some(output) = outputs.first() {
            return Err(OfNetError::FiresAtStart {
                net: self.net.name().to_owned(),
                output: output_name(self.net, *output),
            });
        }
        let at = self.without_unused(at, &start)?;
        let initial = self.number(at)?;
        self.model.initial(&self.states[initial]);
        while let Some(state) = self.waiting.pop_front() {
            let from = self.number(state.clone())?;
            for (name, sources) in &inputs {
                if sources.iter().any(|&source| state.has(source)) {
                    continue;
                }
                let mut offered = state.clone();
                for &source in sources {
                    offered.flip(source);
                }
                let wherever = Where {
                    event: name,
                    state: self.states[from].clone(),
                };
                let settled = self.settle(offered, &wherever)?;
                let at = self.without_unused(settled.at, &wherever)?;
                if !settled.fired && at == state {
                    continue;
                }
                let to = self.number(at)?;
                let outputs = settled.outputs.iter();
                let outputs: Vec<String> =
                    outputs.map(|&sink| output_name(self.net, sink)).collect();
                let outputs: Vec<&str> = outputs.iter().map(String::as_str).collect();
                let (from, to) = (&self.states[from], &self.states[to]);
                self.model.transition(from, name, to, &outputs);
            }
        }
        Ok(())
    }

    fn settle(&mut self, from: Marking, wherever: &Where<'_>) -> Result<Settled, OfNetError> {
        let net = || self.net.name().to_owned();
        let (event, state) = (wherever.event(), wherever.state.clone());
        match self.settling.settle(from) {
            Ok(settled) => Ok(settled),
            Err(settle::Failure::Endless) => Err(OfNetError::Endless {
                net: net(),
                event,
                state,
            }),
            Err(settle::Failure::Undetermined(both)) => {
                let [first, second] = both.map(|one| self.describe_settled(&one));
                Err(OfNetError::Undetermined {
                    net: net(),
                    event,
                    state,
                    first,
                    second,
                })
            }
            Err(settle::Failure::TooMany) => Err(OfNetError::TooManyMarkings {
                net: net(),
                limit: self.limits.markings,
            }),
        }
    }

    /// What `Unused` makes of events that are left in their sources.
    fn without_unused(&self, mut at: Marking, wherever: &Where<'_>) -> Result<Marking, OfNetError> {
        for &(source, _) in self.net.sources() {
            if !at.has(source) {
                continue;
            }
            match self.limits.unused {
                Unused::Keep => {}
                Unused::Forget => at.flip(source),
                Unused::Refuse => {
                    return Err(OfNetError::Unused {
                        net: self.net.name().to_owned(),
                        event: wherever.event(),
                        state: wherever.state.clone(),
                        source_place: self.net.place_name(source).to_owned(),
                    });
                }
            }
        }
        Ok(at)
    }

    /// The number of a state, which is named, and looked at later, if it is new.
    fn number(&mut self, at: Marking) -> Result<usize, OfNetError> {
        if let Some(&number) = self.numbers.get(&at) {
            return Ok(number);
        }
        if self.states.len() >= self.limits.states {
            return Err(OfNetError::TooManyStates {
                net: self.net.name().to_owned(),
                limit: self.limits.states,
            });
        }
        let mut name = self.describe(&at);
        // Names of places may hold a ` + ` themselves.
        while !self.names.insert(name.clone()) {
            name.push('\'');
        }
        self.model.state(&name);
        self.states.push(name);
        self.numbers.insert(at.clone(), self.states.len() - 1);
        self.waiting.push_back(at);
        Ok(self.states.len() - 1)
    }

    fn describe(&self, at: &Marking) -> String {
        let marked = self.net.places().filter(|&place| at.has(place));
        let names: Vec<&str> = marked.map(|place| self.net.place_name(place)).collect();
        if names.is_empty() {
            return "-".to_owned();
        }
        names.join(" + ")
    }

    fn describe_settled(&self, settled: &Settled) -> String {
        let outputs = settled.outputs.iter();
        let outputs: Vec<String> = outputs.map(|&sink| output_name(self.net, sink)).collect();
        format!(
            "`{}` with [{}]",
            self.describe(&settled.at),
            outputs.join(", ")
        )
    }
}

/// What happened in which state, for messages.
struct Where<'a> {
    event: &'a str,
    state: String,
}

impl Where<'_> {
    fn event(&self) -> String {
        format!("`{}`", self.event)
    }
}

/// The events of sources with the sources that each fills, in the order of the sources.
fn inputs(net: &Net) -> Vec<(String, Vec<PlaceId>)> {
    let model = net.model();
    let places: Vec<_> = model.places().collect();
    let mut numbers: BTreeMap<EventId, usize> = BTreeMap::new();
    let mut inputs: Vec<(String, Vec<PlaceId>)> = Vec::new();
    for &(place, event) in net.sources() {
        let number = *numbers.entry(event).or_insert_with(|| {
            let name = places[place.index()].binding.map(Binding::event_name);
            inputs.push((name.unwrap_or_default(), Vec::new()));
            inputs.len() - 1
        });
        inputs[number].1.push(place);
    }
    inputs
}

fn output_name(net: &Net, sink: PlaceId) -> String {
    let model = net.model();
    let place = model.places().nth(sink.index());
    let binding = place.and_then(|place| place.binding.map(Binding::event_name));
    binding.unwrap_or_default()
}
