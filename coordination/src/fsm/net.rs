//! The Petri net that is equivalent to a machine.

use alloc::borrow::ToOwned;
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;

use super::machine::{Machine, StateId};
use crate::event::EventId;
use crate::petri::{Binding, NetModel};

impl Machine {
    /// The equivalent net, in the machine's initial state: each state is a place, of which exactly
    /// one is marked; each input a source, called `?input`; each output a sink, called `!output`;
    /// each transition a transition. An input that a state ignores is consumed there by a transition
    /// that leaves the state marked.
    ///
    /// Offered one event at a time, and with its sinks emptied after each, the net is in the same
    /// state as the machine and has fired the same outputs. A net knows no order among the outputs
    /// of one step; nor, if several inputs wait, which of them came first. An output that one step
    /// fires several times has as many sinks. A full sink holds a transition back, which a machine
    /// does not know.
    ///
    /// A machine without transitions makes a net that does not compile, because nothing can happen
    /// in it. Not for real-time threads.
    ///
    /// ```
    /// use coordination::{event::EventTable, fsm::MachineModel};
    ///
    /// let mut model = MachineModel::new("door");
    /// model.state("closed").state("open").initial("closed");
    /// model.transition("closed", "push", "open", &["light_on"]);
    ///
    /// let mut events = EventTable::new();
    /// let door = model.compile(&mut events)?;
    /// let net = door.to_net().compile(&mut events).expect("it has a transition");
    /// let mut door = net.executor();
    /// door.offer(events.id("push").expect("the model uses it"))?;
    /// door.evaluate(Default::default());
    /// assert!(door.is_marked(net.place_id("open").expect("it is a state")));
    /// assert!(door.is_marked(net.place_id("!light_on").expect("it is an output")));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn to_net(&self) -> NetModel {
        let mut names = Names::default();
        let mut net = NetModel::new(self.name());
        let states: Vec<String> = self
            .states()
            .map(|(_, state)| names.unused(state.to_owned()))
            .collect();
        for state in &states {
            net.place(state);
        }
        net.mark(&states[self.initial().index()]);
        if states.len() > 1 {
            let places: Vec<&str> = states.iter().map(String::as_str).collect();
            net.exclusion("one state", &places);
        }
        let sources: Vec<(EventId, String)> = self
            .inputs()
            .map(|(on, input)| (on, names.unused(format!("?{input}"))))
            .collect();
        for (on, source) in &sources {
            net.source(source, Binding::event(self.input_name(*on)));
        }
        let sinks = self.add_sinks(&mut net, &mut names);
        let transitions: BTreeMap<(StateId, EventId), _> = self
            .transitions()
            .map(|transition| ((transition.from, transition.on), transition))
            .collect();
        let mut repeats = BTreeMap::new();
        for (from, state) in self.states() {
            let place = &states[from.index()];
            for (on, source) in &sources {
                let name = names.unused(format!("{state} {source}"));
                let mut outputs = vec![place.as_str()];
                if let Some(transition) = transitions.get(&(from, *on)) {
                    outputs[0] = &states[transition.to.index()];
                    repeats.clear();
                    for output in transition.outputs {
                        let repeat = repeats.entry(*output).or_insert(0_usize);
                        outputs.push(&sinks[output][*repeat]);
                        *repeat += 1;
                    }
                }
                net.transition(&name, &[place, source], &outputs);
            }
        }
        net
    }

    /// A sink for each output, and more for one that a single step fires several times.
    fn add_sinks(&self, net: &mut NetModel, names: &mut Names) -> BTreeMap<EventId, Vec<String>> {
        let mut most: BTreeMap<EventId, usize> = BTreeMap::new();
        let mut count: BTreeMap<EventId, usize> = BTreeMap::new();
        for transition in self.transitions() {
            count.clear();
            for output in transition.outputs {
                *count.entry(*output).or_default() += 1;
            }
            for (&output, &count) in &count {
                let most = most.entry(output).or_default();
                *most = count.max(*most);
            }
        }
        let mut sinks = BTreeMap::new();
        for (output, name) in self.outputs() {
            let numbers = 1..=most.get(&output).copied().unwrap_or_default();
            let places: Vec<String> = numbers
                .map(|number| match number {
                    1 => names.unused(format!("!{name}")),
                    _ => names.unused(format!("!{name} {number}")),
                })
                .collect();
            for place in &places {
                net.sink(place, Binding::event(name));
            }
            sinks.insert(output, places);
        }
        sinks
    }
}

/// Names given so far; states, inputs and outputs may be called as they like.
#[derive(Default)]
struct Names(BTreeSet<String>);

impl Names {
    fn unused(&mut self, mut name: String) -> String {
        while !self.0.insert(name.clone()) {
            name.push('\'');
        }
        name
    }
}
