//! A state machine and the net it converts to do the same.

use coordination::event::{EventId, EventTable};
use coordination::fsm::{Machine, MachineModel};
use coordination::petri::{Budget, Executor, PlaceKind};
use proptest::prelude::*;

/// The states that are marked, which must be one; states come first among the places.
fn state_of(net: &Executor, machine: &Machine) -> String {
    let states = machine.states().count();
    let marked: Vec<_> = net
        .marking()
        .filter(|place| place.index() < states)
        .collect();
    assert_eq!(marked.len(), 1, "a machine is in exactly one state");
    net.net().place_name(marked[0]).to_owned()
}

/// Offers one event, and returns what the net fires, sorted.
fn step(net: &mut Executor, event: EventId) -> Vec<EventId> {
    let mut fired = Vec::new();
    if net.offer(event).is_ok() {
        let evaluation = net.evaluate(Budget::default());
        assert_eq!((evaluation.fired, evaluation.remaining), (1, false));
        net.drain_sinks(|output| {
            fired.push(output);
            true
        });
    }
    fired.sort_unstable();
    fired
}

#[test]
fn the_net_of_a_machine_can_be_read() {
    let mut model = MachineModel::new("crossing");
    model.state("outside").state("inside").initial("outside");
    model.transition("outside", "granted", "inside", &["entered", "entered"]);
    model.transition("inside", "left", "outside", &["released"]);
    let machine = model.compile(&mut EventTable::new()).unwrap();
    let net = machine.to_net();
    assert!(net.check().is_empty());
    let kind = |kind| {
        let places = net.places().filter(move |place| place.kind == kind);
        places
            .map(|place| place.name.to_owned())
            .collect::<Vec<_>>()
    };
    assert_eq!(kind(PlaceKind::Internal), ["outside", "inside"]);
    assert_eq!(kind(PlaceKind::Source), ["?granted", "?left"]);
    assert_eq!(
        kind(PlaceKind::Sink),
        ["!entered", "!entered 2", "!released"]
    );
    let transitions: Vec<_> = net
        .transitions()
        .map(|t| {
            format!(
                "{}: {} -> {}",
                t.name,
                t.inputs.join(", "),
                t.outputs.join(", ")
            )
        })
        .collect();
    assert_eq!(
        transitions,
        [
            "outside ?granted: outside, ?granted -> inside, !entered, !entered 2",
            "outside ?left: outside, ?left -> outside",
            "inside ?granted: inside, ?granted -> inside",
            "inside ?left: inside, ?left -> outside, !released",
        ]
    );
    assert_eq!(net.exclusions().count(), 1);
}

#[test]
fn names_that_collide_are_told_apart() {
    let mut model = MachineModel::new("m");
    model.state("?e").state("!e").state("?e ?e").initial("?e");
    model.transition("?e", "e", "!e", &["e"]);
    model.transition("!e", "e", "?e ?e", &["e"]);
    let mut events = EventTable::new();
    let machine = model.compile(&mut events).unwrap();
    let net = machine.to_net().compile(&mut events).unwrap();
    let mut net = net.executor();
    let e = events.id("e").unwrap();
    assert_eq!(step(&mut net, e), [e]);
    assert_eq!(state_of(&net, &machine), "!e");
    assert_eq!(step(&mut net, e), [e]);
    assert_eq!(state_of(&net, &machine), "?e ?e");
    assert_eq!(step(&mut net, e), []);
}

#[test]
fn a_machine_in_which_nothing_happens_is_no_net() {
    let mut model = MachineModel::new("m");
    model.state("a").initial("a");
    let machine = model.compile(&mut EventTable::new()).unwrap();
    assert_eq!(machine.to_net().check().len(), 1);
}

proptest! {
    #[test]
    fn machine_and_net_do_the_same(
        arcs in proptest::collection::hash_map(
            (0u8..6, 0u8..5), (0u8..6, proptest::collection::vec(0u8..7, 0..5)), 1..30),
        inputs in proptest::collection::vec(0u8..8, 0..80),
    ) {
        let model = crate::machines::drawn(&arcs);
        let mut events = EventTable::new();
        let mut machine = model.compile(&mut events).unwrap();
        let net = machine.to_net().compile(&mut events).unwrap();
        let mut net = net.executor();
        for input in inputs {
            let name = if input == 7 { "ring".to_owned() } else { format!("e{input}") };
            let event = events.intern(&name).unwrap();
            let mut expected = machine.step(event).outputs.to_vec();
            expected.sort_unstable();
            prop_assert_eq!(step(&mut net, event), expected);
            let state = machine.state_name(machine.state()).to_owned();
            prop_assert_eq!(state_of(&net, &machine), state);
        }
    }
}
