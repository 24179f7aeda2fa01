//! Nets with more states than are looked at one by one.

use std::fmt::Write;

use config::{NetConfig, parse_net};
use coordination::analysis::{Limits, Reason};

use crate::sites::net;

/// A road for one robot at a time, with this many robots, whose way out may be forgotten.
fn gate(robots: usize, forgets: Option<usize>) -> NetConfig {
    let (mut roles, mut places, mut sources) = (String::new(), String::new(), String::new());
    let (mut sinks, mut transitions) = (String::new(), String::new());
    for own in 0..robots {
        let back = if forgets == Some(own) { "" } else { "\"free\"" };
        writeln!(roles, "[roles.r{own}]\nprotocol = \"pass\"").unwrap();
        writeln!(places, "in-{own} = \"robot {own} is on the road\"").unwrap();
        writeln!(sources, "asks-{own} = \"r{own}.request\"").unwrap();
        writeln!(sources, "left-{own} = \"r{own}.released\"").unwrap();
        writeln!(sinks, "may-{own} = \"r{own}.granted\"").unwrap();
        writeln!(
            transitions,
            "enter-{own} = {{ from = [\"asks-{own}\", \"free\"], to = [\"in-{own}\", \"may-{own}\"] }}\n\
             leave-{own} = {{ from = [\"left-{own}\", \"in-{own}\"], to = [{back}] }}"
        )
        .unwrap();
    }
    let text = format!(
        "name = \"gate\"\n{roles}\n\
         [protocols.pass]\nkeeper = \"mediator\"\n\
         flags = [{{ robot = \"request\" }}, {{ mediator = \"granted\", enters = [\"road\"] }}, {{ robot = \"released\" }}]\n\
         [places]\nfree = \"nobody is on the road\"\n{places}\n\
         [sources]\n{sources}\n[sinks]\n{sinks}\n[transitions]\n{transitions}\n\
         [ends]\nidle = [\"free\"]\n\
         [situations.all-outside]\nabout = \"nobody\"\nmarked = [\"free\"]\n"
    );
    parse_net("gate.toml", &text).unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error)))
}

#[test]
fn a_net_beyond_two_hundred_thousand_states_may_run() {
    let proofs = gate(20, None).analyse(&Limits::default());
    let proofs = proofs.unwrap_or_else(|refusal| panic!("{refusal}"));
    assert_eq!(proofs.len(), 1);
    let report = proofs[0].report();
    // Outside or asked, each; and one of them told, inside or on its way out, or none.
    assert!(report.states > 1 << 20, "{report:?}");
    assert_eq!(report.ends, ["idle"]);

    let listed = Limits {
        nodes: 0,
        ..Limits::default()
    };
    let refusal = gate(20, None).analyse(&listed).unwrap_err();
    assert!(
        matches!(*refusal.reason, Reason::TooLarge { .. }),
        "{refusal}"
    );
}

#[test]
fn a_faulty_net_of_that_size_is_refused_with_the_way_there() {
    let refusal = gate(20, Some(7)).analyse(&Limits::default()).unwrap_err();
    assert!(
        matches!(*refusal.reason, Reason::Deadlock { .. }),
        "{refusal}"
    );
    let steps = refusal.trace.as_ref().expect("a way there").to_string();
    assert!(steps.contains("leave-7"), "{refusal}");
}

#[test]
fn each_shipped_net_is_judged_alike() {
    let limits = Limits {
        states: 0,
        ..Limits::default()
    };
    for name in ["docking", "overtaking", "t-junction"] {
        let net = net(name);
        let (one, all) = (net.analyse(&Limits::default()), net.analyse(&limits));
        let (one, all) = (one.unwrap(), all.unwrap());
        assert_eq!(one.len(), all.len());
        for (one, all) in one.iter().zip(&all) {
            assert_eq!(one.report(), all.report());
        }
    }
}
