//! What is wrong with a model is said of the element that it is wrong with.

use coordination::event::EventTable;
use coordination::petri::{Binding, ModelError, NetModel, PlaceId, PlaceKind};

/// A gate that is asked for, taken and left.
fn gate() -> NetModel {
    let mut model = NetModel::new("gate");
    model.place("free").mark("free").place("taken");
    model.source("asked", Binding::flag("area", "request"));
    model.sink("granted", Binding::flag("area", "granted"));
    model.source("left", Binding::event("leave"));
    model.transition("enter", &["asked", "free"], &["taken", "granted"]);
    model.transition("leave", &["left", "taken"], &["free"]);
    model
}

/// Exactly one thing is wrong, and its message has these words.
fn refused(model: &NetModel, words: &[&str]) -> ModelError {
    let errors = model.check();
    assert_eq!(errors.len(), 1, "{errors:#?}");
    let mut events = EventTable::new();
    assert_eq!(model.compile(&mut events).unwrap_err(), errors);
    assert!(events.is_empty(), "a refused model enters no events");
    let message = errors[0].to_string();
    for word in words {
        assert!(message.contains(word), "`{message}` lacks `{word}`");
    }
    errors.into_iter().next().unwrap()
}

#[test]
fn a_sound_model_compiles_and_tells_what_it_is() {
    let model = gate();
    assert_eq!(model.check(), []);
    let mut events = EventTable::new();
    let net = model.compile(&mut events).unwrap();

    let enter = net.transition_id("enter").unwrap();
    assert_eq!(net.transition_name(enter), "enter");
    let asked = net.place_id("asked").unwrap();
    assert_eq!(net.place_name(asked), "asked");
    assert_eq!(net.place_id("enter"), None);
    assert_eq!(net.transition_id("nothing"), None);
    assert_eq!(net.structure().kind(asked), PlaceKind::Source);
    assert_eq!(
        net.sources()[0],
        (asked, events.id("area.request").unwrap())
    );
    assert_eq!(net.sinks()[0].1, events.id("area.granted").unwrap());
    let marked: Vec<_> = net.initial_marking().map(|p| net.place_name(p)).collect();
    assert_eq!(marked, ["free"]);

    let transitions: Vec<_> = model.transitions().collect();
    assert_eq!(transitions[0].inputs, ["asked", "free"]);
    assert_eq!(transitions[0].outputs, ["taken", "granted"]);
    assert_eq!(net.model().places().count(), 5);
}

#[test]
fn the_order_of_declaration_of_different_things_does_not_matter() {
    let mut model = NetModel::new("late");
    model.arc("a", "t").arc("t", "b").mark("a");
    model
        .transition("t", &[], &[])
        .transition("back", &["b"], &["a"]);
    model.place("a").place("b");
    assert_eq!(model.check(), []);
    assert_eq!(model.transitions().next().unwrap().inputs, ["a"]);
}

#[test]
fn a_changed_copy_leaves_the_compiled_net_alone() {
    let mut model = gate();
    let net = model.compile(&mut EventTable::new()).unwrap();
    model
        .place("more")
        .mark("more")
        .transition("use", &["more"], &[]);
    assert_eq!(model.check(), []);
    assert_eq!(net.place_id("more"), None);
    assert_eq!(net.transitions().len(), 2);
}

#[test]
fn unknown_names_are_named() {
    let mut model = gate();
    model.arc("nowhere", "enter");
    refused(&model, &["gate", "nowhere", "enter", "neither"]);
    let mut model = gate();
    model.mark("nowhere");
    refused(&model, &["initial marking", "nowhere"]);
    let mut model = gate();
    model.end("over", &["nowhere"]);
    refused(&model, &["end `over`", "nowhere"]);
    let mut model = gate();
    model.exclusion("one", &["free", "enter"]);
    refused(&model, &["exclusion `one`", "transition `enter`"]);
}

#[test]
fn duplicate_names_are_named() {
    let mut model = gate();
    model.place("free");
    refused(&model, &["free", "a place and for a place"]);
    let mut model = gate();
    model.transition("enter", &["free"], &[]);
    refused(&model, &["enter", "a transition and for a transition"]);
    let mut model = gate();
    model.place("enter");
    refused(&model, &["enter", "a transition and for a place"]);
    let mut model = gate();
    model.end("over", &["free"]).end("over", &[]);
    refused(&model, &["over", "an end"]);
}

#[test]
fn empty_names_are_refused() {
    let mut model = gate();
    model.place("").arc("", "enter").mark("");
    refused(&model, &["a place without a name"]);
    let mut model = gate();
    model.source("x", Binding::flag("", "y")).arc("x", "enter");
    refused(&model, &["a protocol without a name"]);
    let mut model = gate();
    model.exclusion("", &["free", "taken"]);
    refused(&model, &["an exclusion without a name"]);
}

#[test]
fn arcs_between_equals_and_double_arcs_are_named() {
    let mut model = gate();
    model.arc("free", "taken");
    refused(&model, &["`free` to `taken`", "two places"]);
    let mut model = gate();
    model.arc("enter", "leave");
    refused(&model, &["`enter` to `leave`", "two transitions"]);
    let mut model = gate();
    model.arc("free", "enter");
    refused(&model, &["`free` to `enter`", "twice"]);
    let mut model = gate();
    model.arc("leave", "free");
    refused(&model, &["`leave` to `free`", "twice"]);
}

#[test]
fn sources_are_only_filled_and_sinks_only_emptied_from_outside() {
    let mut model = gate();
    model.arc("leave", "asked");
    refused(&model, &["`leave`", "source `asked`"]);
    let mut model = gate();
    model.arc("granted", "leave");
    refused(&model, &["`leave`", "sink `granted`"]);
}

#[test]
fn unbound_and_isolated_places_are_named() {
    let mut model = gate();
    model.place("permit").arc("permit", "enter");
    refused(&model, &["permit", "never marked"]);
    // A first mark that is used once is no source.
    model.mark("permit");
    assert_eq!(model.check(), []);

    let mut model = gate();
    model.place("log").arc("enter", "log");
    refused(&model, &["log", "never emptied"]);
    // A mark that is there at an end is no sink.
    model.end("over", &["log", "free"]);
    assert_eq!(model.check(), []);

    let mut model = gate();
    model.sink("alone", Binding::event("x"));
    refused(&model, &["alone", "no arc"]);
}

#[test]
fn transitions_need_an_input_and_nets_a_transition() {
    let mut model = gate();
    model.transition("always", &[], &["granted"]);
    refused(&model, &["always", "no input"]);
    refused(&NetModel::new("empty"), &["empty", "no transitions"]);
}

#[test]
fn marks_ends_and_exclusions_make_sense() {
    let mut model = gate();
    model.mark("free");
    refused(&model, &["initial marking", "free", "twice"]);
    let mut model = gate();
    model.exclusion("one", &["free"]);
    refused(&model, &["one", "1 places", "at least two"]);
    let mut model = gate();
    model.end("over", &["granted"]);
    refused(&model, &["over", "granted", "not internal"]);
}

#[test]
fn a_set_names_each_place_once_and_shares_places_with_others() {
    let mut model = gate();
    model.exclusion("one", &["free", "taken", "free"]);
    refused(&model, &["exclusion `one`", "free", "twice"]);
    let mut model = gate();
    model.end("over", &["free", "free"]);
    refused(&model, &["end `over`", "free", "twice"]);
    let mut model = gate();
    model
        .exclusion("one", &["free", "taken"])
        .exclusion("same", &["taken", "free"]);
    model.end("over", &["free"]).end("also", &["free", "taken"]);
    assert_eq!(model.check(), []);
    // Names of exclusions and of ends are apart.
    model.exclusion("over", &["free", "taken"]);
    assert_eq!(model.check(), []);
    model.exclusion("one", &["free", "taken"]);
    refused(&model, &["`one`", "an exclusion"]);
}

#[test]
fn arcs_in_any_order_make_the_same_net() {
    let mut model = NetModel::new("mixed");
    model.place("a").mark("a").place("b");
    model.transition("t", &["a"], &[]);
    model.transition("back", &["b"], &["a"]);
    model.arc("t", "b");
    let structure = model.structure().unwrap();
    let names = |places: &[PlaceId]| places.iter().map(|place| place.0).collect::<Vec<_>>();
    let lists: Vec<_> = structure
        .transitions()
        .map(|t| (names(structure.inputs(t)), names(structure.outputs(t))))
        .collect();
    assert_eq!(lists, [(vec![0], vec![1]), (vec![1], vec![0])]);
    model.arc("a", "t");
    refused(&model, &["`a` to `t`", "twice"]);
}

#[test]
fn two_flags_with_one_event_name_are_refused() {
    let mut model = gate();
    model
        .source("x", Binding::flag("a.b", "c"))
        .arc("x", "enter");
    model
        .source("y", Binding::flag("a", "b.c"))
        .arc("y", "leave");
    refused(&model, &["`x`", "`y`", "a.b.c"]);
    // The same flag twice is one flag.
    let mut model = gate();
    model.source("x", Binding::flag("a", "b")).arc("x", "enter");
    model.source("y", Binding::flag("a", "b")).arc("y", "leave");
    assert_eq!(model.check(), []);
}

#[test]
fn all_problems_are_reported() {
    let mut model = gate();
    model.mark("nowhere").arc("free", "taken").place("alone");
    let messages: Vec<_> = model.check().iter().map(ToString::to_string).collect();
    assert_eq!(messages.len(), 3, "{messages:#?}");
}

#[test]
fn nets_larger_than_the_tables_are_refused() {
    let mut model = NetModel::new("large");
    model.place("a").mark("a");
    for number in 0..=NetModel::MAX_TRANSITIONS {
        model.transition(format!("t{number}"), &["a"], &["a"]);
    }
    let error = refused(&model, &["65537 transitions", "65536"]);
    assert!(matches!(error, ModelError::TooLarge { .. }));
}

#[test]
fn the_largest_net_runs() {
    let mut model = NetModel::new("largest");
    let places = NetModel::MAX_PLACES;
    for number in 0..places {
        model.place(format!("p{number}"));
    }
    model.mark("p0");
    for number in 0..NetModel::MAX_TRANSITIONS {
        let (from, to) = (number % places, (number + 1) % places);
        model.transition(
            format!("t{number}"),
            &[&format!("p{from}")],
            &[&format!("p{to}")],
        );
    }
    let net = model.compile(&mut EventTable::new()).unwrap();
    let mut executor = net.executor();
    let evaluation = executor.evaluate(coordination::petri::Budget::ROUND);
    assert_eq!(evaluation.fired as usize, NetModel::MAX_TRANSITIONS);
    assert!(executor.is_marked(net.place_id("p0").unwrap()));
}
