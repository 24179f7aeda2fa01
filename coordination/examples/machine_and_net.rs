//! A machine and its net, side by side: the docking of a robot as a state machine, the equivalent Petri
//! net (the paper's Figure 2), and the machine of that net. The same events lead all three to the same
//! states, and they say the same.
//!
//! ```sh
//! cargo run -p coordination --example machine_and_net
//! ```

use std::error::Error;
use std::process::ExitCode;

use coordination::event::{EventId, EventTable};
use coordination::fsm::{Machine, MachineModel, OfNetLimits};
use coordination::petri::{Budget, Executor, Net};

fn main() -> ExitCode {
    let events = [
        "go", "seen", "lost", "go", "seen", "contact", "seen", "full", "clear",
    ];
    match run(&events) {
        Ok(lines) => {
            lines.iter().for_each(|line| println!("{line}"));
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// A robot finds a charger, docks, charges and leaves.
fn docking() -> MachineModel {
    let mut model = MachineModel::new("docking");
    for state in ["idle", "searching", "approaching", "charging", "leaving"] {
        model.state(state);
    }
    model.initial("idle");
    model.transition("idle", "go", "searching", &["turn"]);
    model.transition("searching", "seen", "approaching", &["drive"]);
    model.transition("approaching", "lost", "idle", &["stop"]);
    model.transition("approaching", "contact", "charging", &["stop", "charge"]);
    model.transition("charging", "full", "leaving", &["back off"]);
    model.transition("leaving", "clear", "idle", &["stop"]);
    model
}

/// Offers `inputs` one by one to the machine, to its net and to the net's machine. A line for each.
///
/// # Errors
/// If the three do not agree, which the tests show never to happen; or if an event is unknown.
pub fn run(inputs: &[&str]) -> Result<Vec<String>, Box<dyn Error>> {
    let mut events = EventTable::new();
    let mut machine = docking().compile(&mut events)?;
    let net = { machine.to_net() }
        .compile(&mut events)
        .map_err(|errors| errors[0].to_string())?;
    let mut executor = net.executor();
    let again = MachineModel::of_net(&net, &OfNetLimits::default())?;
    let mut again = again.compile(&mut events)?;

    let mut lines = vec![format!(
        "{} states and {} transitions; as a net {} places and {} transitions",
        machine.states().count(),
        machine.transitions().count(),
        net.places().len(),
        net.transitions().len()
    )];
    for &input in inputs {
        let event = events.id(input).ok_or_else(|| format!("no `{input}`"))?;
        let (state, outputs) = step(&mut machine, event);
        let of_net = fire(&mut executor, &net, event)?;
        let of_again = step(&mut again, event);
        let names = |outputs: &[EventId]| -> Vec<String> {
            let name = |&id| events.name(id).unwrap_or("?").to_owned();
            let mut names: Vec<String> = outputs.iter().map(name).collect();
            // A net knows no order among the outputs of one step.
            names.sort();
            names
        };
        let expected = names(&outputs);
        for other in [&of_net, &of_again] {
            if other.0 != state || names(&other.1) != expected {
                return Err(format!("after `{input}` they differ: {state}, {other:?}").into());
            }
        }
        let says = match expected.is_empty() {
            true => "nothing".to_owned(),
            false => expected.join(", "),
        };
        lines.push(format!("{input:8} -> {state:12} says {says}"));
    }
    Ok(lines)
}

fn step(machine: &mut Machine, event: EventId) -> (String, Vec<EventId>) {
    let outputs = machine.step(event).outputs.to_vec();
    (machine.state_name(machine.state()).to_owned(), outputs)
}

/// The place that is marked then, and the events of the full sinks.
fn fire(
    executor: &mut Executor,
    net: &Net,
    event: EventId,
) -> Result<(String, Vec<EventId>), Box<dyn Error>> {
    executor.offer(event)?;
    executor.evaluate(Budget::default());
    let mut outputs = Vec::new();
    executor.drain_sinks(|output| {
        outputs.push(output);
        true
    });
    let marked: Vec<&str> = { executor.marking() }
        .map(|place| net.place_name(place))
        .collect();
    Ok((marked.join(", "), outputs))
}
