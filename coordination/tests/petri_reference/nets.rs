//! Random nets that keep running: processes with conflicts that share resources, wait for events
//! and produce them; and nets of random arcs, which mostly get stuck.

use coordination::petri::{Binding, NetModel};
use proptest::prelude::*;

/// A small, fast, repeatable source of numbers.
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, limit: usize) -> usize {
        // Xorshift64*.
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let number = self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33;
        number as usize % limit
    }

    pub fn chance(&mut self, percent: usize) -> bool {
        self.below(100) < percent
    }
}

/// What a random net is made of.
#[derive(Clone, Debug)]
pub struct Recipe {
    pub seed: u64,
    pub processes: usize,
    pub resources: usize,
    /// Places and transitions with random arcs only.
    pub wild: usize,
    /// In percent of the transitions.
    pub sources: usize,
    pub sinks: usize,
    pub self_loops: usize,
    pub conflicts: usize,
    /// In percent of the transitions: those that wait for the one common source or fill the one
    /// common sink.
    pub common: usize,
    /// Declare all transitions in random order.
    pub shuffled: bool,
}

pub fn recipe(most_processes: usize, most_resources: usize) -> impl Strategy<Value = Recipe> {
    (
        1..u64::MAX,
        1..=most_processes,
        0..=most_resources,
        0..=most_processes,
        (
            0..30_usize,
            0..30_usize,
            0..20_usize,
            0..40_usize,
            0..15_usize,
        ),
        any::<bool>(),
    )
        .prop_map(|(seed, processes, resources, wild, percents, shuffled)| {
            let (sources, sinks, self_loops, conflicts, common) = percents;
            Recipe {
                seed,
                processes,
                resources,
                wild,
                sources,
                sinks,
                self_loops,
                conflicts,
                common,
                shuffled,
            }
        })
}

#[derive(Default)]
struct Step {
    inputs: Vec<String>,
    outputs: Vec<String>,
}

/// How many different events there are, for sources and for sinks.
pub const EVENTS: usize = 4;

pub fn net(recipe: &Recipe) -> NetModel {
    let random = &mut Random(recipe.seed);
    let mut model = NetModel::new("random");
    for resource in 0..recipe.resources {
        model.place(format!("r{resource}"));
        model.mark(&format!("r{resource}"));
    }
    let mut steps = Vec::new();
    for process in 0..recipe.processes {
        add_process(&mut model, &mut steps, process, recipe, random);
    }
    add_wild(&mut model, &mut steps, recipe, random);
    for resource in 0..recipe.resources {
        // At least one transition touches every resource.
        let step = &mut steps[random.below(recipe.processes)];
        let name = format!("r{resource}");
        if !step.inputs.contains(&name) && !step.outputs.contains(&name) {
            step.inputs.push(name.clone());
            step.outputs.push(name);
        }
    }
    for (number, step) in steps.iter_mut().enumerate() {
        add_ends(&mut model, step, number, recipe, random);
    }
    add_common(&mut model, &mut steps, recipe, random);
    if recipe.shuffled {
        for number in (1..steps.len()).rev() {
            steps.swap(number, random.below(number + 1));
        }
    }
    for (number, step) in steps.iter().enumerate() {
        let inputs: Vec<_> = step.inputs.iter().map(String::as_str).collect();
        let outputs: Vec<_> = step.outputs.iter().map(String::as_str).collect();
        model.transition(format!("t{number}"), &inputs, &outputs);
    }
    model
}

/// A cycle of states that takes some resources and gives them back, with some other ways round.
fn add_process(
    model: &mut NetModel,
    steps: &mut Vec<Step>,
    process: usize,
    recipe: &Recipe,
    random: &mut Random,
) {
    let length = 2 + random.below(4);
    let state = |index: usize| format!("p{process}_{}", index % length);
    for index in 0..length {
        model.place(state(index));
    }
    model.mark(&state(random.below(length)));
    let mut held = Vec::new();
    for index in 0..length {
        let mut step = Step::default();
        step.inputs.push(state(index));
        step.outputs.push(state(index + 1));
        for resource in (0..recipe.resources).map(|resource| format!("r{resource}")) {
            if held.contains(&resource) {
                if index + 1 == length || random.chance(40) {
                    held.retain(|other| *other != resource);
                    step.outputs.push(resource);
                }
            } else if index + 1 < length && random.chance(15.min(200 / recipe.resources)) {
                step.inputs.push(resource.clone());
                held.push(resource);
            } else if random.chance(recipe.self_loops.min(200 / recipe.resources)) {
                step.inputs.push(resource.clone());
                step.outputs.push(resource);
            }
        }
        steps.push(step);
        if random.chance(recipe.conflicts) {
            let to = random.below(length);
            steps.push(Step {
                inputs: vec![state(index)],
                outputs: vec![state(to)],
            });
        }
    }
}

/// Places and transitions with random arcs.
fn add_wild(model: &mut NetModel, steps: &mut Vec<Step>, recipe: &Recipe, random: &mut Random) {
    let count = recipe.wild;
    let name = |index: usize| format!("w{}", index % count);
    for index in 0..count {
        model.place(name(index));
        if random.chance(50) {
            model.mark(&name(index));
        }
    }
    for index in 0..count {
        let mut step = Step::default();
        step.inputs.push(name(index));
        step.outputs.push(name(index + 1));
        for _ in 0..random.below(5) {
            let other = name(random.below(count));
            let side = if random.chance(50) {
                &mut step.inputs
            } else {
                &mut step.outputs
            };
            if !side.contains(&other) {
                side.push(other);
            }
        }
        steps.push(step);
    }
}

fn add_ends(
    model: &mut NetModel,
    step: &mut Step,
    number: usize,
    recipe: &Recipe,
    random: &mut Random,
) {
    if random.chance(recipe.sources) {
        let name = format!("in{number}");
        let event = Binding::event(format!("i{}", random.below(EVENTS)));
        model.source(&name, event);
        if random.chance(20) {
            model.mark(&name);
        }
        step.inputs.push(name);
    }
    if random.chance(recipe.sinks) {
        let name = format!("out{number}");
        let flag = Binding::flag("o", random.below(EVENTS).to_string());
        model.sink(&name, flag);
        if random.chance(10) {
            model.mark(&name);
        }
        step.outputs.push(name);
    }
}

/// A source that many transitions wait for, and a sink that many fill.
fn add_common(model: &mut NetModel, steps: &mut [Step], recipe: &Recipe, random: &mut Random) {
    let (mut waits, mut fills) = (false, false);
    for step in steps {
        if random.chance(recipe.common) {
            step.inputs.push("call".to_owned());
            waits = true;
        }
        if random.chance(recipe.common) {
            step.outputs.push("bell".to_owned());
            fills = true;
        }
    }
    if waits {
        model.source("call", Binding::event("i0"));
    }
    if fills {
        model.sink("bell", Binding::flag("o", "0"));
    }
}
