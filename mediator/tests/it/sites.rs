//! The shipped sites and nets, with coordinations for tests.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use config::{SiteConfig, load_net, parse_site};
use coordination::analysis::Limits;
use description::site::FsmTransition;
use mediator::nets::{Plan, plans};
use mediator::setup::Setup;

const OVERTAKING: &str = r#"
[robots.slow]
role = "normal"
start = { x_m = 3.0, y_m = -0.5, theta_rad = 0.0 }
[robots.third]
role = "normal"
start = { x_m = 6.5, y_m = -0.5, theta_rad = 0.0 }
start_state = "search-2"
[robots.fast]
role = "emergency"
start = { x_m = 6.5, y_m = 0.5, theta_rad = 3.141592653589793 }
start_state = "drive-4"

[roles.emergency]
priority = 1

[coordinations.overtaking]
net = "overtaking"
alarm_after_s = 4.0

[coordinations.overtaking.situations.normal-ahead]
emergency = { role = "emergency", asks = ["1"], holds = ["7"] }
normal = { role = "normal", stands_in = ["1"], holds = ["1"], without = ["2"] }

[coordinations.overtaking.situations.normal-aside]
emergency = { role = "emergency", asks = ["1"], holds = ["7"] }
normal = { role = "normal", stands_in = ["5"], holds = ["5"], without = ["1", "4"] }

[coordinations.overtaking.flags.emergency]
e1 = { event = "go-1" }
done1 = { on_output = "in-1" }
e2 = { event = "go-2" }
done2 = { on_output = "in-2" }
release = { event = "resume" }

[coordinations.overtaking.flags.normal]
e5 = { event = "aside" }
done5 = { on_output = "parked" }
e1 = { event = "back" }
done1 = { on_output = "back-in-1" }
release = { event = "resume" }

[coordinations.overtaking.preempt]
after_s = 6.0
situation = "normal-aside"
yields.emergency = { event = "halt", states = ["halt-1"] }
yields.normal = { event = "halt", states = ["halt-1"] }
"#;

/// The shipped corridor, with machines that know the events of the coordination.
pub fn corridor() -> (Setup, Vec<Arc<Plan>>) {
    let text = read("sites/corridor.toml");
    let from = text.find("\n[fsm.normal]").expect("it has a machine");
    let to = text.find("\n[robots.").expect("it has robots");
    let machine = text[from..to].replace("[fsm.normal", "[fsm.emergency");
    let text = text[..to].replace("managed = false", "managed = true") + &machine + OVERTAKING;
    let mut site = parse_site("corridor", &text, &[])
        .unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error)));
    for fsm in site.fsm.values_mut() {
        for (on, output) in [
            ("go-1", "in-1"),
            ("go-2", "in-2"),
            ("aside", "parked"),
            ("back", "back-in-1"),
            ("halt", ""),
            ("resume", ""),
        ] {
            fsm.transitions.push(FsmTransition {
                from: fsm.initial.clone(),
                on: on.into(),
                to: fsm.initial.clone(),
                outputs: vec![output.into()],
            });
        }
    }
    // As the modelled robots call them.
    let preempt = { site.coordinations.get_mut("overtaking") }.and_then(|own| own.preempt.as_mut());
    for yields in preempt.expect("written above").yields.values_mut() {
        yields.states = vec!["halted".into(), "parked".into()];
    }
    planned(&site, "overtaking")
}

/// A site as it ships, with its coordinations.
pub fn shipped(name: &str, net: &str) -> (Setup, Vec<Arc<Plan>>) {
    let site = parse_site(name, &read(&format!("sites/{name}.toml")), &[])
        .unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error)));
    planned(&site, net)
}

const DOCKING_SECTION: &str = r#"
[coordinations.docking]
net = "docking"

[coordinations.docking.situations.all-outside]
small-1 = { robot = "amr-1" }
small-2 = { robot = "amr-2" }
big = { robot = "amr-big" }
"#;

pub fn docking() -> (Setup, Vec<Arc<Plan>>) {
    let text = read("sites/docking.toml").replace("managed = false", "managed = true");
    let text = match text.find("\n[coordinations.") {
        Some(end) => text[..end].to_owned(),
        None => text,
    };
    let site = parse_site("docking", &(text + DOCKING_SECTION), &[])
        .unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error)));
    planned(&site, "docking")
}

fn config_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../config")
}

fn read(file: &str) -> String {
    std::fs::read_to_string(config_folder().join(file)).expect("it ships")
}

fn planned(site: &SiteConfig, net: &str) -> (Setup, Vec<Arc<Plan>>) {
    let net = load_net(config_folder().join(format!("nets/{net}.toml")))
        .unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error)));
    let setup = Setup::of(site).expect("the site makes sense");
    let plans = plans(site, &setup, &[net], &Limits::default())
        .unwrap_or_else(|errors| panic!("{errors:#?}"));
    (setup, plans)
}
