//! The same verdicts on random nets, however they are looked at.

use std::collections::BTreeMap;

use coordination::analysis::{
    Limits, Liveness, Marking, Properties, Reason, Refusal, Report, Warning, properties,
};

use super::drawn::{Random, draw};
use super::{NODES, each, each_is_met, name, together};

/// The kind of a reason, and what of it does not hang on which of several states is named.
fn kind(refusal: &Refusal) -> String {
    match &*refusal.reason {
        Reason::DeadTransitions { transitions, sinks } => {
            let lacks = transitions.iter().map(|dead| {
                let (name, steps) = (&dead.transition, dead.nearest.steps.len());
                format!("{name}: {} after {steps}", dead.lacks.len())
            });
            format!("DeadTransitions {:?} {sinks:?}", lacks.collect::<Vec<_>>())
        }
        Reason::EndUnreached { end } => format!("EndUnreached {end}"),
        Reason::Unfinished { protocol, .. } => format!("Unfinished {protocol}"),
        reason => name(reason),
    }
}

fn length(refusal: &Refusal) -> Option<usize> {
    refusal.trace.as_ref().map(|trace| trace.steps.len())
}

/// Warnings, with traces of equal length for equal ones.
fn warnings(report: &Report) -> Vec<String> {
    let text = |warning: &Warning| match warning {
        Warning::NeverRests { trace } => format!("never rests after {}", trace.steps.len()),
        warning => warning.to_string(),
    };
    report.warnings.iter().map(text).collect()
}

#[test]
fn verdicts_and_lengths_of_traces_are_the_same_on_random_nets() {
    let mut random = Random(0x9876_5432_1abc_def1);
    let mut met: BTreeMap<String, usize> = BTreeMap::new();
    for number in 0..4000 {
        let (net, uses) = draw(&mut random);
        let verdict = match (each(&net, &uses), together(&net, &uses)) {
            (Ok(one), Ok(all)) => {
                let (one, all) = (one.report(), all.report());
                assert_eq!(
                    (all.states, all.steps),
                    (one.states, one.steps),
                    "net {number}"
                );
                assert_eq!(all.ends, one.ends, "net {number}");
                assert_eq!(warnings(all), warnings(one), "net {number}");
                "passes".to_owned()
            }
            (Err(one), Err(all)) => {
                assert_eq!(
                    kind(&all),
                    kind(&one),
                    "net {number}: {all}\n{one}\n{net:?}"
                );
                assert_eq!(length(&all), length(&one), "net {number}: {all}\n{one}");
                kind(&one).split(' ').next().unwrap_or_default().to_owned()
            }
            (one, all) => panic!("net {number}: {one:?} {all:?}"),
        };
        *met.entry(verdict).or_default() += 1;
    }
    println!("{met:?}");
    each_is_met(
        &met,
        &[
            ("passes", 400),
            ("Deadlock", 100),
            ("Unsafe", 100),
            ("OutOfOrder", 20),
            ("Overflow", 5),
            ("Exclusion", 20),
            ("Livelock", 20),
            ("Unfinished", 5),
            ("Endless", 20),
            ("DeadTransitions", 20),
        ],
    );
}

/// What is true of a net, with traces by their lengths.
fn told(found: Result<Properties, Refusal>) -> String {
    let found = match found {
        Ok(found) => found,
        Err(refusal) => return format!("{} after {:?}", kind(&refusal), length(&refusal)),
    };
    let mut liveness = found
        .transitions
        .iter()
        .zip(0..)
        .map(|((name, liveness), number)| match liveness {
            Liveness::Dead => format!("{name} is dead"),
            Liveness::Live => format!("{name} lives"),
            _ => {
                let way = found.dies_after(number).unwrap();
                format!("{name} dies after {}", way.steps.len())
            }
        });
    let steps = |trace: &Option<_>| {
        let trace: Option<&coordination::analysis::Trace> = trace.as_ref();
        trace.map(|trace| trace.steps.len())
    };
    let reached: Vec<_> = found.reached.iter().map(steps).collect();
    format!(
        "{} states, {} steps, deadlock {:?}, {reached:?}, {}, {:?}",
        found.states,
        found.steps,
        steps(&found.deadlock),
        liveness.by_ref().collect::<Vec<_>>().join(", "),
        found.by_invariants
    )
}

#[test]
fn properties_are_the_same_on_random_nets() {
    let mut random = Random(0x1357_9bdf_2468_ace1);
    let (mut live, mut dying, mut halts, mut refused) = (0, 0, 0, 0);
    for number in 0..1500 {
        let (net, uses) = draw(&mut random);
        let names: Vec<String> = net.places().map(|place| place.name.to_owned()).collect();
        let one = &names[random.below(names.len())];
        let other = &names[random.below(names.len())];
        let asked = [
            Marking::new(&[one, other], &[]),
            Marking::new(&[one], &[other]),
        ];
        let [each, together] = [(usize::MAX, 0), (0, NODES)].map(|(states, nodes)| {
            let all = Limits::default();
            let limits = Limits {
                states: all.states.min(states),
                nodes: all.nodes.min(nodes),
                ..all
            };
            properties(&net, &uses, &limits, &asked)
        });
        match &each {
            Err(_) => refused += 1,
            Ok(found) if found.deadlock.is_some() => halts += 1,
            Ok(found) if found.is_live() => live += 1,
            Ok(_) => dying += 1,
        }
        let texts = format!("{:?}\n{:?}", each.as_ref().err(), together.as_ref().err());
        assert_eq!(told(together), told(each), "net {number}: {texts}");
    }
    let all = [live, dying, halts, refused];
    assert!(all.iter().all(|&count| count >= 20), "{all:?}");
}
