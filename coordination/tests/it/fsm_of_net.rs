//! The machine of a small net, and the way there and back.

use std::collections::{HashMap, HashSet, VecDeque};

use coordination::event::{EventId, EventTable};
use coordination::fsm::{Machine, MachineModel, OfNetLimits, StateId, Unused};
use coordination::petri::{Binding, Budget, Executor, Net, NetModel, PlaceKind};
use proptest::prelude::*;

fn limits(unused: Unused) -> OfNetLimits {
    OfNetLimits {
        unused,
        ..OfNetLimits::default()
    }
}

fn compile(net: &NetModel) -> Net {
    net.compile(&mut EventTable::new()).unwrap()
}

fn refused(net: &NetModel) -> String {
    let error = MachineModel::of_net(&compile(net), &OfNetLimits::default()).unwrap_err();
    error.to_string()
}

/// A machine in words: each transition, by state and then by input.
fn words(model: &MachineModel) -> Vec<String> {
    let machine = model.compile(&mut EventTable::new()).unwrap();
    let lines = machine.transitions().map(|step| {
        let outputs: Vec<_> = step
            .outputs
            .iter()
            .map(|&each| machine.output_name(each))
            .collect();
        let (from, to) = (machine.state_name(step.from), machine.state_name(step.to));
        format!(
            "{from} | {} -> {to} {outputs:?}",
            machine.input_name(step.on)
        )
    });
    lines.collect()
}

fn event(name: &str) -> Binding {
    Binding::event(name)
}

/// One robot at a time; the doorman says what it did.
fn gate() -> NetModel {
    let mut net = NetModel::new("gate");
    net.place("free").mark("free").place("taken");
    net.source("asked", event("ask"))
        .sink("granted", event("grant"));
    net.source("left", event("leave"));
    net.transition("enter", &["asked", "free"], &["taken", "granted"]);
    net.transition("leave", &["left", "taken"], &["free"]);
    net
}

#[test]
fn what_becomes_of_an_event_that_comes_too_early_is_a_choice() {
    let net = compile(&gate());
    assert_eq!(
        refused(&gate()),
        "net `gate`: in state `free` `leave` stays in source `left`; a machine keeps no events"
    );
    let forgets = MachineModel::of_net(&net, &limits(Unused::Forget)).unwrap();
    assert_eq!(
        words(&forgets),
        [
            r#"free | ask -> taken ["grant"]"#,
            "taken | leave -> free []"
        ]
    );
    let keeps = MachineModel::of_net(&net, &limits(Unused::Keep)).unwrap();
    assert_eq!(
        words(&keeps),
        [
            r#"free | ask -> taken ["grant"]"#,
            "free | leave -> free + left []",
            r#"taken | ask -> taken + asked []"#,
            "taken | leave -> free []",
            r#"free + left | ask -> free ["grant"]"#,
            r#"taken + asked | leave -> taken ["grant"]"#,
        ]
    );
}

#[test]
fn a_full_sink_delays_and_is_emptied() {
    // Two outputs of one event by one sink: the second transition waits until the first's is taken.
    let mut net = NetModel::new("twice");
    net.place("rest").mark("rest").place("half");
    net.source("go", event("go")).sink("beep", event("beep"));
    net.transition("one", &["rest", "go"], &["half", "beep"]);
    net.transition("two", &["half"], &["rest", "beep"]);
    let machine = MachineModel::of_net(&compile(&net), &OfNetLimits::default()).unwrap();
    assert_eq!(words(&machine), [r#"rest | go -> rest ["beep", "beep"]"#]);
}

#[test]
fn concurrent_parts_make_a_product() {
    let mut net = NetModel::new("two lamps");
    for lamp in ["a", "b"] {
        let place = |what: &str| format!("{lamp} {what}");
        net.place(place("off"))
            .mark(&place("off"))
            .place(place("on"));
        net.source(place("?"), event(&format!("press {lamp}")));
        net.source(place("all?"), event("all"));
        // Both are told at once; each changes.
        for (name, asks) in [("press", "?"), ("all", "all?")] {
            let (off, on, asks) = (place("off"), place("on"), place(asks));
            net.transition(place(&format!("{name} on")), &[&off, &asks], &[&on]);
            net.transition(place(&format!("{name} off")), &[&on, &asks], &[&off]);
        }
    }
    let model = MachineModel::of_net(&compile(&net), &OfNetLimits::default()).unwrap();
    let machine = model.compile(&mut EventTable::new()).unwrap();
    assert_eq!(machine.states().count(), 4);
    assert_eq!(machine.inputs().count(), 3);
    assert!(words(&model).contains(&"a off + b off | all -> a on + b on []".to_owned()));
    assert!(words(&model).contains(&"a off + b on | press b -> a off + b off []".to_owned()));
}

#[test]
fn what_no_machine_can_say_is_refused_by_name() {
    let mut flag = gate();
    flag.source("told", Binding::flag("robot", "told"));
    flag.transition("tell", &["told"], &["free"]);
    assert_eq!(
        refused(&flag),
        "net `gate`: place `told` is bound to the flag `robot.told`; a machine has only events"
    );

    let mut endless = NetModel::new("endless");
    endless
        .place("a")
        .place("b")
        .source("go", event("go"))
        .allow_endless();
    endless.transition("begin", &["go"], &["a"]);
    endless
        .transition("to", &["a"], &["b"])
        .transition("fro", &["b"], &["a"]);
    assert_eq!(
        refused(&endless),
        "net `endless` can go on for ever after `go` in state `-`"
    );

    let mut choice = NetModel::new("choice");
    choice
        .place("heads")
        .place("tails")
        .source("throw", event("throw"));
    choice.sink("won", event("won"));
    choice.transition("up", &["throw"], &["heads", "won"]);
    choice.transition("down", &["throw"], &["tails"]);
    choice.source("again", event("again"));
    choice.transition("lift", &["heads", "again"], &[]);
    choice.transition("turn", &["tails", "again"], &[]);
    assert_eq!(
        refused(&choice),
        "net `choice`: after `throw` in state `-` it comes to `heads` with [won] or to `tails` with [], depending on which \
         transition fires first"
    );

    let mut eager = NetModel::new("eager");
    eager
        .place("a")
        .mark("a")
        .place("b")
        .sink("hello", event("hello"));
    eager.transition("greet", &["a"], &["b", "hello"]);
    eager
        .source("go", event("go"))
        .transition("use", &["go", "b"], &["b"]);
    assert_eq!(
        refused(&eager),
        "net `eager` fires `hello` before any event; a machine fires only on one"
    );
}

#[test]
fn a_net_that_is_too_large_is_refused_with_the_bound() {
    // A token on its way through ten places, in each of twelve rows: 10^12 markings.
    let mut net = NetModel::new("rows");
    for row in 0..12 {
        let place = |number: usize| format!("{row}.{number}");
        net.place(place(0)).mark(&place(0));
        net.source(format!("?{row}"), event(&format!("go {row}")));
        net.place(place(9));
        for number in 1..9 {
            net.place(place(number));
        }
        for number in 0..10 {
            let (from, to) = (place(number), place((number + 1) % 10));
            net.transition(
                format!("{row}: {number}"),
                &[&from, &format!("?{row}")],
                &[&to],
            );
        }
    }
    assert_eq!(
        refused(&net),
        "net `rows` has more than 1024 states; it is too large for a machine"
    );
    // All rows at once go through 2^12 markings.
    let mut at_once = NetModel::new("at once");
    for row in 0..20 {
        let (from, to) = (format!("{row} a"), format!("{row} b"));
        at_once.place(&from).mark(&from).place(&to);
        at_once.source(format!("?{row}"), event("go"));
        at_once.transition(format!("{row} to"), &[&from, &format!("?{row}")], &[&to]);
        at_once.transition(format!("{row} fro"), &[&to, &format!("?{row}")], &[&from]);
    }
    assert_eq!(
        refused(&at_once),
        "net `at once` has more than 65536 markings between its states; it is too large for a machine"
    );
}

#[test]
fn names_with_the_mark_between_names_are_told_apart() {
    let mut net = NetModel::new("names");
    net.place("a").mark("a").place("b").mark("b").place("a + b");
    net.source("go", event("go"));
    net.transition("join", &["a", "b", "go"], &["a + b"]);
    net.transition("part", &["a + b", "go"], &["a", "b"]);
    let machine = MachineModel::of_net(&compile(&net), &OfNetLimits::default()).unwrap();
    assert_eq!(
        words(&machine),
        ["a + b | go -> a + b' []", "a + b' | go -> a + b []"]
    );
}

/// Whether two machines fire the same, as sets that count, on every sequence of events. An event that is ignored is one that
/// changes and fires nothing.
fn are_equivalent(first: &Machine, second: &Machine) -> Result<(), String> {
    type Steps = HashMap<(StateId, String), (StateId, Vec<String>)>;
    let steps = |machine: &Machine| -> Steps {
        let all = machine.transitions().map(|step| {
            let outputs = step.outputs.iter();
            let mut outputs: Vec<_> = outputs
                .map(|&each| machine.output_name(each).to_owned())
                .collect();
            outputs.sort();
            let on = machine.input_name(step.on).to_owned();
            ((step.from, on), (step.to, outputs))
        });
        all.collect()
    };
    let after = |steps: &Steps, from: StateId, on: &str| {
        let step = steps.get(&(from, on.to_owned())).cloned();
        step.unwrap_or((from, Vec::new()))
    };
    let (one, other) = (steps(first), steps(second));
    let inputs: HashSet<&str> = { first.inputs().chain(second.inputs()) }
        .map(|(_, name)| name)
        .collect();
    let begin = (first.initial(), second.initial());
    let mut seen = HashSet::from([begin]);
    let mut waiting = VecDeque::from([begin]);
    while let Some((a, b)) = waiting.pop_front() {
        for on in &inputs {
            let ((to_a, fires_a), (to_b, fires_b)) = (after(&one, a, on), after(&other, b, on));
            if fires_a != fires_b {
                let (a, b) = (first.state_name(a), second.state_name(b));
                return Err(format!(
                    "`{on}` in `{a}` fires {fires_a:?}, in `{b}` {fires_b:?}"
                ));
            }
            if seen.insert((to_a, to_b)) {
                waiting.push_back((to_a, to_b));
            }
        }
    }
    Ok(())
}

#[test]
fn the_comparison_of_machines_finds_a_difference() {
    let machine = |second: &str| {
        let mut model = MachineModel::new("m");
        model.state("a").state("b").initial("a");
        model
            .transition("a", "x", "b", &["one"])
            .transition("b", "x", "a", &[second]);
        model.compile(&mut EventTable::new()).unwrap()
    };
    assert_eq!(are_equivalent(&machine("two"), &machine("two")), Ok(()));
    assert!(are_equivalent(&machine("two"), &machine("three")).is_err());
}

proptest! {
    #[test]
    fn a_machine_comes_back_from_its_net(
        arcs in proptest::collection::hash_map(
            (0u8..6, 0u8..5), (0u8..6, proptest::collection::vec(0u8..7, 0..5)), 1..30),
    ) {
        let model = crate::machines::drawn(&arcs);
        let machine = model.compile(&mut EventTable::new()).unwrap();
        let net = machine.to_net().compile(&mut EventTable::new()).unwrap();
        let back = MachineModel::of_net(&net, &OfNetLimits::default()).unwrap();
        let back = back.compile(&mut EventTable::new()).unwrap();
        prop_assert_eq!(are_equivalent(&machine, &back), Ok(()));
        let names = |machine: &Machine| -> HashSet<String> {
            machine.states().map(|(_, name)| name.to_owned()).collect()
        };
        prop_assert_eq!(names(&machine), names(&back));
    }
}

/// Numbers without a library; the same in every run.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut word = self.0;
        word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((word ^ (word >> 31)) % limit as u64) as usize
    }
}

/// Up to five internal places, three sources, two sinks and seven transitions, of which many share places.
fn random_net(random: &mut Random) -> NetModel {
    let mut net = NetModel::new("random");
    let internal: Vec<String> = (0..2 + random.below(4))
        .map(|each| format!("p{each}"))
        .collect();
    for place in &internal {
        net.place(place);
        if random.below(3) == 0 {
            net.mark(place);
        }
    }
    let sources: Vec<String> = (0..1 + random.below(3))
        .map(|each| format!("?{each}"))
        .collect();
    for source in &sources {
        net.source(source, event(&format!("in {}", random.below(3))));
    }
    let sinks: Vec<String> = (0..random.below(3))
        .map(|each| format!("!{each}"))
        .collect();
    for sink in &sinks {
        net.sink(sink, event(&format!("out {}", random.below(2))));
    }
    for number in 0..2 + random.below(6) {
        let mut inputs: HashSet<&str> =
            HashSet::from([internal[random.below(internal.len())].as_str()]);
        let mut outputs: HashSet<&str> =
            HashSet::from([internal[random.below(internal.len())].as_str()]);
        if random.below(4) > 0 {
            inputs.insert(&sources[random.below(sources.len())]);
        }
        if random.below(4) == 0 {
            outputs.insert(&internal[random.below(internal.len())]);
        }
        if !sinks.is_empty() && random.below(2) == 0 {
            outputs.insert(&sinks[random.below(sinks.len())]);
        }
        let mut inputs: Vec<&str> = inputs.into_iter().collect();
        let mut outputs: Vec<&str> = outputs.into_iter().collect();
        inputs.sort_unstable();
        outputs.sort_unstable();
        net.transition(format!("t{number}"), &inputs, &outputs);
    }
    net
}

/// Offers an event as a machine of `unused` takes it, and returns what the net fires, sorted.
fn offer(net: &mut Executor, event: EventId, unused: Unused, budget: Budget) -> Vec<EventId> {
    let sources: Vec<_> = net.net().sources().to_vec();
    let is_full = |net: &Executor| {
        sources
            .iter()
            .any(|&(place, on)| on == event && net.is_marked(place))
    };
    let mut fired = Vec::new();
    if unused == Unused::Keep && is_full(net) {
        return fired;
    }
    net.offer(event).expect("a source has it, and takes it");
    loop {
        while net.evaluate(budget).remaining {}
        let drained = net.drain_sinks(|output| {
            fired.push(output);
            true
        });
        if drained == 0 {
            break;
        }
    }
    if unused == Unused::Forget {
        for (source, _) in sources {
            net.void_source(source);
        }
    }
    fired.sort_unstable();
    fired
}

#[test]
fn random_nets_and_their_machines_do_the_same() {
    let mut random = Random(1);
    let (mut compared, mut with_several_states) = (0, 0);
    for _ in 0..4_000 {
        let model = random_net(&mut random);
        let mut events = EventTable::new();
        let Ok(net) = model.compile(&mut events) else {
            continue;
        };
        for unused in [Unused::Refuse, Unused::Forget, Unused::Keep] {
            let Ok(machine) = MachineModel::of_net(&net, &limits(unused)) else {
                continue;
            };
            let mut machine = machine.compile(&mut events).unwrap();
            compared += 1;
            with_several_states += usize::from(machine.states().count() > 2);
            let mut executor = net.executor();
            while executor.evaluate(Budget::default()).remaining {}
            if unused == Unused::Forget {
                for &(source, _) in net.sources() {
                    executor.void_source(source);
                }
            }
            for _ in 0..40 {
                let event = net.sources()[random.below(net.sources().len())].1;
                let budget = [Budget::ONE, Budget::ROUND][random.below(2)];
                let mut expected = machine.step(event).outputs.to_vec();
                expected.sort_unstable();
                assert_eq!(
                    offer(&mut executor, event, unused, budget),
                    expected,
                    "{model:?}"
                );
                let shown = |place| {
                    let kind = net.structure().kind(place);
                    unused == Unused::Keep && kind == PlaceKind::Source
                        || kind == PlaceKind::Internal
                };
                let marked: Vec<_> = executor.marking().filter(|&place| shown(place)).collect();
                let names: Vec<_> = marked.iter().map(|&place| net.place_name(place)).collect();
                let name = if names.is_empty() {
                    "-".to_owned()
                } else {
                    names.join(" + ")
                };
                assert_eq!(machine.state_name(machine.state()), name, "{model:?}");
            }
        }
    }
    assert!(
        compared > 800 && with_several_states > 100,
        "only {compared} machines, {with_several_states} of more than two states"
    );
}
