//! What is refused when a net is bound.

use crate::binding::NetBinding;
use crate::event::EventTable;
use crate::petri::{Binding, NetModel};
use crate::protocol::channel;

use super::area;
use super::net::{compile, gate_model};

#[test]
fn what_does_not_fit_is_refused_with_its_reason() {
    let refuse = |build: &dyn Fn(&mut NetModel), keeper: &str, names: &[&str]| {
        let mut model = NetModel::new("n");
        build(&mut model);
        let (net, _) = compile(&model);
        let sides = names.iter().map(|&name| (name, channel(&area(keeper)).1));
        let errors = NetBinding::unproved(&net, sides).unwrap_err();
        errors.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let net = |source: &'static str, sink: &'static str| {
        move |model: &mut NetModel| {
            let (protocol, flag) = source.split_once('.').unwrap();
            model.source("in", Binding::flag(protocol, flag));
            let (protocol, flag) = sink.split_once('.').unwrap();
            model.sink("out", Binding::flag(protocol, flag));
            model.transition("t", &["in"], &["out"]);
        }
    };
    assert_eq!(
        refuse(&net("r.request", "x.granted"), "robot", &["r", "s"]),
        ["place `out` is bound to the unknown protocol `x`; known: r, s"]
    );
    assert_eq!(
        refuse(&net("r.query", "r.granted"), "robot", &["r"]),
        [
            "place `in` is bound to the unknown flag `query` of protocol `r`; known: request, granted, released"
        ]
    );
    assert_eq!(
        refuse(&net("r.granted", "r.request"), "robot", &["r"]),
        [
            "source `in` is bound to flag `granted` of protocol `r`, which belongs to `mediator`; expected a flag of `robot`",
            "sink `out` is bound to flag `request` of protocol `r`, which belongs to `robot`; expected a flag of `mediator`"
        ]
    );
    assert_eq!(
        refuse(&net("r.aborted", "r.granted"), "mediator", &["r"]),
        [
            "source `in` is bound to flag `aborted` of protocol `r`, which belongs to `mediator`; expected a flag of `robot`"
        ]
    );
    assert_eq!(
        refuse(&net("r.request", "r.granted"), "mediator", &["r", "r"]),
        ["two protocols are called `r`"]
    );
    let twice = |model: &mut NetModel| {
        net("r.request", "r.granted")(model);
        model.source("again", Binding::flag("r", "request"));
        model.sink("other", Binding::event("e"));
        model.transition("u", &["again"], &["other"]);
    };
    assert_eq!(
        refuse(&twice, "robot", &["r"]),
        [
            "flag `request` of protocol `r` fills several sources, but the other party can give up its run; bind one source"
        ]
    );
    let (compiled, _) = compile(&{
        let mut model = NetModel::new("n");
        twice(&mut model);
        model
    });
    let mediator = channel(&area("mediator")).1;
    assert!(NetBinding::unproved(&compiled, [("r", mediator)]).is_ok());
}

#[test]
fn an_event_must_not_have_the_name_of_a_flag() {
    let mut net = gate_model();
    net.sink("back door", Binding::event("robot.granted"));
    net.transition("sneak", &["inside"], &["back door"]);
    let errors = net.compile(&mut EventTable::new()).unwrap_err();
    let texts: Vec<_> = errors.iter().map(ToString::to_string).collect();
    assert_eq!(
        texts,
        [
            "net `gate`: `granted` and `back door` are bound to a flag and to something else, but both are called `robot.granted`"
        ]
    );
}
