//! Safe families of the Model Checking Contest (<https://mcc.lip6.fr>), written from the definitions in
//! their model forms as we remember them. So are the sizes of the state spaces that stand here, large ones
//! to five digits, and who has a deadlock: nobody has held them against the forms yet. `SharedMemory` is
//! modelled so that its size is the one remembered.
//!
//! Small ones are also compared with a plain explorer.

use std::collections::{BTreeSet, HashSet, VecDeque};

use coordination::analysis::{Limits, Reason, Situation, check, check_situations};
use coordination::petri::NetModel;

/// A name, inputs and outputs.
type Transition = (String, Vec<String>, Vec<String>);

/// Places, marked or not; transitions with their inputs and outputs.
#[derive(Clone, Default)]
struct Net {
    places: Vec<(String, bool)>,
    transitions: Vec<Transition>,
}

impl Net {
    fn place(&mut self, name: String, marked: bool) {
        self.places.push((name, marked));
    }

    fn transition<const I: usize, const O: usize>(
        &mut self,
        name: String,
        inputs: [String; I],
        outputs: [String; O],
    ) {
        self.transitions.push((name, inputs.into(), outputs.into()));
    }
}

/// Each takes either fork first, then the other, and puts both down at once.
fn philosophers(count: usize) -> Net {
    let mut net = Net::default();
    for own in 0..count {
        let at = |what: &str| format!("{what} {own}");
        let (left, right) = (at("fork"), format!("fork {}", (own + 1) % count));
        let [think, one, other, eat] = ["think", "catch 1", "catch 2", "eat"].map(at);
        for (place, marked) in [
            (&left, true),
            (&think, true),
            (&one, false),
            (&other, false),
            (&eat, false),
        ] {
            net.place(place.clone(), marked);
        }
        let own = |list: [&String; 2]| list.map(String::clone);
        net.transition(at("FF1a"), own([&think, &left]), [one.clone()]);
        net.transition(at("FF1b"), own([&think, &right]), [other.clone()]);
        net.transition(at("FF2a"), own([&one, &right]), [eat.clone()]);
        net.transition(at("FF2b"), own([&other, &left]), [eat.clone()]);
        net.transition(at("end"), [eat], [think, left, right]);
    }
    net
}

/// Processors that work, use their own memory, or queue for the bus to another's.
fn shared_memory(count: usize) -> Net {
    let mut net = Net::default();
    net.place("bus".into(), true);
    for own in 0..count {
        let at = |what: &str| format!("{what} {own}");
        for (what, marked) in [
            ("active", true),
            ("memory", true),
            ("own", false),
            ("queue", false),
        ] {
            net.place(at(what), marked);
        }
        net.transition(at("begin own"), [at("active")], [at("own")]);
        net.transition(at("end own"), [at("own")], [at("active")]);
        net.transition(at("request"), [at("active")], [at("queue")]);
        for other in (0..count).filter(|&other| other != own) {
            let (access, memory) = (format!("access {own} {other}"), format!("memory {other}"));
            net.place(access.clone(), false);
            let begin = [at("queue"), "bus".into(), memory.clone()];
            net.transition(format!("begin {own} {other}"), begin, [access.clone()]);
            let end = [at("active"), "bus".into(), memory];
            net.transition(format!("end {own} {other}"), [access], end);
        }
    }
    net
}

/// Dekker's algorithm: one raises a flag, takes it back if another's is up, or enters if none is.
fn dekker(count: usize) -> Net {
    let mut net = Net::default();
    for own in 0..count {
        let at = |what: &str| format!("{what} {own}");
        for (what, marked) in [
            ("p0", true),
            ("p1", false),
            ("p3", false),
            ("down", true),
            ("up", false),
        ] {
            net.place(at(what), marked);
        }
        net.transition(at("try"), [at("p0"), at("down")], [at("p1"), at("up")]);
        net.transition(at("exit"), [at("p3"), at("up")], [at("p0"), at("down")]);
        let others = (0..count).filter(|&other| other != own);
        for other in others.clone() {
            let seen = format!("up {other}");
            let inputs = [at("p1"), at("up"), seen.clone()];
            let outputs = [at("p0"), at("down"), seen];
            net.transition(format!("withdraw {own} {other}"), inputs, outputs);
        }
        let down = others.map(|other| format!("down {other}"));
        let with = |place: String| down.clone().chain([place]).collect();
        net.transitions
            .push((at("enter"), with(at("p1")), with(at("p3"))));
    }
    net
}

/// Multiples are struck out by any of their divisors that is left.
fn eratosthenes(last: usize) -> Net {
    let mut net = Net::default();
    for number in 2..=last {
        net.place(number.to_string(), true);
    }
    for divisor in 2..=last {
        for multiple in (2 * divisor..=last).step_by(divisor) {
            let [kept, struck] = [divisor, multiple].map(|number| number.to_string());
            let name = format!("{multiple} by {divisor}");
            net.transition(name, [kept.clone(), struck], [kept]);
        }
    }
    net
}

/// Once it has begun, each votes for or against.
fn referendum(voters: usize) -> Net {
    let mut net = Net::default();
    net.place("ready".into(), true);
    let voting = (0..voters).map(|own| format!("voting {own}")).collect();
    net.transitions
        .push(("start".into(), vec!["ready".into()], voting));
    for own in 0..voters {
        let voting = format!("voting {own}");
        net.place(voting.clone(), false);
        for vote in ["yes", "no"] {
            net.place(format!("{vote} {own}"), false);
            net.transition(
                format!("votes {vote} {own}"),
                [voting.clone()],
                [format!("{vote} {own}")],
            );
        }
    }
    net
}

/// What the contest publishes: the family's parameter, the size of the state space, whether it has a
/// deadlock. All of these are safe, and each transition can fire.
type Published = (usize, &'static str, bool);

/// A family's name, its nets, and what is published of them.
type Family = (&'static str, fn(usize) -> Net, &'static [Published]);

const PUBLISHED: &[Family] = &[
    (
        "Philosophers",
        philosophers,
        &[
            (5, "243", true),
            (10, "59049", true),
            (20, "3486784401", true),
            (50, "7.1790e23", true),
            (100, "5.1538e47", true),
        ],
    ),
    (
        "SharedMemory",
        shared_memory,
        &[
            (5, "1863", false),
            (10, "1830519", false),
            (20, "4.4515e11", false),
        ],
    ),
    (
        "Dekker",
        dekker,
        &[
            (10, "6144", false),
            (15, "278528", false),
            (20, "11534336", false),
            (50, "2.9273e16", false),
        ],
    ),
    (
        "Eratosthenes",
        eratosthenes,
        &[
            (10, "32", true),
            (20, "2048", true),
            (50, "1.7180e10", true),
            (100, "1.8889e22", true),
        ],
    ),
    (
        "Referendum",
        referendum,
        &[
            (10, "59050", true),
            (15, "14348908", true),
            (20, "3486784402", true),
            (50, "7.1790e23", true),
            (100, "5.1538e47", true),
        ],
    ),
];

/// The net in two situations: as it is, and one in which transitions fire that give each place an input
/// and an output, which a net here must have. A clock that ticks for ever may keep it from stopping.
fn models(net: &Net, ticks: bool) -> [NetModel; 2] {
    // Those in one list of arcs of a transition and not in the other.
    type Arcs = fn(&Transition) -> &Vec<String>;
    let of = |arcs: Arcs, others: Arcs| -> BTreeSet<&str> {
        let changed = net.transitions.iter().flat_map(|transition| {
            let other = others(transition);
            { arcs(transition).iter() }.filter(move |place| !other.contains(place))
        });
        changed.map(String::as_str).collect()
    };
    let (inputs, outputs): (Arcs, Arcs) = (|t| &t.1, |t| &t.2);
    let (taken, put) = (of(inputs, outputs), of(outputs, inputs));
    let without = |set: &BTreeSet<&str>| -> Vec<&str> {
        let places = net.places.iter().map(|(place, _)| place.as_str());
        places.filter(|place| !set.contains(place)).collect()
    };
    let (never_put, never_taken) = (without(&put), without(&taken));
    [false, true].map(|is_other| {
        let mut model = NetModel::new("family");
        for (place, marked) in &net.places {
            model.place(place);
            let at_first = match is_other {
                false => *marked,
                true => never_taken.contains(&place.as_str()),
            };
            if at_first {
                model.mark(place);
            }
        }
        for (name, inputs, outputs) in &net.transitions {
            let [inputs, outputs] =
                [inputs, outputs].map(|list| list.iter().map(String::as_str).collect::<Vec<_>>());
            model.transition(name, &inputs, &outputs);
        }
        // Once, in the other situation: what nothing empties is emptied, then what nothing fills is filled.
        model.place("off").place("emptied");
        model.transition("wait", &["off"], &["off"]);
        model.transition(
            "empty",
            &[&never_taken[..], &["off"]].concat(),
            &["emptied"],
        );
        model.transition("fill", &["emptied"], &never_put);
        if is_other {
            model.mark("off");
        }
        if ticks || is_other {
            model.place("clock").mark("clock").allow_endless();
            model.transition("tick", &["clock"], &["clock"]);
        }
        model
    })
}

/// In words as the contest has them: all digits, or five.
fn digits(count: u128, like: &str) -> String {
    match like.contains('e') {
        // Counted no further.
        true if count == u128::MAX && like.parse::<f64>().is_ok_and(|most| most > count as f64) => {
            like.to_owned()
        }
        true => format!("{:.4e}", count as f64),
        false => count.to_string(),
    }
}

#[test]
fn verdicts_are_those_that_the_contest_publishes() {
    let limits = Limits {
        states: 0,
        ..Limits::default()
    };
    let mut instances = 0;
    for (family, net, published) in PUBLISHED {
        for &(size, states, deadlock) in *published {
            let net = net(size);
            let name = format!("{family} {size}");
            // With a clock it goes on, so that all states are counted; without, it may stop.
            let [own, other] = models(&net, true);
            let situations =
                [("own", &own), ("other", &other)].map(|(name, model)| Situation { name, model });
            let proofs = check_situations(&situations[..], &[], &limits);
            let proofs = proofs.unwrap_or_else(|refusal| panic!("{name}: {refusal}"));
            assert_eq!(digits(proofs[0].report().states, states), states, "{name}");

            let [own, _] = models(&net, false);
            let refusal = check(&own, &[], &limits).unwrap_err();
            let stops = matches!(*refusal.reason, Reason::Deadlock { .. });
            assert_eq!(stops, deadlock, "{name}: {refusal}");
            instances += 1;
        }
    }
    assert!(instances >= 20);
}

/// Reads a net on its own terms, one marking after another: how many there are, how far the nearest
/// one without a step is, and the transitions that fire. None if a second token would come.
fn explore(net: &Net) -> Option<(u128, Option<usize>, BTreeSet<&str>)> {
    let first: BTreeSet<&str> = { net.places.iter() }
        .filter_map(|(place, marked)| marked.then_some(place.as_str()))
        .collect();
    let mut seen = HashSet::from([first.clone()]);
    let mut waiting = VecDeque::from([(first, 0)]);
    let (mut stops, mut fired) = (None, BTreeSet::new());
    while let Some((marking, distance)) = waiting.pop_front() {
        let mut goes_on = false;
        for (name, inputs, outputs) in &net.transitions {
            if !inputs.iter().all(|place| marking.contains(place.as_str())) {
                continue;
            }
            goes_on = true;
            fired.insert(name.as_str());
            let mut next = marking.clone();
            next.retain(|place| !inputs.iter().any(|input| input == place));
            for place in outputs {
                if !next.insert(place) {
                    return None;
                }
            }
            if seen.insert(next.clone()) {
                waiting.push_back((next, distance + 1));
            }
        }
        if !goes_on && stops.is_none() {
            stops = Some(distance);
        }
    }
    Some((seen.len() as u128, stops, fired))
}

#[test]
fn a_plain_explorer_says_the_same_of_small_ones() {
    let limits = Limits {
        states: 0,
        ..Limits::default()
    };
    for (net, sizes) in [
        (philosophers as fn(usize) -> Net, 2..7),
        (shared_memory, 2..6),
        (dekker, 2..9),
        (eratosthenes, 6..21),
        (referendum, 1..8),
    ] {
        for size in sizes {
            let net = net(size);
            let (states, stops, fired) = explore(&net).expect("it is safe");
            assert_eq!(fired.len(), net.transitions.len());
            let [own, other] = models(&net, true);
            let situations =
                [("own", &own), ("other", &other)].map(|(name, model)| Situation { name, model });
            let proofs = check_situations(&situations[..], &[], &limits)
                .unwrap_or_else(|refusal| panic!("{refusal}"));
            assert_eq!(proofs[0].report().states, states);
            let [own, _] = models(&net, false);
            let refusal = check(&own, &[], &limits).unwrap_err();
            let found = match *refusal.reason {
                Reason::Deadlock { .. } => refusal.trace.map(|trace| trace.steps.len()),
                _ => None,
            };
            assert_eq!(found, stops, "{size}");

            // A token too many in some place that is filled is a second one.
            let mut spoilt = net.clone();
            let filled = &spoilt.transitions[0].2[0];
            let place = spoilt
                .places
                .iter()
                .position(|(place, _)| place == filled)
                .unwrap();
            spoilt.places[place].1 = true;
            let refusal = check(&models(&spoilt, false)[0], &[], &limits).unwrap_err();
            let is_unsafe = matches!(*refusal.reason, Reason::Unsafe { .. });
            assert_eq!(is_unsafe, explore(&spoilt).is_none(), "{refusal}");
        }
    }
}
