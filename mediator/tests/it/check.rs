//! `mediator check`, as a user runs it.

use std::path::{Path, PathBuf};
use std::process::Command;

fn config_file(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../config")
        .join(file)
}

fn shipped(file: &str) -> String {
    std::fs::read_to_string(config_file(file)).expect("it ships")
}

/// What it prints of a site with the shipped nets, and how it ends.
fn check(site: &str) -> (Option<i32>, String) {
    check_beside(site, &[])
}

/// The same beside these nets, each with its name.
fn check_beside(site: &str, nets: &[(String, String)]) -> (Option<i32>, String) {
    let folder = tempfile::tempdir().expect("a folder");
    for below in ["sites", "nets"] {
        std::fs::create_dir(folder.path().join(below)).expect("a folder in it");
    }
    for net in ["overtaking", "docking", "t-junction"] {
        let file = format!("nets/{net}.toml");
        std::fs::write(folder.path().join(&file), shipped(&file)).expect("written");
    }
    for (name, text) in nets {
        let file = folder.path().join(format!("nets/{name}.toml"));
        std::fs::write(file, text).expect("written");
    }
    let path: PathBuf = folder.path().join("sites/site.toml");
    std::fs::write(&path, site).expect("written");
    let output = Command::new(env!("CARGO_BIN_EXE_mediator"))
        .args(["check", "--site"])
        .arg(&path)
        .output()
        .expect("it runs");
    let text = [output.stdout, output.stderr].concat();
    (
        output.status.code(),
        String::from_utf8_lossy(&text).into_owned(),
    )
}

#[test]
fn a_floor_on_which_nobody_waits_for_ever_is_told_with_what_was_taken_for_granted() {
    let (code, text) = check(&shipped("sites/overtaking.toml"));
    assert_eq!(code, Some(0), "{text}");
    for part in [
        "whole floor: no robot ever waits for ever: ",
        "whatever stops a robot is taken to send it on at last",
        "these may wait for it: amr-1",
        "coordination overtaking can stand still until its robots are told to get out of the way or are let go",
        "`overtaking` begins with amr-2, amr-1: normal-ahead",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn a_deadlock_is_told_step_by_step_and_is_a_failure() {
    let worse = shipped("sites/t-junction.toml").replace(
        "lane = \"1-out\", skill",
        "also = [\"R1o\"], lane = \"1-out\", skill",
    );
    let (floor, _) = worse.split_once("[coordinations.").expect("its last part");
    let (code, text) = check(floor);
    assert!(code.is_some_and(|code| code > 0), "{code:?}: {text}");
    for part in [
        "whole floor: deadlock: these robots can come to wait for ever:",
        "waits for",
        "after these steps:",
        "   1. ",
        "robots of this site can come to wait for ever",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// One in the lay-by waits for the lane, one on the lane for the lay-by: the coordination that sent both is told with them.
#[test]
fn a_deadlock_that_a_coordination_leads_to_is_a_failure_too() {
    let third = "[robots.amr-3]\nrole = \"normal\"\nstart = { x_m = 7.0, y_m = -0.5, theta_rad = 0.0 }\nstart_state = \"search-2\"\n\n[robots.amr-2]";
    let site = shipped("sites/overtaking.toml").replace("[robots.amr-2]", third);
    let (code, text) = check(&site);
    assert!(code.is_some_and(|code| code > 0), "{code:?}: {text}");
    for part in [
        "whole floor: deadlock",
        "hears what `overtaking` tells it",
        " has 5 and waits for 1",
        " has 1, is let into 5 and waits for 5",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// What was looked at is told all the same.
#[test]
fn a_floor_that_is_too_large_is_neither_good_nor_bad() {
    let docking = shipped("sites/docking.toml").replace("capacity = 1", "capacity = 64");
    let (floor, _) = docking
        .split_once("[coordinations.")
        .expect("its last part");
    let crowd = (10..50).map(|robot| {
        format!(
            "[robots.amr-{robot}]\nrole = \"small\"\nstart = {{ x_m = 1.5, y_m = -0.5, theta_rad = 0.0 }}\nstart_state = \"to-gate\"\n"
        )
    });
    let (code, text) = check(&format!("{floor}{}", crowd.collect::<String>()));
    assert_eq!(code, Some(3), "{text}");
    for part in [
        "whole floor: not decided: more than ",
        "who waits for a robot that fails is told as far as the order of areas says",
        "whether robots of this site can come to wait for ever is not decided",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// A gate before an area, for two robots that pass it one after the other.
const GATE: &str = r#"
name = "gate-AREA"

[roles.one]
protocol = "crossing"
[roles.two]
protocol = "crossing"

[protocols.crossing]
keeper = "mediator"
flags = [
    { robot = "request" },
    { mediator = "granted", enters = ["AREA"] },
    { robot = "entered" },
    { robot = "released" },
]

[places]
free = "nobody is in"
one-may-come = "it is kept for one"
one-inside = "one is in"
two-may-come = "it is kept for two"
two-inside = "two is in"

[sources]
one-asks = "one.request"
one-enters = "one.entered"
one-leaves = "one.released"
two-asks = "two.request"
two-enters = "two.entered"
two-leaves = "two.released"

[sinks]
one-go = "one.granted"
two-go = "two.granted"

[transitions]
let-one-in = { from = ["one-asks", "free"], to = ["one-may-come", "one-go"] }
one-in = { from = ["one-enters", "one-may-come"], to = ["one-inside"] }
one-out = { from = ["one-leaves", "one-inside"], to = ["free"] }
let-two-in = { from = ["two-asks", "free"], to = ["two-may-come", "two-go"] }
two-in = { from = ["two-enters", "two-may-come"], to = ["two-inside"] }
two-out = { from = ["two-leaves", "two-inside"], to = ["free"] }

[ends]
idle = ["free"]

[situations.nobody]
marked = ["free"]
"#;

/// Two big robots of the docking site go round in it, and each takes both lanes of the access, each lane behind a gate of its own: one
/// comes from the gate, the other one from the bay, which is the opposite order.
#[test]
fn two_gates_taken_in_opposite_order_are_a_failure_with_the_steps_that_lead_there() {
    let shipped = shipped("sites/docking.toml");
    let (floor, _) = shipped
        .split_once("[coordinations.access]")
        .expect("its last part");
    let (before, rest) = floor.split_once("[robots.amr-2]").expect("a robot");
    let (_, after) = rest.split_once("[robots.amr-big]").expect("the next one");
    let mut site = format!("{before}[robots.amr-big]{after}").replace(
        "[robots.amr-1]\nrole = \"small\"",
        "[robots.amr-1]\nrole = \"big\"",
    );
    let areas = ["access-in", "access-out"];
    for area in areas {
        site += &format!(
            "[coordinations.{area}]\nnet = \"gate-{area}\"\n[coordinations.{area}.situations.nobody]\n\
             one = {{ robot = \"amr-1\" }}\ntwo = {{ robot = \"amr-big\" }}\n"
        );
    }
    let nets = areas.map(|area| (format!("gate-{area}"), GATE.replace("AREA", area)));
    let (code, text) = check_beside(&site, &nets);
    assert!(code.is_some_and(|code| code > 0), "{code:?}: {text}");
    for part in [
        "whole floor: deadlock: these robots can come to wait for ever:",
        "amr-1",
        "amr-big",
        "after these steps:",
        "`access-in`: let-one-in",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// Other tools read it, and so do we, as the same net.
#[test]
fn a_net_is_shown_for_the_tools_of_others() {
    let show = |site: &str, net: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_mediator"))
            .args(["show", "--pnml", "--net", net, "--site"])
            .arg(config_file(&format!("sites/{site}")))
            .output()
            .expect("it runs");
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{error}");
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    for name in ["overtaking", "docking", "t-junction"] {
        let found = coordination::pnml::read(&show(&format!("{name}.toml"), name));
        let found = found.unwrap_or_else(|error| panic!("{name}: {error}"));
        let net =
            config::load_net(config_file(&format!("nets/{name}.toml"))).expect("a shipped net");
        let first = net.model(&net.situations[0].id).expect("its first one");
        assert!(found.places().eq(first.places()), "{name}");
        assert!(found.transitions().eq(first.transitions()), "{name}");
    }
}
