//! The longest evaluation under a budget, for nets of 10 to 10,000 places: the five families, and one
//! in which a search has to go as far as it can.

use std::hint::black_box;
use std::time::Instant;

use coordination::event::EventTable;
use coordination::petri::{Budget, NetModel};

use crate::families::Family;

const PLACES: [usize; 4] = [10, 100, 1_000, 10_000];
const FIRINGS: [u32; 5] = [1, 10, 100, 1_000, 10_000];

/// How often each evaluation is repeated from the same state; the shortest time counts, since
/// whatever is longer was disturbed from outside.
const REPEATS: usize = 7;

/// Evaluations one after another, each of which is timed alone.
const EVALUATIONS: usize = 400;

pub fn print() {
    println!("family,places,firings,longest_ns,median_ns,longest_ns_per_firing");
    for family in Family::ALL {
        for wanted in PLACES {
            let p = match family {
                Family::Seq | Family::Pr1 => wanted / 2,
                Family::P1r | Family::Ph => wanted / 3,
                // Nearly p² places.
                Family::Square => wanted.isqrt(),
            };
            let model = family.model(p);
            for firings in FIRINGS {
                line(family.name(), &model, firings);
            }
        }
    }
    for wanted in PLACES.into_iter().chain([60_000]) {
        let model = apart(wanted / 2);
        for firings in &FIRINGS[..4] {
            line("APART", &model, *firings);
        }
    }
}

/// PR1 with its transitions in another order, so that after each taking of the resource all others
/// that wait for it are looked at in vain before the one that gives it back.
fn apart(p: usize) -> NetModel {
    let mut model = NetModel::new("apart");
    model.place("resource").mark("resource");
    for i in 0..p {
        let (idle, using) = (format!("idle{i}"), format!("using{i}"));
        model.place(&idle).mark(&idle).place(&using);
        model.transition(format!("take{i}"), &[&idle, "resource"], &[&using]);
    }
    for i in 0..p {
        let (idle, using) = (format!("idle{i}"), format!("using{i}"));
        model.transition(format!("give{i}"), &[&using], &["resource", &idle]);
    }
    model
}

fn line(name: &str, model: &NetModel, firings: u32) {
    let net = model
        .compile(&mut EventTable::new())
        .expect("the families are sound");
    let budget = Budget {
        firings,
        rounds: u32::MAX,
    };
    let mut executors = vec![net.executor(); REPEATS];
    let mut times: Vec<_> = (0..EVALUATIONS)
        .map(|_| {
            let times = executors.iter_mut().map(|executor| {
                let start = Instant::now();
                let evaluation = black_box(&mut *executor).evaluate(budget);
                let time = start.elapsed();
                assert!(evaluation.fired == firings || evaluation.remaining);
                time.as_nanos()
            });
            times.min().expect("there are repeats")
        })
        .collect();
    times.sort_unstable();
    let (median, longest) = (times[EVALUATIONS / 2], times[EVALUATIONS - 1]);
    println!(
        "{name},{},{firings},{longest},{median},{:.2}",
        net.places().len(),
        longest as f64 / f64::from(firings),
    );
}
