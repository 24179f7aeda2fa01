//! How fast nets are made and run: the five families of the paper's evaluation.
//!
//! ```sh
//! cargo run --release -p coordination --example petri_families
//! cargo run --release -p coordination --example petri_families -- --baseline
//! cargo run --release -p coordination --example petri_families -- --shipped
//! cargo run --release -p coordination --example petri_families -- --bounded
//! cargo run --release -p coordination --example petri_families -- --check
//! ```
//!
//! Without arguments, and with `--baseline`, standard output is a table of comma-separated values,
//! `family,p,mode,ns_per_evaluation,p99,firings_per_evaluation,ns_per_firing`. Modes: `generate` (an
//! executor is made from the model; the last three columns are empty), `one` (each evaluation fires
//! one transition), `saturated` (each evaluation goes on until every enabled transition has fired in
//! it). `--baseline` also measures an executor written plainly in C as Fig. 4 of the paper describes it,
//! in turns with ours: its lines have the modes `baseline-generate`, `baseline-one` and
//! `baseline-saturated`, and standard error gets a table of the ratios.
//!
//! What `generate` contains: the model has its names resolved already, since it does that while it is
//! built. From there both sides check it in the same way (sizes, names, marks, ends, bindings, arcs)
//! and number its places and transitions, which the mode `check` is alone. Then ours enters the net's
//! events into a table, lays the net out, and makes an executor, which keeps the net to reset itself,
//! for reports, and for further executors; the plain one fills its arrays, from numbers that were
//! brought into its form outside of the timed part. To drop them again is not timed.
//!
//! A figure is the median of many slices of batches of 2,000 evaluations; `p99` is their 99th percentile,
//! which says more of other programs on the machine than of ours. Before each batch, outside of the
//! timed part, the marking is perturbed at random, and what fires is compared with a simple
//! executor on sets.
//!
//! `--shipped` times whole steps of the nets in `config/nets/`, each as a mediator runs it: flags of its
//! robots are read, the net fires, its flags are set. Places and transitions are declared in random order.
//! Steps of many copies of the net are timed together, so that most have something to do; `idle` is a step
//! that has nothing to do.
//!
//! `--bounded` shows that the longest evaluation grows with its budget and not with the net.
//! `--check` compares ratios with thresholds that have wide margins, and fails with a sentence for
//! each that is missed; it takes a few seconds. Where there is no C compiler nothing is compared, and
//! that is said.

mod bounded;
mod check;
mod families;
mod figure_4;
mod measure;
mod random;
#[path = "../../tests/petri_reference/reference.rs"]
#[allow(dead_code, reason = "events are not measured")]
mod reference;
mod shipped;
mod steps;

use std::process::ExitCode;
use std::time::Duration;

use families::Family;
use figure_4::Rival;
use measure::{Effort, Figures, Mode};

const USAGE: &str = "usage: petri_families [--baseline | --shipped | --bounded | --check]";

const EFFORT: Effort = Effort {
    least: 7,
    most: 101,
    time: Duration::from_millis(400),
};

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => families(None),
        ["--baseline"] => families(rival().as_ref()),
        ["--shipped"] => shipped(),
        ["--bounded"] => bounded::print(),
        ["--check"] if check::passes(rival().as_ref()) => {}
        ["--check"] => return ExitCode::FAILURE,
        ["--help" | "-h"] => println!("{USAGE}"),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

/// The plain executor, if there is a C compiler.
fn rival() -> Option<Rival> {
    let rival = Rival::compile();
    rival
        .inspect_err(|error| eprintln!("not compared with an executor in C: {error}"))
        .ok()
}

fn families(rival: Option<&Rival>) {
    println!("family,p,mode,ns_per_evaluation,p99,firings_per_evaluation,ns_per_firing");
    if rival.is_some() {
        eprintln!("family,p,generate,one,saturated   (the plain executor's time by ours)");
    }
    for family in Family::ALL {
        let name = family.name();
        for &p in family.scales() {
            let model = family.model(p);
            let mut ratios = Vec::new();
            let generation = measure::generation(&model, rival, EFFORT);
            println!("{name},{p},generate,{:.0},,,", generation.ours);
            println!("{name},{p},check,{:.0},,,", generation.check);
            if let Some(theirs) = generation.theirs {
                println!("{name},{p},baseline-generate,{theirs:.0},,,");
                ratios.push(theirs / generation.ours);
            }
            for mode in [Mode::One, Mode::Saturated] {
                let (ours, theirs) = measure::evaluation(&model, mode, rival, EFFORT);
                line(family, p, mode.name(), &ours);
                if let Some(theirs) = theirs {
                    line(family, p, &format!("baseline-{}", mode.name()), &theirs);
                    ratios.push(theirs.ns_per_firing() / ours.ns_per_firing());
                }
            }
            if let [generate, one, saturated] = ratios[..] {
                eprintln!("{name},{p},{generate:.2},{one:.2},{saturated:.2}");
            }
        }
    }
}

fn shipped() {
    println!("net,ns_per_step,p99,firings_per_step,ns_per_firing,ns_per_idle_step");
    for net in shipped::all() {
        let found = steps::measure(&net, EFFORT);
        println!(
            "{},{:.1},{:.1},{:.2},{:.1},{:.1}",
            net.name,
            found.ns_per_step,
            found.tail_ns_per_step,
            found.firings_per_step,
            found.ns_per_firing,
            found.ns_per_idle_step,
        );
    }
}

fn line(family: Family, p: usize, mode: &str, figures: &Figures) {
    println!(
        "{},{p},{mode},{:.2},{:.2},{:.2},{:.3}",
        family.name(),
        figures.ns_per_evaluation,
        figures.tail_ns_per_evaluation,
        figures.firings_per_evaluation,
        figures.ns_per_firing(),
    );
}
