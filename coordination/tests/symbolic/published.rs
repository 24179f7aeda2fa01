//! What the Model Checking Contest has published of instances of its families, in its oracles of 2020
//! (<https://github.com/yanntm/pnmcc-models-2020>): the examinations StateSpace (states and transitions),
//! ReachabilityDeadlock, OneSafe, QuasiLiveness, Liveness and StableMarking. Of StableMarking, whether some
//! place never changes, each place is a question of reachability.

use std::cmp::Reverse;
use std::num::NonZero;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use coordination::analysis::{
    Limits, Liveness, Marking, Properties, Reason, Refusal, place_invariants, properties,
};

use super::explorer::Explorer;
use super::families::{Net, dekker, eratosthenes, philosophers, referendum, shared_memory};

/// The family's parameter, the number of states and that of steps between them.
type Instance = (usize, &'static str, &'static str);

/// What is published of a family, whose instances are all one-safe and quasi-live.
struct Published {
    family: &'static str,
    net: fn(usize) -> Net,
    deadlock: bool,
    live: bool,
    stable: bool,
    instances: &'static [Instance],
}

const PUBLISHED: &[Published] = &[
    Published {
        family: "Philosophers",
        net: philosophers,
        deadlock: true,
        live: false,
        stable: false,
        instances: &[
            (5, "243", "945"),
            (10, "59049", "459270"),
            (20, "3486784401", "54238868460"),
            (50, "717897987691852588770249", "27918255076905378452176350"),
            (
                100,
                "515377520732011331036461129765621272702107522001",
                "40084918279156436858391421203992765654608362822300",
            ),
        ],
    },
    Published {
        family: "SharedMemory",
        net: shared_memory,
        deadlock: false,
        live: true,
        stable: false,
        instances: &[
            (5, "1863", "10395"),
            (10, "1830519", "19486170"),
            (20, "445146141861", "9197362408860"),
        ],
    },
    Published {
        family: "Dekker",
        net: dekker,
        deadlock: false,
        live: true,
        stable: false,
        instances: &[
            (10, "6144", "171530"),
            (15, "278528", "16834575"),
            (20, "11534336", "1216348180"),
            (50, "29273397577908224", "18675864704752025650"),
        ],
    },
    Published {
        family: "Eratosthenes",
        net: eratosthenes,
        deadlock: true,
        live: false,
        stable: true,
        instances: &[
            (10, "32", "120"),
            (20, "2048", "23040"),
            (50, "17179869184", "730144440320"),
            (100, "18889465931478580854784", "2025895221151077796675584"),
        ],
    },
    Published {
        family: "Referendum",
        net: referendum,
        deadlock: true,
        live: false,
        stable: false,
        instances: &[
            (10, "59050", "393661"),
            (15, "14348908", "143489071"),
            (20, "3486784402", "46490458681"),
            (50, "717897987691852588770250", "23929932923061752959008301"),
            (
                100,
                "515377520732011331036461129765621272702107522002",
                "34358501382134088735764075317708084846807168133401",
            ),
        ],
    },
];

/// All at once.
fn together() -> Limits {
    Limits {
        states: 0,
        ..Limits::default()
    }
}

/// The same of a small net.
fn few_together() -> Limits {
    Limits {
        nodes: super::NODES,
        ..together()
    }
}

/// One state after another.
fn each() -> Limits {
    Limits {
        nodes: 0,
        ..Limits::default()
    }
}

/// For each place, whether it can be as it is not at first.
fn changed(net: &Net) -> Vec<Marking> {
    let places = net.places.iter();
    places
        .map(|(place, marked)| match marked {
            true => Marking::new(&[], &[place]),
            false => Marking::new(&[place], &[]),
        })
        .collect()
}

/// A number as it is published, or the largest there is.
fn number(digits: &str) -> u128 {
    digits.parse().unwrap_or(u128::MAX)
}

#[test]
#[ignore = "CI makes these runs"]
fn verdicts_are_those_that_the_contest_publishes() {
    let mut instances: Vec<_> = { PUBLISHED.iter() }
        .flat_map(|published| published.instances.iter().map(move |own| (published, own)))
        .collect();
    assert!(instances.len() >= 20);
    // Each core takes the next one, the largest first.
    instances.sort_by_key(|(_, (size, ..))| Reverse(*size));
    let next = AtomicUsize::new(0);
    let look = || {
        while let Some((published, instance)) = instances.get(next.fetch_add(1, Ordering::Relaxed))
        {
            verdicts_are_those_published(published, instance);
        }
    };
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(look);
        }
    });
}

fn verdicts_are_those_published(published: &Published, &(size, states, steps): &Instance) {
    let name = format!("{} {size}", published.family);
    let net = (published.net)(size);
    let asked = changed(&net);
    let limits = if number(states) < 100_000 {
        vec![each(), few_together()]
    } else {
        vec![together()]
    };
    for limits in limits {
        let found = properties(&net.model(), &[], &limits, &asked);
        let found = found.unwrap_or_else(|refusal| panic!("{name}: {refusal}"));
        assert_eq!(found.states, number(states), "states of {name}");
        assert_eq!(found.steps, number(steps), "steps of {name}");
        assert_eq!(found.deadlock.is_some(), published.deadlock, "{name}");
        assert!(found.is_quasi_live(), "{name}");
        assert_eq!(found.is_live(), published.live, "{name}");
        let is_stable = found.reached.iter().any(Option::is_none);
        assert_eq!(is_stable, published.stable, "{name}");
    }
}

/// The contest hands its nets out as PNML.
#[cfg(feature = "pnml")]
#[test]
fn the_way_through_pnml_changes_no_verdict() {
    use coordination::pnml::{Document, read};

    let mut there_and_back = 0;
    for (family, sizes) in SMALL {
        for size in sizes {
            let net = family(size);
            let (model, asked) = (net.model(), changed(&net));
            // Sieves and referendums have places that nothing fills, or without arcs, which no net of ours has.
            let Ok(document) = Document::new(&model) else {
                continue;
            };
            there_and_back += 1;
            let text = document.to_string();
            let back = read(&text).unwrap_or_else(|error| panic!("{error}: {text}"));
            let [there, back] = [&model, &back]
                .map(|net| properties(net, &[], &few_together(), &asked).expect("it is safe"));
            assert_eq!((there.states, there.steps), (back.states, back.steps));
            assert_eq!(lengths(&there), lengths(&back));
            assert_eq!(there.is_live(), back.is_live());
            let deadlocks =
                [&there, &back].map(|own| own.deadlock.as_ref().map(|way| way.steps.len()));
            assert_eq!(deadlocks[0], deadlocks[1]);
        }
    }
    assert!(there_and_back >= 13, "{there_and_back}");
}

/// A family, and sizes.
type Sizes = (fn(usize) -> Net, Range<usize>);

/// The smaller ones of each family.
const SMALL: [Sizes; 5] = [
    (philosophers, 2..6),
    (shared_memory, 2..5),
    (dekker, 2..8),
    (eratosthenes, 6..15),
    (referendum, 1..6),
];

/// How many steps lead there.
fn lengths(properties: &Properties) -> Vec<Option<usize>> {
    let reached = properties.reached.iter();
    reached
        .map(|trace| trace.as_ref().map(|trace| trace.steps.len()))
        .collect()
}

#[test]
fn a_plain_explorer_says_the_same_of_small_ones() {
    for (family, sizes) in SMALL {
        for size in sizes {
            let net = family(size);
            let plain = Explorer::new(&net).expect("it is safe");
            let names: Vec<&str> = net.places.iter().map(|(place, _)| place.as_str()).collect();
            let pairs = names.windows(2).flat_map(|pair| {
                [
                    Marking::new(pair, &[]),
                    Marking::new(&pair[..1], &pair[1..]),
                    Marking::new(&[], pair),
                ]
            });
            let asked: Vec<Marking> = pairs.chain(changed(&net)).collect();
            let far: Vec<Option<usize>> = { asked.iter() }
                .map(|asked| {
                    plain.nearest(|_, marking| {
                        let is_marked = |place: &String| marking.contains(place.as_str());
                        asked.marked.iter().all(is_marked) && !asked.empty.iter().any(is_marked)
                    })
                })
                .collect();
            for limits in [each(), few_together()] {
                let found = properties(&net.model(), &[], &limits, &asked).unwrap();
                assert_eq!(found.states, plain.markings.len() as u128);
                assert_eq!(found.steps, plain.firings.len() as u128);
                assert_eq!(lengths(&found), far, "{size}");
                let deadlock = found.deadlock.as_ref().map(|trace| trace.steps.len());
                assert_eq!(deadlock, plain.deadlock());
                for (number, (transition, liveness)) in found.transitions.iter().enumerate() {
                    let dies = match liveness {
                        Liveness::Live => None,
                        Liveness::Dies => found.dies_after(number).map(|way| way.steps.len()),
                        other => panic!("{transition} fires, and is {other:?}"),
                    };
                    // A deadlock is named for all, though one may die before.
                    let expected = deadlock.or(plain.dies(transition));
                    assert_eq!(dies, expected, "{transition} of {size}");
                    assert_eq!(dies.is_some(), plain.dies(transition).is_some());
                }
            }
        }
    }
}

/// With a token more in some place, or one less, a net is unsafe or not.
#[test]
fn what_is_unsafe_is_refused_as_the_plain_explorer_refuses_it() {
    let (mut refused, mut passed) = (0, 0);
    for (family, sizes) in SMALL {
        for size in sizes {
            let whole = family(size);
            for spoilt in 0..whole.places.len() {
                let mut net = whole.clone();
                net.places[spoilt].1 ^= true;
                let is_safe = Explorer::new(&net).is_some();
                for limits in [each(), few_together()] {
                    let found = properties(&net.model(), &[], &limits, &[]);
                    let is_unsafe = |refusal: &Refusal| {
                        matches!(*refusal.reason, Reason::Unsafe { .. }) && refusal.trace.is_some()
                    };
                    match &found {
                        Ok(_) => assert!(is_safe, "{:?}", net.places[spoilt]),
                        Err(refusal) => assert!(!is_safe && is_unsafe(refusal), "{refusal}"),
                    }
                }
                *if is_safe { &mut passed } else { &mut refused } += 1;
            }
        }
    }
    assert!(
        refused > 50 && passed > 5,
        "{refused} refused, {passed} passed"
    );
}

/// Safety follows from place invariants in these families, where it does.
#[test]
fn invariants_prove_the_safety_of_families() {
    for (family, size, is_safe) in [
        (philosophers as fn(usize) -> Net, 100, true),
        (shared_memory, 20, true),
        (dekker, 50, true),
        (referendum, 100, true),
        // Its tokens get fewer, so that no sum of them stays.
        (eratosthenes, 20, false),
    ] {
        let net = family(size);
        let invariants = place_invariants(&net.model());
        let mut places = net.places.iter();
        let all = places.all(|(place, _)| invariants.is_safe(place));
        assert_eq!(all, is_safe, "of size {size}");
    }
}
