//! Our nets come back as they were.

use coordination::petri::{Binding, NetModel};
use coordination::pnml::{Document, read};
use proptest::prelude::*;

fn assert_same(read: &NetModel, written: &NetModel) {
    assert_eq!(read.name(), written.name());
    assert_eq!(
        read.places().collect::<Vec<_>>(),
        written.places().collect::<Vec<_>>()
    );
    let transitions = |net: &NetModel| format!("{:?}", net.transitions().collect::<Vec<_>>());
    assert_eq!(transitions(read), transitions(written));
    assert_eq!(
        read.exclusions().collect::<Vec<_>>(),
        written.exclusions().collect::<Vec<_>>()
    );
    assert_eq!(
        read.ends().collect::<Vec<_>>(),
        written.ends().collect::<Vec<_>>()
    );
    assert_eq!(read.allows_endless(), written.allows_endless());
}

/// Any characters that XML can hold, and names that look alike.
fn name() -> impl Strategy<Value = String> {
    let odd = "[ \t\n\r<>&\"'\\]a-cé\u{1F600}\u{7F}\u{85}\u{2028}]{1,6}";
    prop_oneof![3 => odd, 1 => "[a-c]{1,3}"]
}

const SOURCES: &[u8] = &[0, 1];
const SINKS: &[u8] = &[2];

#[derive(Clone, Debug)]
struct Drawn {
    net: String,
    names: Vec<String>,
    kinds: Vec<u8>,
    marked: Vec<bool>,
    arcs: Vec<(Vec<usize>, Vec<usize>)>,
    endless: bool,
}

fn drawn() -> impl Strategy<Value = Drawn> {
    let some = || prop::collection::vec(0..8_usize, 1..4);
    (
        name(),
        prop::collection::btree_set(name(), 20),
        prop::collection::vec(0..5_u8, 8),
        prop::collection::vec(any::<bool>(), 8),
        prop::collection::vec((some(), some()), 1..5),
        any::<bool>(),
    )
        .prop_map(|(net, names, kinds, marked, arcs, endless)| Drawn {
            net,
            names: names.into_iter().collect(),
            kinds,
            marked,
            arcs,
            endless,
        })
}

/// A sound net, unless names of events and flags clash.
fn build(drawn: &Drawn) -> NetModel {
    let mut net = NetModel::new(&drawn.net);
    let (places, kinds) = (&drawn.names[..8], &drawn.kinds);
    let kept = &*drawn.names[13];
    // Transitions first: the order of declaration among places is what counts.
    for (number, (from, to)) in drawn.arcs.iter().enumerate() {
        let names = |list: &[usize], without: &[u8]| {
            let mut names: Vec<&str> = Vec::new();
            for &place in list {
                if !without.contains(&kinds[place]) && !names.contains(&&*places[place]) {
                    names.push(&places[place]);
                }
            }
            names
        };
        let (mut inputs, mut outputs) = (names(from, SINKS), names(to, SOURCES));
        if number == 0 {
            // Every place has an arc.
            let all = [0, 1, 2, 3, 4, 5, 6, 7];
            (inputs, outputs) = (names(&all, SINKS), names(&all, SOURCES));
        }
        inputs.push(kept);
        outputs.push(kept);
        net.transition(&drawn.names[8 + number], &inputs, &outputs);
    }
    let mut internal = vec![kept];
    for ((place, kind), &marked) in places.iter().zip(kinds).zip(&drawn.marked) {
        match kind {
            0 => net.source(place, Binding::event(&drawn.names[14])),
            1 => net.source(place, Binding::flag(&drawn.names[15], &drawn.names[16])),
            2 => net.sink(place, Binding::flag(&drawn.names[15], &drawn.names[17])),
            _ => {
                internal.push(place);
                net.place(place)
            }
        };
        if marked {
            net.mark(place);
        }
    }
    net.place(kept).end(&drawn.names[18], &internal);
    if internal.len() > 1 {
        net.exclusion(&drawn.names[19], &internal);
    }
    if drawn.endless {
        net.allow_endless();
    }
    net
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_sound_net_comes_back_as_it_was(drawn in drawn()) {
        let net = build(&drawn);
        prop_assert_eq!(net.check(), []);
        assert_same(&read(&Document::new(&net).unwrap().to_string()).unwrap(), &net);
    }
}

#[test]
fn a_document_says_all_of_a_net() {
    let mut net = NetModel::new("gate");
    net.place("free").mark("free").place("in & out");
    net.source("asked", Binding::flag("robot", "request"));
    net.sink("may", Binding::event("go"));
    net.transition("enter", &["asked", "free"], &["in & out", "may"]);
    net.transition("leave", &["in & out"], &["free"]);
    net.exclusion("one", &["free", "in & out"])
        .end("idle", &["free"])
        .allow_endless();
    assert_eq!(
        Document::new(&net).unwrap().to_string(),
        include_str!("gate.pnml")
    );
}
