//! Nets with far more states than can be looked at one by one.

use std::fs;
use std::time::Duration;

use coordination::analysis::{Limits, Reason, check};
use coordination::petri::{NetModel, PlaceKind};

use super::{each, nets::gate};

/// The longest that a net may take of a core, whatever else the machine does,
const LONGEST: Duration = Duration::from_secs(10);
/// and the most memory that this program may ever have had, with all that its other tests have at the same time.
const LARGEST_KIB: u64 = 1 << 20;

/// Does this within what a net may take. Systems that do not tell what was taken are believed.
fn within_bounds<R>(work: impl FnOnce() -> R) -> R {
    let before = processor_time();
    let result = work();
    let took = processor_time() - before;
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let peak_kib = peak.and_then(|peak| peak.split_whitespace().next()?.parse().ok());
    println!("{took:?} of a core, {peak_kib:?} KiB at most");
    assert!(took < LONGEST, "{took:?}");
    assert!(peak_kib.unwrap_or(0) < LARGEST_KIB, "{peak_kib:?} KiB");
    result
}

/// What this thread has had of a core: the first number there, in nanoseconds.
fn processor_time() -> Duration {
    let text = fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let ran_ns = text.split(' ').next().and_then(|first| first.parse().ok());
    Duration::from_nanos(ran_ns.unwrap_or(0))
}

#[test]
fn a_gate_with_a_hundred_robots_passes() {
    let (net, uses) = gate(100);
    let proof = within_bounds(|| check(&net, &uses, &Limits::default()));
    let proof = proof.unwrap_or_else(|refusal| panic!("{refusal}"));
    assert!(proof.report().states > 1 << 100);
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
    let net = philosophers(100);
    let refusal = within_bounds(|| check(&net, &[], &Limits::default())).unwrap_err();
    assert!(matches!(*refusal.reason, Reason::Deadlock { .. }));
    assert_eq!(refusal.trace.unwrap().steps.len(), 100);
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
    let refusal = within_bounds(|| check(&faulty, &uses, &Limits::default())).unwrap_err();
    // The others ask, and wait for ever.
    let Reason::Deadlock { marked, .. } = &*refusal.reason else {
        panic!("{refusal}");
    };
    assert_eq!(marked.len(), 100);
    assert!(marked.contains(&"r99 asks".to_owned()), "{refusal}");
    assert_eq!(refusal.trace.unwrap().steps.len(), 5 + 100);
}

/// As much as there is of everything.
#[test]
fn limits_may_be_as_large_as_they_can() {
    let (net, uses) = gate(8);
    let all = Limits {
        states: 0,
        steps: usize::MAX,
        looks: u64::MAX,
        nodes: usize::MAX,
        time: Duration::MAX,
        waiting: u8::MAX,
    };
    let proof = check(&net, &uses, &all).unwrap_or_else(|refusal| panic!("{refusal}"));
    assert_eq!(
        proof.report().states,
        each(&net, &uses).unwrap().report().states
    );
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
