//! Reads a PNML file, says what the analysis finds, and lets the net run for some steps:
//!
//! ```sh
//! cargo run -p coordination --features pnml --example pnml -- coordination/tests/pnml/printer.pnml
//! ```
//!
//! Without a file it writes a gate of its own as PNML, which other tools can open:
//!
//! ```sh
//! cargo run -p coordination --features pnml --example pnml > gate.pnml
//! ```

use std::error::Error;
use std::process::ExitCode;

use coordination::analysis::{Limits, check};
use coordination::event::EventTable;
use coordination::petri::{Binding, Budget, NetModel, TransitionId};
use coordination::pnml::{Document, read_all};

/// How many firings are shown.
const SHOWN: usize = 20;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let Some(file) = std::env::args_os().nth(1) else {
        print!("{}", Document::new(&gate())?);
        return Ok(());
    };
    let text = std::fs::read_to_string(&file)?;
    for net in read_all(&text)? {
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
    let net = model
        .compile(&mut EventTable::new())
        .map_err(|errors| errors[0].to_string())?;
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
