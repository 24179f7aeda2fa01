//! The shipped sites and nets, with coordinations for tests.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use config::{NetConfig, SiteConfig, load_net, parse_net, parse_site};
use coordination::analysis::Limits;
use description::site::FsmTransition;
use mediator::nets::{Plan, plans};
use mediator::setup::Setup;

use crate::program::Site;
use crate::program::site::OVERTAKING;
use crate::program::site::{idle_coordination, idle_net, shipped_net};

const ROBOTS: &str = r#"
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
"#;

const GIVING_WAY: &str = r#"
[coordinations.overtaking.situations.normal-aside]
emergency = { role = "emergency", asks = ["1"], holds = ["7"] }
normal = { role = "normal", stands_in = ["5"], holds = ["5"], without = ["1", "4"] }

[coordinations.overtaking.preempt]
after_s = 6.0
situation = "normal-aside"
yields.emergency = { event = "halt", states = ["halt-1"] }
yields.normal = { event = "halt", states = ["halt-1"] }
"#;

/// The crossing of the T junction by its net.
pub const JUNCTION: &str = r#"
[coordinations.crossing]
net = "t-junction"
situations.all-outside = { west = { robot = "amr-1" }, south = { robot = "amr-2" }, east = { robot = "amr-3" } }
"#;

/// The shipped corridor, with machines that know the events of the coordination.
pub fn corridor() -> (Setup, Vec<Arc<Plan>>) {
    let text = read("sites/corridor.toml");
    let from = text.find("\n[fsm.normal]").expect("it has a machine");
    let to = text.find("\n[robots.").expect("it has robots");
    let machine = text[from..to].replace("[fsm.normal", "[fsm.emergency");
    let text = text[..to].replace("managed = false", "managed = true") + &machine;
    let mut site = site("corridor", &(text + ROBOTS + OVERTAKING + GIVING_WAY));
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
    let overtaking = site.coordinations.get_mut("overtaking");
    let overtaking = overtaking.expect("written above");
    for yields in { overtaking.preempt.iter_mut() }.flat_map(|own| own.yields.values_mut()) {
        yields.states = vec!["halted".into(), "parked".into()];
    }
    let mut aside =
        { overtaking.situations.iter_mut() }.filter(|own| own.situation == "normal-aside");
    let normal = aside.next().and_then(|own| own.roles.get_mut("normal"));
    // One that is on its way out of the lay-by would be passed by nobody.
    normal.expect("written above").states = vec!["parked".into()];
    planned(&site, "overtaking")
}

/// A site as it ships, with its coordinations.
pub fn shipped(name: &str, net: &str) -> (Setup, Vec<Arc<Plan>>) {
    planned(&site(name, &read(&format!("sites/{name}.toml"))), net)
}

const DOCKING_SECTION: &str = r#"
[coordinations.docking]
net = "docking"

[coordinations.docking.situations.all-outside]
small-1 = { robot = "amr-1" }
small-2 = { robot = "amr-2" }
big = { robot = "amr-big" }
"#;

/// Rooms with a robot in each, and a crossing whose net has three roles, which any robot may play.
pub fn crossing(rooms: usize) -> (Setup, Vec<Arc<Plan>>) {
    let mut areas: Vec<(String, u32)> =
        (0..rooms).map(|room| (format!("room-{room}"), 1)).collect();
    areas.push(("Cr".to_owned(), 1));
    let own = Site {
        name: "rooms".into(),
        areas,
        robots: (0..rooms).map(|robot| (format!("amr-{robot}"), "normal", robot)).collect(),
        events: Vec::new(),
        more: "[coordinations.crossing]\nnet = \"t-junction\"\nsituations.all-outside = { \
               west = { role = \"normal\" }, east = { role = \"normal\" }, south = { role = \"normal\" } }\n"
            .into(),
        nets: vec!["t-junction"],
        own_nets: Vec::new(),
    };
    planned(&site("rooms", &own.text()), "t-junction")
}

/// A hall for any number of robots, and this many crossings, each with a net whose roles any of them may play.
pub fn crossings(robots: usize, crossings: usize) -> (Setup, Vec<Arc<Plan>>) {
    let nets: Vec<(String, String)> = (0..crossings)
        .map(|crossing| {
            let text = shipped_net("t-junction")
                .replace("[\"Cr\"]", &format!("[\"Cr-{crossing}\"]"))
                .replace("\"t-junction\"", &format!("\"crossing-{crossing}\""));
            (format!("crossing-{crossing}"), text)
        })
        .collect();
    let role = "{ role = \"normal\" }";
    let coordination = |(net, _): &(String, String)| {
        format!(
            "[coordinations.{net}]\nnet = \"{net}\"\nsituations.all-outside = {{ west = {role}, east = {role}, south = {role} }}\n"
        )
    };
    let areas = (0..crossings).map(|crossing| (format!("Cr-{crossing}"), 1));
    let coordinations = nets.iter().map(coordination).collect();
    in_a_hall(robots, areas, coordinations, nets)
}

/// A hall for any number of robots, with this many nets that would take one of them in, and whose situation never comes.
pub fn idle(robots: usize, nets: usize) -> (Setup, Vec<Arc<Plan>>) {
    let all = (0..nets).map(|net| idle_net(&format!("idle-{net}")));
    let coordinations =
        (0..nets).map(|net| idle_coordination(&format!("idle-{net}"), "hall", "gate"));
    let gate = ("gate".to_owned(), 1);
    in_a_hall(robots, [gate], coordinations.collect(), all.collect())
}

/// Robots in a hall that holds all of them, other areas, and nets of the site's own.
fn in_a_hall(
    robots: usize,
    others: impl IntoIterator<Item = (String, u32)>,
    coordinations: String,
    own_nets: Vec<(String, String)>,
) -> (Setup, Vec<Arc<Plan>>) {
    let capacity = u32::try_from(robots).expect("a small number");
    let mut areas = vec![("hall".to_owned(), capacity)];
    areas.extend(others);
    let own = Site {
        name: "rooms".into(),
        areas,
        robots: (0..robots)
            .map(|robot| (format!("amr-{robot:04}"), "normal", 0))
            .collect(),
        events: Vec::new(),
        more: coordinations,
        nets: Vec::new(),
        own_nets,
    };
    let site = site("rooms", &own.text());
    let setup = Setup::of(&site).expect("the site makes sense");
    let nets: Vec<NetConfig> = { own.own_nets.iter() }
        .map(|(name, text)| parse_net(name, text).expect("it makes sense"))
        .collect();
    let plans = plans(&site, &setup, &nets, &Limits::default())
        .unwrap_or_else(|errors| panic!("{errors:#?}"));
    (setup, plans)
}

/// The docking bay, where the net alone decides.
pub fn docking() -> (Setup, Vec<Arc<Plan>>) {
    let text = uncoordinated("docking") + DOCKING_SECTION;
    planned(&site("docking", &text), "docking")
}

/// A shipped site with managed areas, without coordinations of its own.
pub fn uncoordinated(name: &str) -> String {
    let mut text = read(&format!("sites/{name}.toml")).replace("managed = false", "managed = true");
    text.truncate(text.find("\n[coordinations.").unwrap_or(text.len()));
    text
}

/// A site file with this text.
pub fn site(name: &str, text: &str) -> SiteConfig {
    parse_site(name, text, &[]).unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error)))
}

/// A shipped net.
pub fn net(name: &str) -> NetConfig {
    load_net(config_folder().join(format!("nets/{name}.toml")))
        .unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error)))
}

fn config_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../config")
}

fn read(file: &str) -> String {
    std::fs::read_to_string(config_folder().join(file)).expect("it ships")
}

fn planned(site: &SiteConfig, name: &str) -> (Setup, Vec<Arc<Plan>>) {
    let setup = Setup::of(site).expect("the site makes sense");
    let plans = plans(site, &setup, &[net(name)], &Limits::default())
        .unwrap_or_else(|errors| panic!("{errors:#?}"));
    (setup, plans)
}
