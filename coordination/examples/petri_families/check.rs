//! Compares what was measured in one run with thresholds, whose margins are wide: other programs may
//! run beside it. Only ratios are judged, of things measured in turns.

use std::time::Duration;

use crate::families::Family;
use crate::figure_4::Rival;
use crate::measure::{self, Effort, Mode};
use crate::shipped;
use crate::steps::{self, Steps};

/// Together with the thresholds, short enough for every change of the code.
const EFFORT: Effort = Effort {
    least: 5,
    most: 61,
    time: Duration::from_millis(300),
};

/// How often a failed comparison is measured again, since other programs may have disturbed it: then the middle one of all counts.
const AGAIN: usize = 2;

/// How many times as fast as the plain executor in C ours is at least: half of what a release build is to
/// reach, 10 and 6 in rounds, 4 for one firing, and 1 in generation.
struct Floor {
    family: Family,
    p: usize,
    one: f64,
    saturated: f64,
}

const FLOORS: [Floor; 10] = [
    floor(Family::Seq, 20, [2.0, 5.0]),
    floor(Family::Pr1, 20, [2.0, 5.0]),
    floor(Family::P1r, 20, [2.0, 5.0]),
    floor(Family::Ph, 20, [2.0, 5.0]),
    floor(Family::Square, 20, [2.0, 5.0]),
    floor(Family::Seq, 100, [2.0, 3.0]),
    floor(Family::Pr1, 100, [2.0, 3.0]),
    floor(Family::P1r, 100, [2.0, 3.0]),
    floor(Family::Ph, 100, [2.0, 3.0]),
    floor(Family::Square, 10, [2.0, 3.0]),
];

const GENERATION: f64 = 0.5;

const fn floor(family: Family, p: usize, [one, saturated]: [f64; 2]) -> Floor {
    Floor {
        family,
        p,
        one,
        saturated,
    }
}

/// One firing in a net of the larger p takes at most this many times as long as in one of [`SMALL`].
const FLATNESS: f64 = 1.5;
/// SQUARE has p² transitions.
const FLAT: [(Family, usize); 5] = [
    (Family::Seq, 100),
    (Family::Pr1, 100),
    (Family::P1r, 100),
    (Family::Ph, 100),
    (Family::Square, 20),
];
const SMALL: usize = 5;

/// A whole step of a shipped net, with its protocols and bindings, and what it takes for each firing, take at most as long as so many
/// single firings of SEQ(20) by the plain executor: twice what a release build was measured to take.
const SHIPPED: [(&str, [f64; 2]); 3] = [
    ("docking", [26.0, 27.0]),
    ("overtaking", [17.0, 33.0]),
    ("t-junction", [21.0, 28.0]),
];

/// Whether every threshold is met; those that are missed are printed on standard error.
pub fn passes(rival: Option<&Rival>) -> bool {
    let mut all = rival.is_some();
    if !all {
        eprintln!(
            "there is nothing to compare with: the plain executor needs a C compiler (`cc`) when this example starts"
        );
    }
    println!("what,measured,threshold");
    for floor in FLOORS.iter().filter(|_| rival.is_some()) {
        let name = |mode| format!("{}({}) {mode}", floor.family.name(), floor.p);
        let model = floor.family.model(floor.p);
        all &= judge(&name("generate"), GENERATION, Bound::AtLeast, || {
            let generation = measure::generation(&model, rival, EFFORT);
            generation.theirs.unwrap_or(f64::NAN) / generation.ours
        });
        for (mode, least) in [(Mode::One, floor.one), (Mode::Saturated, floor.saturated)] {
            all &= judge(&name(mode.name()), least, Bound::AtLeast, || {
                let (ours, theirs) = measure::evaluation(&model, mode, rival, EFFORT);
                theirs.map_or(f64::NAN, |it| it.ns_per_firing()) / ours.ns_per_firing()
            });
        }
    }
    let shipped = shipped::all();
    let is_alone = !shipped::folder().is_dir();
    if is_alone {
        eprintln!("the shipped nets are not beside this crate: their steps are not compared");
    }
    for (name, [whole, each]) in SHIPPED {
        if is_alone || rival.is_none() {
            continue;
        }
        let Some(net) = shipped.iter().find(|net| net.name == name) else {
            eprintln!("no net is called `{name}`: its steps are not compared");
            all = false;
            continue;
        };
        let by_a_plain_firing = |of: fn(&Steps) -> f64| {
            let steps = steps::measure(net, EFFORT);
            let (_, plain) = measure::evaluation(&Family::Seq.model(20), Mode::One, rival, EFFORT);
            of(&steps) / plain.map_or(f64::NAN, |it| it.ns_per_firing())
        };
        for (what, most, of) in [
            (
                "whole step",
                whole,
                (|own| own.ns_per_step) as fn(&Steps) -> f64,
            ),
            ("firing", each, |own| own.ns_per_firing),
        ] {
            let name = format!("{name}: {what} by a plain firing");
            all &= judge(&name, most, Bound::AtMost, || by_a_plain_firing(of));
        }
    }
    for (family, large) in FLAT {
        let name = format!("{}: one at {large} by one at {SMALL}", family.name());
        all &= judge(&name, FLATNESS, Bound::AtMost, || {
            let [small, large] = [SMALL, large].map(|p| family.model(p));
            measure::ratio_of_ones(&large, &small, EFFORT)
        });
    }
    all
}

#[derive(Clone, Copy)]
enum Bound {
    AtLeast,
    AtMost,
}

fn judge(what: &str, threshold: f64, bound: Bound, measure: impl Fn() -> f64) -> bool {
    // Comparisons with NaN fail.
    let is_good = |measured: f64| match bound {
        Bound::AtLeast => measured >= threshold,
        Bound::AtMost => measured <= threshold,
    };
    let mut measured = measure();
    if !is_good(measured) {
        let mut all = vec![measured];
        all.extend((0..AGAIN).map(|_| measure()));
        measured = measure::quantile(all, 0.5);
    }
    println!("{what},{measured:.2},{threshold}");
    if is_good(measured) {
        return true;
    }
    match bound {
        Bound::AtLeast => eprintln!(
            "{what}: {measured:.2} times as fast as the plain executor in C, expected at least {threshold}"
        ),
        Bound::AtMost => eprintln!("{what}: {measured:.2}, expected at most {threshold}"),
    }
    false
}
