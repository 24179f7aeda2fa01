//! What other tools write.

use coordination::analysis::{Limits, Reason, check, properties};
use coordination::event::EventTable;
use coordination::petri::{Budget, ModelError, NetModel, TransitionId};
use coordination::pnml::{read, read_all};

use super::document;

/// Two users of one printer, on three pages, as a drawing tool writes it.
const PRINTER: &str = include_str!("printer.pnml");

fn printer() -> NetModel {
    let mut net = NetModel::new("printer");
    net.place("free").mark("free");
    for (own, second) in [("a idle", "a & paper"), ("b <idle>", "b prints")] {
        net.place(own).mark(own).place(second);
    }
    net.transition("a takes", &["a idle", "free"], &["a & paper"]);
    net.transition("a gives", &["a & paper"], &["a idle", "free"]);
    net.transition("b takes", &["b <idle>", "free"], &["b prints"]);
    net.transition("b gives", &["b prints"], &["b <idle>", "free"]);
    net
}

#[test]
fn pages_references_and_labels_become_one_net() {
    let (read, expected) = (read(PRINTER).unwrap(), printer());
    assert_eq!(read.name(), expected.name());
    assert!(
        read.places().eq(expected.places()),
        "{:?}",
        read.places().collect::<Vec<_>>()
    );
    assert!(read.transitions().eq(expected.transitions()));
}

#[test]
fn a_net_that_was_read_is_checked_and_runs() {
    let mut model = read(PRINTER).unwrap();
    let refusal = check(&model, &[], &Limits::default()).unwrap_err();
    assert_eq!(*refusal.reason, Reason::Endless);
    let proof = check(model.allow_endless(), &[], &Limits::default()).unwrap();
    assert_eq!((proof.report().states, proof.report().steps), (3, 4));

    let net = model.compile(&mut EventTable::new()).unwrap();
    let mut fired = [TransitionId(0); 4];
    let budget = Budget {
        rounds: 4,
        ..Budget::default()
    };
    assert_eq!(net.executor().evaluate_traced(budget, &mut fired).fired, 4);
    let names = fired.map(|transition| net.transition_name(transition));
    assert_eq!(names, ["a takes", "a gives", "b takes", "b gives"]);
}

/// Nothing empties the final places of a workflow, which PNML cannot declare to be an end.
#[test]
fn a_workflow_is_proved_once_its_end_is_declared() {
    let mut model = read(include_str!("workflow.pnml")).unwrap();
    let refusal = check(&model, &[], &Limits::default()).unwrap_err();
    let Reason::Model(errors) = &*refusal.reason else {
        panic!("{refusal}");
    };
    let is_open = |error: &ModelError| matches!(error, ModelError::UnboundSink { .. });
    assert!(errors.len() == 2 && errors.iter().all(is_open), "{refusal}");
    let found = properties(&model, &[], &Limits::default(), &[]).unwrap();
    assert_eq!((found.states, found.steps), (5, 5));
    assert_eq!(found.deadlock.map(|way| way.steps.len()), Some(3));

    model.end("done", &["paid", "sent"]);
    let proof = check(&model, &[], &Limits::default()).unwrap();
    assert_eq!(proof.report().ends, ["done"]);
    assert!(model.compile(&mut EventTable::new()).is_ok());
}

#[test]
fn names_that_are_missing_or_not_their_own_give_way_to_ids() {
    let arcs = r#"<arc id="x" source="p" target="t"/><arc id="y" source="t" target="q"/>"#;
    let names = |p: &str, q: &str, t: &str| {
        let name = |text: &str| format!("<name><text>{text}</text></name>");
        let (p, q, t) = (name(p), name(q), name(t));
        let net = read(&document(&format!(
            r#"<place id="p">{p}</place><place id="q">{q}</place><transition id="t">{t}</transition>{arcs}"#
        )));
        let net = net.unwrap();
        assert_eq!(net.name(), "n");
        let places: Vec<_> = net.places().map(|place| place.name.to_owned()).collect();
        let transition = net.transitions().next().unwrap();
        assert_eq!(
            (transition.inputs, transition.outputs),
            (vec![&*places[0]], vec![&*places[1]])
        );
        [
            places[0].clone(),
            places[1].clone(),
            transition.name.to_owned(),
        ]
    };
    assert_eq!(names("a", "b", "c"), ["a", "b", "c"]);
    // Names of one that are ids of another do no harm.
    assert_eq!(names("q", "p", "t"), ["q", "p", "t"]);
    assert_eq!(names("a", "a", "c"), ["p", "q", "t"]);
    assert_eq!(names("a", "b", "b"), ["p", "q", "t"]);
    assert_eq!(names("a", " ", "c"), ["p", "q", "t"]);
}

#[test]
fn a_document_may_have_several_nets_and_a_prefix() {
    let text = r#"<x:pnml xmlns:x="http://www.pnml.org/version-2009/grammar/pnml">
        <x:net id="one" type="http://www.pnml.org/version-2009/grammar/ptnet"><x:page id="g"/></x:net>
        <x:net id="two" type="http://www.pnml.org/version-2009/grammar/ptnet"/></x:pnml>"#;
    let names: Vec<_> = { read_all(text).unwrap() }
        .iter()
        .map(|net| net.name().to_owned())
        .collect();
    assert_eq!(names, ["one", "two"]);
    assert_eq!(
        read(text).unwrap_err().to_string(),
        "the document has 2 nets; expected one"
    );
}
