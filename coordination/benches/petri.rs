//! `cargo bench -p coordination --bench petri [family]`: the five families of nets at p = 20, ours and
//! an executor in C after Fig. 4 of the paper in turns. The example `petri_families` has the full table.

#[path = "../examples/petri_families/families.rs"]
mod families;
#[path = "../examples/petri_families/figure_4.rs"]
mod figure_4;
#[path = "../examples/petri_families/measure.rs"]
mod measure;
#[path = "../examples/petri_families/random.rs"]
mod random;
#[path = "../tests/petri_reference/reference.rs"]
#[allow(dead_code, reason = "events are not measured")]
mod reference;

use std::time::Duration;

use families::Family;
use figure_4::Rival;
use measure::{Effort, Mode};

const P: usize = 20;

const EFFORT: Effort = Effort {
    least: 7,
    most: 101,
    time: Duration::from_millis(400),
};

fn main() {
    // Cargo adds `--bench`; anything else picks families by name.
    let wanted: Vec<_> = std::env::args()
        .skip(1)
        .filter(|argument| !argument.starts_with('-'))
        .collect();
    let rival = Rival::compile();
    if let Err(error) = &rival {
        println!("not compared with an executor in C: {error}");
    }
    let rival = rival.as_ref().ok();
    for family in Family::ALL {
        let name = family.name();
        if !wanted.is_empty()
            && !wanted
                .iter()
                .any(|wanted| name.eq_ignore_ascii_case(wanted))
        {
            continue;
        }
        let model = family.model(P);
        let generation = measure::generation(&model, rival, EFFORT);
        let (ours, theirs) = (generation.ours, generation.theirs.unwrap_or(f64::NAN));
        println!("{name}({P}) generate:  {ours:9.0} ns         (C: {theirs:9.0} ns)");
        for mode in [Mode::One, Mode::Saturated] {
            let (ours, theirs) = measure::evaluation(&model, mode, rival, EFFORT);
            let theirs = theirs.map_or(f64::NAN, |theirs| theirs.ns_per_firing());
            println!(
                "{name}({P}) {:10} {:9.2} ns/firing  (C: {theirs:9.2} ns/firing)",
                format!("{}:", mode.name()),
                ours.ns_per_firing(),
            );
        }
    }
}
