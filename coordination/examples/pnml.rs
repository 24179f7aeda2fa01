//! Reads a PNML file, says what the analysis finds, and lets the net run for some steps:
//!
//! ```sh
//! cargo run -p coordination --features pnml --example pnml -- coordination/tests/pnml/printer.pnml
//! ```
//!
//! PNML cannot say where a net may end. Names behind the file are the places that are marked then, as the final place
//! of a workflow; without them, a place that nothing empties is refused:
//!
//! ```sh
//! cargo run -p coordination --features pnml --example pnml -- coordination/tests/pnml/workflow.pnml paid sent
//! ```
//!
//! Without a file it writes a gate of its own as PNML, which other tools can open:
//!
//! ```sh
//! cargo run -p coordination --features pnml --example pnml > gate.pnml
//! ```

use std::error::Error;
use std::process::ExitCode;

use coordination::analysis::{Limits, Liveness, check, properties};
use coordination::event::EventTable;
use coordination::petri::{Binding, Budget, ModelError, NetModel, TransitionId};
use coordination::pnml::{Document, read_all};

/// How many firings are shown.
const SHOWN: usize = 20;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// The file, and the places that are marked at the end; nothing: a gate is written.
///
/// # Errors
/// If there is no such file, or it has no net that can be checked.
pub fn run(arguments: &[&str]) -> Result<(), Box<dyn Error>> {
    let Some((file, end)) = arguments.split_first() else {
        print!("{}", Document::new(&gate())?);
        return Ok(());
    };
    let text = std::fs::read_to_string(file)?;
    for mut net in read_all(&text)? {
        if !end.is_empty() {
            net.end("end", end);
        }
        show(&net)?;
    }
    Ok(())
}

fn show(model: &NetModel) -> Result<(), Box<dyn Error>> {
    let (places, transitions) = (model.places().len(), model.transitions().len());
    println!(
        "net `{}`: {places} places, {transitions} transitions",
        model.name()
    );
    // Nets of other tools know no events from outside, so they may go on without them.
    let mut closed = model.clone();
    closed.allow_endless();
    match check(&closed, &[], &Limits::default()) {
        Ok(proof) => {
            let report = proof.report();
            println!(
                "it may run: {} states, {} steps",
                report.states, report.steps
            );
            report
                .warnings
                .iter()
                .for_each(|warning| println!("but {warning}"));
        }
        Err(refusal) => println!("it may not run: {refusal}"),
    }
    let net = match model.compile(&mut EventTable::new()) {
        Ok(net) => net,
        Err(errors) => return explain(model, &errors),
    };
    let mut executor = net.executor();
    let mut fired = [TransitionId(0); SHOWN];
    let budget = Budget {
        rounds: SHOWN as u32,
        ..Budget::default()
    };
    let evaluation = executor.evaluate_traced(budget, &mut fired);
    let names = fired.iter().take(evaluation.fired as usize);
    let names: Vec<&str> = names.map(|&t| net.transition_name(t)).collect();
    println!("by itself it fires: {}", names.join(", "));
    let marked: Vec<&str> = executor
        .marking()
        .map(|place| net.place_name(place))
        .collect();
    println!("then marked are: {}", marked.join(", "));
    Ok(())
}

/// Says of a net that does not compile what is true of it, and what would help.
fn explain(model: &NetModel, errors: &[ModelError]) -> Result<(), Box<dyn Error>> {
    let is_open = |error: &ModelError| matches!(error, ModelError::UnboundSink { .. });
    if errors.iter().any(is_open) {
        println!(
            "if it may end there, name the places that are marked then, behind the file; that is not in PNML"
        );
    }
    let found = properties(model, &[], &Limits::default(), &[])?;
    println!(
        "as it stands: {} states, {} steps",
        found.states, found.steps
    );
    if let Some(deadlock) = &found.deadlock {
        println!("it stops after: {deadlock}");
    }
    let dead = { found.transitions.iter() }.filter(|(_, liveness)| *liveness == Liveness::Dead);
    for (transition, _) in dead {
        println!("`{transition}` never fires");
    }
    Ok(())
}

/// A gate that lets one robot in at a time.
fn gate() -> NetModel {
    let mut gate = NetModel::new("gate");
    gate.place("free").mark("free").place("inside");
    gate.source("asked", Binding::event("ask"));
    gate.sink("may", Binding::event("go"));
    gate.source("left", Binding::event("leave"));
    gate.transition("enter", &["asked", "free"], &["inside", "may"]);
    gate.transition("leave", &["inside", "left"], &["free"]);
    gate.exclusion("one", &["free", "inside"])
        .end("idle", &["free"]);
    gate
}
