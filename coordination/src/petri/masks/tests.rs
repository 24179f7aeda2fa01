//! Which nets fit. That they fire right is tested with those that do not, in `tests/petri_reference`.

use super::compile::compile;
use super::layout::MAX_BLOCKS;
use crate::petri::NetModel;

/// Processes of two states and one place that all of them need, if `shares`.
fn processes(count: usize, shares: bool) -> NetModel {
    let mut model = NetModel::new("processes");
    let resource = if shares { &["resource"][..] } else { &[] };
    for place in resource {
        model.place(place).mark(place);
    }
    for i in 0..count {
        let (idle, using) = (&*format!("idle{i}"), &*format!("using{i}"));
        model.place(idle).mark(idle).place(using);
        model.transition(format!("take{i}"), &[&[idle], resource].concat(), &[using]);
        model.transition(format!("give{i}"), &[using], &[&[idle], resource].concat());
    }
    model
}

/// In how many blocks, and whether with shared places; nothing if it does not fit.
fn fits(model: &NetModel) -> Option<(usize, bool)> {
    let structure = model.structure().expect("the model is sound");
    let (layout, state) = compile(&structure, &[], &[])?;
    Some((state.blocks.len().max(1), layout.shared != 0))
}

#[test]
fn a_small_net_is_one_word() {
    assert_eq!(fits(&processes(32, false)), Some((1, false)));
    assert_eq!(fits(&processes(31, true)), Some((1, false)));
}

#[test]
fn a_larger_one_has_several_and_shares_what_reaches_across() {
    assert_eq!(fits(&processes(33, false)), Some((2, false)));
    assert_eq!(fits(&processes(32, true)), Some((2, true)));
    assert_eq!(fits(&processes(100, true)), Some((4, true)));
    assert_eq!(
        fits(&processes(32 * MAX_BLOCKS, false)),
        Some((MAX_BLOCKS, false))
    );
}

#[test]
fn a_net_that_is_too_large_does_not_fit() {
    assert_eq!(fits(&processes(32 * MAX_BLOCKS + 1, false)), None);
}

/// All takes before all gives: every process reaches across the cuts.
#[test]
fn nor_one_whose_places_all_reach_across() {
    let mut model = NetModel::new("apart");
    for i in 0..100 {
        let (idle, using) = (format!("idle{i}"), format!("using{i}"));
        model.place(&idle).mark(&idle).place(&using);
        model.transition(format!("take{i}"), &[&idle], &[&using]);
    }
    for i in 0..100 {
        let (idle, using) = (format!("idle{i}"), format!("using{i}"));
        model.transition(format!("give{i}"), &[&using], &[&idle]);
    }
    assert_eq!(fits(&model), None);
}

/// One transition is never cut: 260 places of its own do not fit into a word.
#[test]
fn nor_one_whose_transition_has_more_places_than_a_word() {
    let mut model = NetModel::new("many");
    let names: Vec<String> = (0..260).map(|i| format!("part{i}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    for name in &names {
        model.place(name).mark(name);
    }
    model.place("whole");
    model.transition("join", &names, &["whole"]);
    model.end("whole", &["whole"]);
    assert_eq!(fits(&model), None);
}
