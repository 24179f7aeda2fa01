use proptest::prelude::*;

use super::*;
use crate::event::{EventId, EventTable};

/// The three areas of a robot that crosses a shared one.
fn crossing() -> MachineModel {
    let mut model = MachineModel::new("crossing");
    for state in ["outside", "waiting", "inside"] {
        model.state(state);
    }
    model.initial("outside");
    model.transition("outside", "near", "waiting", &["request"]);
    model.transition("waiting", "granted", "inside", &["enter", "speed_low"]);
    model.transition("waiting", "near", "waiting", &["request"]);
    model.transition("inside", "left", "outside", &[]);
    model
}

#[test]
fn a_machine_walks_fires_and_ignores() {
    let mut events = EventTable::new();
    let foreign = events.intern("somebody else's").unwrap();
    let mut machine = crossing().compile(&mut events).unwrap();
    let id = |name| events.id(name).unwrap();
    assert_eq!(machine.state_name(machine.state()), "outside");

    assert!(machine.step(id("granted")).ignored);
    assert!(machine.step(foreign).ignored);
    assert!(machine.step(EventId(u16::MAX)).ignored);
    assert_eq!(machine.ignored(), 3);

    let step = machine.step(id("near"));
    assert_eq!((step.outputs, step.ignored), (&[id("request")][..], false));
    let again = machine.step(id("near"));
    assert_eq!(again.from, again.to);
    assert!(!again.ignored, "a transition onto itself is a transition");
    assert_eq!(
        machine.step(id("granted")).outputs,
        [id("enter"), id("speed_low")]
    );
    let inside = machine.state_id("inside").unwrap();
    assert_eq!(machine.state(), inside);
    assert!(machine.accepts(id("left")));
    assert_eq!(machine.step(id("left")).outputs, []);

    assert!(machine.restart_in(inside));
    assert_eq!(machine.state(), inside);
    assert!(!machine.restart_in(StateId(3)));
    assert_eq!(machine.state(), inside);
    machine.reset();
    assert_eq!(machine.state(), machine.initial());
    assert_eq!(machine.ignored(), 3);
}

#[test]
fn names_and_lists_are_for_printing() {
    let mut events = EventTable::new();
    let machine = crossing().compile(&mut events).unwrap();
    let lines: Vec<String> = machine
        .transitions()
        .map(|t| {
            let outputs: Vec<_> = t.outputs.iter().map(|&o| machine.output_name(o)).collect();
            let (from, to) = (machine.state_name(t.from), machine.state_name(t.to));
            format!("{from} {} {to} {outputs:?}", machine.input_name(t.on))
        })
        .collect();
    assert_eq!(
        lines,
        [
            r#"outside near waiting ["request"]"#,
            r#"waiting near waiting ["request"]"#,
            r#"waiting granted inside ["enter", "speed_low"]"#,
            r#"inside left outside []"#,
        ]
    );
    assert_eq!(machine.input("near"), events.id("near"));
    assert_eq!(machine.input("request"), None);
    assert_eq!(machine.output("request"), events.id("request"));
    assert_eq!(machine.states().count(), 3);
    assert_eq!(machine.inputs().count(), 3);
    assert_eq!(machine.outputs().count(), 3);
    assert_eq!(machine.state_name(StateId(9)), "?");
}

#[test]
fn the_output_of_one_machine_is_the_input_of_another() {
    let mut events = EventTable::new();
    let mut robot = crossing().compile(&mut events).unwrap();
    let mut model = MachineModel::new("manager");
    model.state("free").state("taken").initial("free");
    model.transition("free", "request", "taken", &["granted"]);
    let mut manager = model.compile(&mut events).unwrap();

    let request = robot.step(events.id("near").unwrap()).outputs[0];
    let granted = manager.step(request).outputs[0];
    robot.step(granted);
    assert_eq!(robot.state_name(robot.state()), "inside");
}

fn first_error(model: &MachineModel) -> String {
    let mut events = EventTable::new();
    let error = model.compile(&mut events).unwrap_err();
    assert!(events.is_empty(), "a refused model leaves no events behind");
    error.to_string()
}

#[test]
fn a_wrong_model_is_refused_with_its_reason() {
    let mut model = MachineModel::new("m");
    assert_eq!(first_error(&model), "machine `m` has no states");
    model.state("a").state("b");
    assert_eq!(first_error(&model), "machine `m` has no initial state");
    model.initial("c");
    assert_eq!(
        first_error(&model),
        "machine `m`: the initial state names the unknown state `c`; known states: a, b"
    );

    let base = || {
        let mut model = MachineModel::new("m");
        model.state("a").state("b").initial("a");
        model.transition("a", "go", "b", &[]);
        model
    };
    assert_eq!(
        first_error(base().initial("b")),
        "machine `m` has two initial states, `a` and `b`"
    );
    assert_eq!(
        first_error(base().state("a")),
        "machine `m` has two states named `a`"
    );
    assert_eq!(
        first_error(base().state("")),
        "machine `m` has a state without a name"
    );
    assert_eq!(
        first_error(base().transition("b", "back", "a", &[""])),
        "machine `m` has an event without a name"
    );
    assert_eq!(
        first_error(base().transition("b", "go", "x", &[])),
        "machine `m`: the transition from `b` on `go` names the unknown state `x`; known states: a, b"
    );
    assert_eq!(
        first_error(base().transition("a", "go", "a", &[])),
        "machine `m`: state `a` has two transitions on `go`, to `b` and to `a`"
    );
    assert_eq!(
        first_error(base().state("c").transition("c", "x", "a", &[])),
        "machine `m`: state `c` can never be reached from `a`"
    );
    assert!(
        base().initial("a").check().is_empty(),
        "said twice is no contradiction"
    );
}

#[test]
fn check_reports_every_error() {
    let mut model = MachineModel::new("m");
    model.state("a").state("a").initial("b");
    model.transition("c", "e", "d", &[]);
    assert_eq!(model.check().len(), 4);
}

#[test]
fn a_machine_that_is_too_large_is_refused() {
    let mut model = MachineModel::new("m");
    let outputs = ["e"; 40_000];
    model.state("a").initial("a");
    model.transition("a", "x", "a", &outputs);
    assert!(model.compile(&mut EventTable::new()).is_ok());
    model.transition("a", "y", "a", &outputs);
    assert_eq!(
        first_error(&model),
        "machine `m` has 80000 outputs; at most 65534 fit"
    );

    let mut model = MachineModel::new("m");
    for number in 0..1100 {
        let name = format!("s{number}");
        model.transition(&name, &format!("e{number}"), "s0", &[]);
        model.state(name);
    }
    assert_eq!(
        first_error(model.initial("s0")),
        "machine `m` has 1210000 cells of state and input; at most 1048576 fit"
    );
}

proptest! {
    /// The dense tables do what a search through the list of transitions does.
    #[test]
    fn tables_agree_with_the_list(
        arcs in proptest::collection::hash_map((0u8..6, 0u8..5), (0u8..6, 0usize..3), 0..30),
        inputs in proptest::collection::vec(0u8..7, 0..60),
    ) {
        let mut model = MachineModel::new("random");
        for state in 0..6 {
            model.state(format!("s{state}"));
        }
        model.initial("s0");
        // A ring keeps every state reachable.
        for state in 0..6 {
            model.transition(&format!("s{state}"), "ring", &format!("s{}", (state + 1) % 6), &[]);
        }
        for (&(from, on), &(to, outputs)) in &arcs {
            let fired = [format!("o{on}"), "common".to_owned()];
            let fired: Vec<&str> = fired.iter().take(outputs).map(String::as_str).collect();
            model.transition(&format!("s{from}"), &format!("e{on}"), &format!("s{to}"), &fired);
        }
        let mut events = EventTable::new();
        let mut machine = model.compile(&mut events).unwrap();
        let (mut state, mut ignored) = (0, 0);
        for input in inputs {
            let name = if input == 5 { "ring".to_owned() } else { format!("e{input}") };
            let id = events.intern(&name).unwrap();
            let expected = match input {
                5 => Some(((state + 1) % 6, 0)),
                _ => arcs.get(&(state, input)).copied(),
            };
            let step = machine.step(id);
            prop_assert_eq!(step.ignored, expected.is_none());
            prop_assert_eq!(step.outputs.len(), expected.map_or(0, |(_, outputs)| outputs));
            match expected {
                Some((to, _)) => state = to,
                None => ignored += 1,
            }
            let found = machine.state_name(machine.state()).to_owned();
            prop_assert_eq!(found, format!("s{state}"));
        }
        prop_assert_eq!(machine.ignored(), ignored);
    }
}

/// A copy of all names for each would be 2 GB.
#[test]
fn many_unknown_states_are_told_with_some_that_are_known() {
    let mut model = MachineModel::new("m");
    let names: Vec<String> = (0..10_000)
        .map(|number| format!("state {number}"))
        .collect();
    for name in &names {
        model.state(name);
        model.transition(name, "go", "nowhere", &[]);
    }
    model.initial("state 0");
    let errors = model.check();
    assert_eq!(errors.len(), 10_000);
    for error in errors {
        let ModelError::UnknownState { known, .. } = error else {
            panic!("{error}");
        };
        assert!(known.ends_with("state 11 and 9988 more"), "{known}");
    }
}
