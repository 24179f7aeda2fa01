//! Nets with far more states than can be looked at one by one.

use std::time::{Duration, Instant};

use coordination::analysis::{Limits, Reason, check};
use coordination::petri::{NetModel, PlaceKind};

use super::{each, nets::gate};

/// For machines that do much else; a second or some without.
const LONG: Duration = Duration::from_secs(50);

#[test]
fn a_gate_with_a_hundred_robots_passes() {
    let begun = Instant::now();
    let (net, uses) = gate(100);
    let proof =
        check(&net, &uses, &Limits::default()).unwrap_or_else(|refusal| panic!("{refusal}"));
    println!("{:?} {:?}", begun.elapsed(), proof.report());
    assert!(proof.report().states > 1 << 100);
    assert!(begun.elapsed() < LONG);
}

fn philosophers(count: usize) -> NetModel {
    let mut net = NetModel::new("philosophers");
    for own in 0..count {
        let place = |what: &str| format!("{what}{own}");
        for what in ["think", "fork"] {
            net.place(place(what)).mark(&place(what));
        }
        for what in ["left", "right", "eat"] {
            net.place(place(what));
        }
        let (fork, next) = (place("fork"), format!("fork{}", (own + 1) % count));
        let [think, left, right, eat] = ["think", "left", "right", "eat"].map(place);
        net.transition(place("takes left "), &[&think, &fork], &[&left]);
        net.transition(place("takes right "), &[&left, &next], &[&eat]);
        net.transition(place("puts down "), &[&eat], &[&right, &fork, &next]);
        net.transition(place("thinks "), &[&right], &[&think]);
    }
    net.allow_endless();
    net
}

#[test]
fn a_hundred_philosophers_starve() {
    let begun = Instant::now();
    let refusal = check(&philosophers(100), &[], &Limits::default()).unwrap_err();
    println!("{:?} {refusal}", begun.elapsed());
    assert!(matches!(*refusal.reason, Reason::Deadlock { .. }));
    assert_eq!(refusal.trace.unwrap().steps.len(), 100);
    assert!(begun.elapsed() < LONG);
}

#[test]
fn a_gate_that_one_of_a_hundred_robots_does_not_give_back_is_refused() {
    let (net, uses) = gate(100);
    // The same net, but for the last robot's way out.
    let mut faulty = NetModel::new("faulty");
    for place in net.places() {
        match (place.kind, place.binding) {
            (PlaceKind::Source, Some(binding)) => faulty.source(place.name, binding.clone()),
            (PlaceKind::Sink, Some(binding)) => faulty.sink(place.name, binding.clone()),
            _ => faulty.place(place.name),
        };
        if place.marked {
            faulty.mark(place.name);
        }
    }
    for transition in net.transitions() {
        let is_last = transition.name == "r99 leaves";
        let outputs = if is_last {
            &[][..]
        } else {
            &transition.outputs
        };
        faulty.transition(transition.name, &transition.inputs, outputs);
    }
    faulty.end("idle", &["free"]);
    let refusal = check(&faulty, &uses, &Limits::default()).unwrap_err();
    // The others ask, and wait for ever.
    let Reason::Deadlock { marked, .. } = &*refusal.reason else {
        panic!("{refusal}");
    };
    assert_eq!(marked.len(), 100);
    assert!(marked.contains(&"r99 asks".to_owned()), "{refusal}");
    assert_eq!(refusal.trace.unwrap().steps.len(), 5 + 100);
}

#[test]
fn two_hundred_searches_follow_each_other() {
    let limits = Limits {
        states: 0,
        nodes: 10_000,
        ..Limits::default()
    };
    let (net, uses) = gate(8);
    let states = each(&net, &uses).unwrap().report().states;
    for _ in 0..200 {
        let proof = check(&net, &uses, &limits).unwrap_or_else(|refusal| panic!("{refusal}"));
        assert_eq!(proof.report().states, states);
    }
}

#[test]
fn a_search_that_needs_more_than_it_may_says_so() {
    let (net, uses) = gate(30);
    let few = Limits {
        states: 0,
        nodes: 700,
        ..Limits::default()
    };
    let short = Limits {
        states: 0,
        time: Duration::ZERO,
        ..Limits::default()
    };
    for (limits, what) in [
        (few, "nodes of decision diagrams"),
        (short, "seconds of looking"),
    ] {
        let refusal = check(&net, &uses, &limits).unwrap_err();
        let Reason::TooLarge { what: found, .. } = *refusal.reason else {
            panic!("{refusal}");
        };
        assert_eq!(found, what);
        assert_eq!(refusal.trace, None);
    }
}
