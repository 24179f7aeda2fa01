//! Models: what they mean, and what is refused.

use coordination::protocol::{Party, Position, Problem, Protocol, ProtocolModel};
use proptest::prelude::*;

use super::common::{any_protocol, crossing, crossing_model, flag};

#[test]
fn a_compiled_protocol_can_be_walked() {
    let protocol = crossing();
    let [robot, mediator] = ["robot", "mediator"].map(|name| protocol.party(name).unwrap());
    assert_eq!((robot, mediator), (Party::First, Party::Second));
    assert_eq!(protocol.keeper(), Some(mediator));
    assert_eq!(protocol.party("nobody"), None);
    assert_eq!(protocol.flags().count(), 5);

    let at = |names: &[&str]| {
        let mut position = Position::START;
        for name in names {
            position = protocol.after(position, flag(&protocol, name)).unwrap();
        }
        position
    };
    assert_eq!(protocol.turn(Position::START), Some(robot));
    let asked = at(&["request"]);
    assert_eq!(protocol.turn(asked), Some(mediator));
    let names: Vec<_> = protocol
        .next(asked)
        .map(|(next, _)| protocol.flag_name(next))
        .collect();
    assert_eq!(names, ["granted", "refused"]);
    let refused = at(&["request", "refused"]);
    let released = at(&["request", "granted", "entered", "released"]);
    for end in [refused, released] {
        assert!(protocol.is_end(end));
        assert_eq!((protocol.turn(end), protocol.next(end).count()), (None, 0));
    }
    assert_eq!(
        protocol.positions().filter(|&p| protocol.is_end(p)).count(),
        2
    );
    assert_eq!(
        protocol.describe(released).to_string(),
        "request, granted, entered, released"
    );
    assert_eq!(
        protocol.describe(Position::START).to_string(),
        "nothing set"
    );

    assert_eq!(protocol.paths(), 2);
    assert_eq!(protocol.position(0, 4), Some(released));
    assert_eq!(protocol.position(0, 5), None);
    assert_eq!(protocol.position(1, 2), Some(refused));
    assert_eq!(protocol.position(1, 1), Some(asked));
    assert_eq!((protocol.path(asked), protocol.progress(asked)), (0, 1));
    assert_eq!((protocol.path(refused), protocol.progress(refused)), (1, 2));
    assert_eq!(protocol.position(2, 0), None);
    assert!(protocol.leads(asked, refused) && !protocol.leads(refused, released));
    assert_eq!(
        protocol.before(refused),
        Some((flag(&protocol, "refused"), asked))
    );
    assert_eq!(protocol.before(Position::START), None);
}

fn errors(model: &ProtocolModel) -> Vec<String> {
    let errors: Vec<_> = model.check().iter().map(ToString::to_string).collect();
    let first = model.compile().err().map(|error| error.to_string());
    assert_eq!(first.as_ref(), errors.first());
    errors
}

#[test]
fn a_wrong_model_is_refused_with_its_reason() {
    let base = || {
        let mut model = ProtocolModel::new("p", "a", "b");
        model.array("one", &[("x", "a"), ("y", "b")]);
        model
    };
    assert_eq!(errors(&base()), [""; 0]);
    let check = |change: &dyn Fn(&mut ProtocolModel), expected: &str| {
        let mut model = base();
        change(&mut model);
        assert_eq!(errors(&model), [expected]);
    };
    assert_eq!(
        errors(&ProtocolModel::new("p", "a", "b")),
        ["protocol `p` has no arrays"]
    );
    assert_eq!(
        errors(ProtocolModel::new("p", "a", "a").array("one", &[("x", "a")])),
        ["protocol `p`: both parties are called `a`"]
    );
    assert_eq!(
        errors(ProtocolModel::new("p", "a", "").array("one", &[("x", "a")])),
        ["protocol `p` has a party without a name"]
    );
    assert_eq!(
        errors(ProtocolModel::new("", "a", "b").array("one", &[("x", "a")])),
        ["protocol `` has no name"]
    );
    check(
        &|m| {
            m.keeper("c");
        },
        "protocol `p`: the keeper names the unknown party `c`; expected `a` or `b`",
    );
    check(
        &|m| {
            m.keeper("a").keeper("b");
        },
        "protocol `p` has two keepers, `a` and `b`",
    );
    check(
        &|m| {
            m.array("one", &[("z", "a")]);
        },
        "protocol `p` has two arrays named `one`",
    );
    check(
        &|m| {
            m.array("two", &[]).follow("one", "two");
        },
        "protocol `p`: array `two` has no entries",
    );
    check(
        &|m| {
            m.array("", &[("z", "a")]);
        },
        "protocol `p` has an array without a name",
    );
    check(
        &|m| {
            m.array("two", &[("", "a")]).follow("one", "two");
        },
        "protocol `p` has a flag without a name",
    );
    check(
        &|m| {
            m.array("two", &[("aborted", "a")]).follow("one", "two");
        },
        "protocol `p`: no flag can be called `aborted`, which is what an aborted run is called",
    );
    check(
        &|m| {
            m.array("two", &[("z", "c")]).follow("one", "two");
        },
        "protocol `p`: flag `z` names the unknown party `c`; expected `a` or `b`",
    );
    check(
        &|m| {
            m.array("two", &[("y", "a")]).start("one").start("two");
        },
        "protocol `p`: flag `y` belongs to `b` and to `a`",
    );
    check(
        &|m| {
            m.follow("one", "two");
        },
        "protocol `p`: what follows `one` names the unknown array `two`; known arrays: one",
    );
    check(
        &|m| {
            m.start("two");
        },
        "protocol `p`: the start names the unknown array `two`; known arrays: one",
    );
}

#[test]
fn a_wrong_order_is_refused_with_its_reason() {
    let arrays = |arrays: &[(&str, &str)], follows: &[(&str, &str)]| {
        let mut model = ProtocolModel::new("p", "a", "b");
        for &(name, entries) in arrays {
            // `x+` is flag `x` of party a, `x-` of party b.
            let entries: Vec<_> = entries
                .split(' ')
                .map(|entry| match entry.strip_suffix('+') {
                    Some(flag) => (flag, "a"),
                    None => (entry.trim_end_matches('-'), "b"),
                })
                .collect();
            model.array(name, &entries);
        }
        for &(array, next) in follows {
            model.follow(array, next);
        }
        errors(&model)
    };
    assert_eq!(
        arrays(
            &[("one", "x+"), ("two", "y+"), ("three", "y+ z-")],
            &[("one", "two"), ("one", "three")]
        ),
        [
            "protocol `p`: array `one` can go on with `two` or `three`, which both begin with flag `y`"
        ]
    );
    assert_eq!(
        arrays(
            &[("one", "x+"), ("two", "y+"), ("three", "z-")],
            &[("one", "two"), ("one", "three")]
        ),
        [
            "protocol `p`: array `one` can go on with `two`, begun by `a`, or `three`, begun by `b`; one party must choose"
        ]
    );
    assert_eq!(
        arrays(
            &[("one", "x+"), ("two", "y+"), ("three", "z-")],
            &[("one", "two"), ("two", "three"), ("three", "two")]
        ),
        ["protocol `p`: array `three` would follow itself; a run must end"]
    );
    assert_eq!(
        arrays(&[("one", "x+")], &[("one", "one")]),
        ["protocol `p`: array `one` would follow itself; a run must end"]
    );
    assert_eq!(
        arrays(&[("one", "x+"), ("two", "y+")], &[]),
        ["protocol `p`: no path from the beginning leads to array `two`"]
    );
    assert_eq!(
        arrays(&[("one", "x+ y-"), ("two", "z+ x+")], &[("one", "two")]),
        ["protocol `p`: flag `x` of array `two` is already set when the run gets there"]
    );
    assert_eq!(arrays(&[("one", "x+ y-")], &[]), [""; 0]);
    assert_eq!(
        arrays(
            &[("one", "x+"), ("two", "y+"), ("three", "z+"), ("end", "w-")],
            &[
                ("one", "two"),
                ("one", "three"),
                ("two", "end"),
                ("three", "end"),
                ("two", "end")
            ]
        ),
        [""; 0],
        "paths may meet again, and what is said twice is no contradiction"
    );
}

#[test]
fn check_reports_every_error() {
    let mut model = crossing_model();
    model
        .keeper("robot")
        .array("no", &[("x", "y")])
        .follow("maybe", "perhaps");
    assert_eq!(errors(&model).len(), 5);
}

/// Twelve choices between two flags each are 8190 positions.
#[test]
fn paths_that_multiply_are_refused() {
    let mut model = ProtocolModel::new("wide", "a", "b");
    let name = |step: usize, way: &str| format!("{way}{step}");
    for step in 0..12 {
        for way in ["left", "right"] {
            let array = name(step, way);
            model.array(array.clone(), &[(array.as_str(), "a")]);
            if step == 0 {
                model.start(array);
            } else {
                model.follow(name(step - 1, "left"), array.clone());
                model.follow(name(step - 1, "right"), array);
            }
        }
    }
    let expected = format!(
        "protocol `wide` has more than {} positions, counted along every path",
        Protocol::LIMIT
    );
    assert_eq!(errors(&model), [expected]);
}

proptest! {
    /// The flat arrays agree with each other, wherever one looks from.
    #[test]
    fn positions_paths_and_flags_agree(protocol in any_protocol()) {
        for position in protocol.positions() {
            let (path, progress) = (protocol.path(position), protocol.progress(position));
            prop_assert_eq!(protocol.position(path, progress), Some(position));
            let set: Vec<_> = protocol.set_flags(position).collect();
            prop_assert_eq!(set.len(), usize::from(progress));
            prop_assert_eq!(set.last().map_or(Position::START, |&(_, to)| to), position);
            for (flag, to) in protocol.next(position) {
                prop_assert_eq!(protocol.owner(flag), protocol.turn(position));
                prop_assert_eq!(protocol.after(position, flag), Some(to));
                prop_assert_eq!(protocol.before(to), Some((flag, position)));
                prop_assert!(set.iter().all(|&(other, _)| other != flag));
            }
            prop_assert_eq!(protocol.is_end(position), protocol.next(position).count() == 0);
        }
        let ends = protocol.positions().filter(|&position| protocol.is_end(position));
        prop_assert_eq!(ends.count(), protocol.paths());
    }
}

#[test]
fn many_unknown_arrays_are_told_with_some_that_are_known() {
    let mut model = ProtocolModel::new("p", "a", "b");
    for number in 0..4_000 {
        let name = format!("array {number}");
        model.array(&name, &[(&format!("flag {number}"), "a")]);
        model.follow(&name, "nowhere");
    }
    let errors = model.check();
    assert_eq!(errors.len(), 4_000);
    for error in errors {
        let Problem::UnknownArray { known, .. } = *error.problem else {
            panic!("{error}");
        };
        assert!(known.ends_with("array 11 and 3988 more"), "{known}");
    }
}
