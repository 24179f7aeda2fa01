//! Coordinations of site files against the shipped nets: what fits, and what is said when it does not.

use std::sync::Arc;

use config::NetConfig;
use coordination::analysis::Limits;
use mediator::nets::{Plan, plans};
use mediator::setup::Setup;

use crate::sites::{self, JUNCTION, net, uncoordinated};

const OVERTAKING: &str = r#"
[robots.amr-9]
role = "normal"
start = { x_m = 6.5, y_m = -0.5, theta_rad = 0.0 }
start_state = "search-2"

[coordinations.overtaking]
net = "overtaking"

[coordinations.overtaking.situations.normal-ahead]
emergency = { robot = "amr-1", asks = ["1"] }
normal = { robot = "amr-9", holds = ["1"] }

[coordinations.overtaking.flags.normal]
e5 = { event = "reset" }
done5 = { on_output = "lap" }

[coordinations.overtaking.preempt]
after_s = 60.0
situation = "normal-ahead"
yields.normal = { event = "reset", states = ["halt-1"] }
yields.emergency = { event = "reset", states = ["halt-1"] }
"#;

fn nets() -> Vec<NetConfig> {
    ["overtaking", "t-junction", "docking"].map(net).into()
}

fn planned(site: &str, nets: &[NetConfig], limits: &Limits) -> Result<Vec<Arc<Plan>>, String> {
    let site = sites::site("site.toml", site);
    let setup = Setup::of(&site).expect("the site makes sense");
    plans(&site, &setup, nets, limits).map_err(|errors| {
        let lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
        lines.join("\n")
    })
}

#[test]
fn the_shipped_nets_fit_their_sites() {
    for (name, section) in [("t-junction", JUNCTION), ("corridor", OVERTAKING)] {
        let plans = planned(
            &(uncoordinated(name) + section),
            &nets(),
            &Limits::default(),
        );
        let plans = plans.unwrap_or_else(|errors| panic!("{errors}"));
        assert_eq!(plans.len(), 1);
    }
}

#[test]
fn what_does_not_fit_is_said() {
    for (name, section, right, wrong, said) in [
        (
            "t-junction",
            JUNCTION,
            "\"t-junction\"",
            "\"junction\"",
            "there is no net `junction`",
        ),
        (
            "t-junction",
            JUNCTION,
            "all-outside",
            "nobody",
            "no such situation; it has all-outside",
        ),
        (
            "t-junction",
            JUNCTION,
            "west = {",
            "north = {",
            "no role `north`",
        ),
        (
            "t-junction",
            JUNCTION,
            "west = { robot = \"amr-1\" }, ",
            "",
            "who plays the role `west`",
        ),
        (
            "t-junction",
            JUNCTION,
            "\"amr-1\" }",
            "\"amr-1\", asks = [\"Cr\"] }",
            "only `robot` and `role` say who plays it",
        ),
        (
            "t-junction",
            JUNCTION,
            "robot = \"amr-1\"",
            "robot = \"amr-1\", role = \"east-west\"",
            "no robot",
        ),
        (
            "t-junction",
            JUNCTION,
            "\"t-junction\"",
            "\"docking\"",
            "the site has no area `access-in`",
        ),
        (
            "corridor",
            OVERTAKING,
            "flags.normal",
            "flags.slow",
            "no role `slow`",
        ),
        ("corridor", OVERTAKING, "e5 =", "e7 =", "no flag `e7`"),
        (
            "corridor",
            OVERTAKING,
            "e5 = { event",
            "e5 = { on_output",
            "it has an `event`",
        ),
        (
            "corridor",
            OVERTAKING,
            "done5 = { on_output",
            "done5 = { event",
            "it has an `on_output`",
        ),
        (
            "corridor",
            OVERTAKING,
            "event = \"reset\" }",
            "event = \"aside\" }",
            "is on the event `aside`",
        ),
        (
            "corridor",
            OVERTAKING,
            "\"lap\"",
            "\"parked\"",
            "has the output `parked`",
        ),
        (
            "corridor",
            OVERTAKING,
            ", holds = [\"1\"]",
            "",
            "coordinated anywhere",
        ),
        (
            "corridor",
            OVERTAKING,
            "situation = \"normal-ahead\"",
            "situation = \"safe\"",
            "`safe` is none",
        ),
        (
            "corridor",
            OVERTAKING,
            "yields.normal = { event = \"reset\", states = [\"halt-1\"] }",
            "",
            "how role `normal` gets out of the way",
        ),
    ] {
        assert!(section.contains(right), "{right}");
        let text = uncoordinated(name) + &section.replacen(right, wrong, 1);
        let errors = planned(&text, &nets(), &Limits::default()).expect_err(wrong);
        assert!(errors.contains(said), "{wrong}: {errors}");
    }
}

#[test]
fn two_nets_cannot_decide_on_one_area() {
    let again = JUNCTION.replace("coordinations.crossing", "coordinations.again");
    let text = uncoordinated("t-junction") + JUNCTION + &again;
    let errors = planned(&text, &nets(), &Limits::default()).expect_err("twice");
    assert!(
        errors.contains("area `Cr` is let into by `again` already"),
        "{errors}"
    );
}

#[test]
fn a_net_that_the_analysis_refuses_never_runs() {
    let few = Limits {
        states: 3,
        ..Limits::default()
    };
    let none = Limits { nodes: 0, ..few };
    let site = uncoordinated("t-junction") + JUNCTION;
    let errors = planned(&site, &nets(), &none).expect_err("too large");
    assert!(errors.contains("the net may not run"), "{errors}");
    // It is not too large to be looked at as a set of states.
    planned(&site, &nets(), &few).unwrap_or_else(|errors| panic!("{errors}"));
}
