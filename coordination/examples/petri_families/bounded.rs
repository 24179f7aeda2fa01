//! The longest evaluation under a budget, for nets of 10 to 10,000 places.

use std::hint::black_box;
use std::time::Instant;

use coordination::event::EventTable;
use coordination::petri::Budget;

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
            for firings in FIRINGS {
                line(family, wanted, firings);
            }
        }
    }
}

fn line(family: Family, wanted: usize, firings: u32) {
    let p = match family {
        Family::Seq | Family::Pr1 => wanted / 2,
        Family::P1r | Family::Ph => wanted / 3,
        // Nearly p² places.
        Family::Square => wanted.isqrt(),
    };
    let model = family.model(p);
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
                assert_eq!(evaluation.fired, firings);
                time.as_nanos()
            });
            times.min().expect("there are repeats")
        })
        .collect();
    times.sort_unstable();
    let (median, longest) = (times[EVALUATIONS / 2], times[EVALUATIONS - 1]);
    println!(
        "{},{},{firings},{longest},{median},{:.2}",
        family.name(),
        net.places().len(),
        longest as f64 / f64::from(firings),
    );
}
