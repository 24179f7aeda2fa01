//! How fast nets are made and run: the five families of the paper's evaluation.
//!
//! ```sh
//! cargo run --release -p coordination --example petri_families
//! cargo run --release -p coordination --example petri_families -- --baseline
//! cargo run --release -p coordination --example petri_families -- --bounded
//! cargo run --release -p coordination --example petri_families -- --check
//! ```
//!
//! Without arguments, and with `--baseline`, standard output is a table of comma-separated values,
//! `family,p,mode,ns_per_evaluation,firings_per_evaluation,ns_per_firing`. Modes: `generate` (an
//! executor is made from the model; the last two columns are empty), `one` (each evaluation fires
//! one transition), `saturated` (each evaluation goes on until every enabled transition has fired in
//! it). `--baseline` also measures an executor written plainly as Fig. 4 of the paper describes it,
//! in turns with ours: its lines have the modes `baseline-generate`, `baseline-one` and
//! `baseline-saturated`, and standard error gets a table of the ratios.
//!
//! What `generate` contains: the model has its names resolved already, since it does that while it is
//! built. From there both sides check it in the same way (sizes, names, marks, ends, bindings, arcs)
//! and number its places and transitions. Then ours enters the net's events into a table, lays the
//! net out, and makes an executor, which keeps the net to reset itself, for reports, and for further
//! executors; the one of Fig. 4 fills its arrays. It has less to lay out: it looks at inputs only, while
//! ours looks at outputs too. To drop them again is not timed.
//!
//! A figure is the median of many batches of 2,000 evaluations. Before each batch, outside of the
//! timed part, the marking is perturbed at random, and what fires is compared with a simple
//! executor on sets.
//!
//! `--bounded` shows that the longest evaluation grows with its budget and not with the net.
//! `--check` compares ratios with thresholds that have wide margins, and fails with a sentence for
//! each that is missed; it takes a few seconds.

mod bounded;
mod check;
mod families;
mod figure_4;
mod measure;
#[path = "../../tests/petri_reference/reference.rs"]
#[allow(dead_code, reason = "events are not measured")]
mod reference;

use std::process::ExitCode;
use std::time::Duration;

use families::Family;
use measure::{Effort, Figures, Mode};

const USAGE: &str = "usage: petri_families [--baseline | --bounded | --check]";

const EFFORT: Effort = Effort {
    least: 7,
    most: 101,
    time: Duration::from_millis(400),
};

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => families(false),
        ["--baseline"] => families(true),
        ["--bounded"] => bounded::print(),
        ["--check"] if check::passes() => {}
        ["--check"] => return ExitCode::FAILURE,
        ["--help" | "-h"] => println!("{USAGE}"),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

fn families(baseline: bool) {
    println!("family,p,mode,ns_per_evaluation,firings_per_evaluation,ns_per_firing");
    if baseline {
        eprintln!("family,p,generate,one,saturated   (baseline's time by ours)");
    }
    for family in Family::ALL {
        for &p in family.scales() {
            let model = family.model(p);
            let mut ratios = Vec::new();
            let (ours, theirs) = measure::generation(&model, baseline, EFFORT);
            println!("{},{p},generate,{ours:.0},,", family.name());
            if let Some(theirs) = theirs {
                println!("{},{p},baseline-generate,{theirs:.0},,", family.name());
                ratios.push(theirs / ours);
            }
            for mode in [Mode::One, Mode::Saturated] {
                let (ours, theirs) = measure::evaluation(&model, mode, baseline, EFFORT);
                line(family, p, mode.name(), &ours);
                if let Some(theirs) = theirs {
                    line(family, p, &format!("baseline-{}", mode.name()), &theirs);
                    ratios.push(theirs.ns_per_firing() / ours.ns_per_firing());
                }
            }
            if let [generate, one, saturated] = ratios[..] {
                let family = family.name();
                eprintln!("{family},{p},{generate:.2},{one:.2},{saturated:.2}");
            }
        }
    }
}

fn line(family: Family, p: usize, mode: &str, figures: &Figures) {
    println!(
        "{},{p},{mode},{:.2},{:.2},{:.3}",
        family.name(),
        figures.ns_per_evaluation,
        figures.firings_per_evaluation,
        figures.ns_per_firing(),
    );
}
