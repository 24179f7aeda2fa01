//! An operator gives the robot's machine events with parameters, and new limits while it drives.

use std::collections::BTreeMap;
use std::fs;
use std::process::Output;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use onboard::process::inspect;
use onboard::process::runtime::Runtime;
use serde_json::Value as Json;
use sim::rt::monotonic_ns;

use crate::programs::bench::{Bench, ROBOT, onboard, said};
use crate::programs::late::once_more_if_late;

/// Numbers of the life cycle's states.
const RUNNING: u64 = 3;
const PAUSED: u64 = 4;
const RECONFIGURING: u64 = 5;

/// A site whose machine can be told to slow down, and to stop at a place.
fn with_orders(bench: &Bench) {
    let site = fs::read_to_string(bench.site_file()).expect("readable");
    let edit = |site: String, from: &str, to: &str| {
        assert_eq!(site.matches(from).count(), 1, "{from}");
        site.replace(from, to)
    };
    let site = edit(
        site,
        "external = [\"reset\"]",
        "external = [\"reset\", \"slow\", \"stop-here\", \"on\"]",
    );
    let site = edit(
        site,
        "transitions = [\n",
        "transitions = [\n    { from = \"drive-1\", on = \"slow\", to = \"slow-1\" },
    { from = \"slow-1\", on = \"in-2\", to = \"search-2\" },
    { from = \"slow-1\", on = \"stop-here\", to = \"stop-1\" },
    { from = \"stop-1\", on = \"on\", to = \"drive-1\" },\n",
    );
    let site = edit(
        site,
        "[fsm.normal.states]\n",
        "[fsm.normal.states]\nslow-1 = { area = \"1\", skill = \"follow-lane\" }
stop-1 = { area = \"1\", skill = \"stop-there\" }\n",
    );
    let site = edit(
        site,
        "[skills.stop]\n",
        "[skills.stop-there]\ncontroller = \"stop-at\"\nperception = \"A\"\nmonitors = []\n\n[skills.stop]\n",
    );
    fs::write(bench.site_file(), site).expect("written");
}

fn send(bench: &Bench, arguments: &[&str]) -> Output {
    let runtime = bench.runtime_folder();
    let runtime = runtime.to_str().expect("a plain path");
    let mut all = vec!["ctl", "send"];
    all.extend(arguments);
    all.extend(["--robot", ROBOT, "--runtime", runtime]);
    onboard(&all)
}

/// The event is refused with exit code 1, and the reason has these parts.
fn refused(bench: &Bench, arguments: &[&str], parts: &[&str]) {
    let output = send(bench, arguments);
    let text = said(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    for part in parts {
        assert!(text.contains(part), "{part:?} is not in {text}");
    }
}

/// The event is taken, and the answer has these parts.
fn taken(bench: &Bench, arguments: &[&str], parts: &[&str]) {
    let output = send(bench, arguments);
    let text = said(&output);
    assert!(output.status.success(), "{text}");
    for part in parts {
        assert!(text.contains(part), "{part:?} is not in {text}");
    }
}

fn navigation(bench: &Bench) -> Json {
    let runtime = Runtime::new(Some(bench.runtime_folder())).expect("the runtime folder");
    let seen = inspect::snapshot(&runtime, ROBOT).expect("it runs");
    let symbols = seen["symbols"].as_array().expect("a list");
    let found = symbols
        .iter()
        .find(|symbol| symbol["datatype"] == "navigation_state");
    found.expect("there is one")["value"].clone()
}

#[test]
fn events_reach_the_machine_with_their_parameters() {
    once_more_if_late(|| {
        let mut bench = Bench::new();
        with_orders(&bench);
        bench.start();
        bench.until_driving();
        refused(
            &bench,
            &["dance"],
            &["dance", "`reset`, `slow`, `stop-here`, `on`"],
        );
        refused(
            &bench,
            &["on"],
            &["state `drive-1` has no use for `on`", "it takes `slow`"],
        );
        // A mistake in an argument is one of the command line.
        assert_eq!(
            send(&bench, &["slow", "--speed-limit", "-1"]).status.code(),
            Some(2)
        );
        assert_eq!(
            send(&bench, &["stop-here", "--stop", "1,2"]).status.code(),
            Some(2)
        );

        taken(
            &bench,
            &["slow", "--speed-limit", "0.15"],
            &["`slow`: state drive-1 -> slow-1"],
        );
        std::thread::sleep(Duration::from_secs(1));
        let from_ns = monotonic_ns();
        std::thread::sleep(Duration::from_secs(1));
        for truth in bench.since(from_ns) {
            // How much slower is judged on the simulated clock.
            assert!(truth.twist.v_m_s < 0.3, "{truth:?}");
        }

        let wanted = bench.ahead(0.6, 0.0);
        let stop = format!("{},{},{}", wanted.x_m, wanted.y_m, 0.0);
        taken(
            &bench,
            &["stop-here", "--stop", &stop],
            &["slow-1 -> stop-1"],
        );
        bench.until_standing(Duration::from_secs(10));
        let stood = bench.truth().pose;
        let off_m = (stood.x_m - wanted.x_m).hypot(stood.y_m - wanted.y_m);
        assert!(
            // How well it stops at a pose is judged on the simulated clock.
            off_m < 0.3,
            "{off_m:.3} m off: {stood:?}, wanted {wanted:?}"
        );
        assert_eq!(navigation(&bench)["state"], "stop-1");

        taken(&bench, &["on"], &["stop-1 -> drive-1"]);
        bench.until_driving();
        // A pose behind the robot cannot be reached: taken, and said.
        taken(&bench, &["slow"], &["slow-1"]);
        taken(
            &bench,
            &["stop-here", "--stop", &stop],
            &["-> stop-1", "stop pose cannot be reached"],
        );
        bench.until_standing(Duration::from_secs(5));
        assert_eq!(navigation(&bench)["hold"], "stop pose cannot be reached");
        taken(&bench, &["on"], &["drive-1"]);
        bench.until_driving();
        bench.finish();
    });
}

/// What states of its life cycle each activity was seen in, in their order.
fn watch(runtime: &Runtime, until: &AtomicBool) -> BTreeMap<String, Vec<u64>> {
    let mut seen: BTreeMap<String, Vec<u64>> = BTreeMap::new();
    while !until.load(Ordering::Relaxed) {
        if let Ok(snapshot) = inspect::snapshot(runtime, ROBOT) {
            for symbol in snapshot["symbols"].as_array().into_iter().flatten() {
                if symbol["datatype"] != "activity_state" {
                    continue;
                }
                let name = symbol["model"].as_str().unwrap_or_default().to_owned();
                let states = seen.entry(name).or_default();
                if let Some(state) = symbol["value"]["state"].as_u64()
                    && states.last() != Some(&state)
                {
                    states.push(state);
                }
            }
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    seen
}

/// Has somebody end when it is dropped.
struct Ends<'a>(&'a AtomicBool);

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

#[test]
fn a_reload_goes_through_pause_and_reconfigure_and_takes_limits() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        let robot = fs::read_to_string(bench.robot_file()).expect("readable");
        let slower = robot.replace("max_speed_m_s = 0.40", "max_speed_m_s = 0.20");
        assert_ne!(slower, robot);
        bench.until_fast();

        // What the drive itself enforces takes a restart, and is named.
        let harder = slower.replace(
            "stop_deceleration_m_s2 = 2.0",
            "stop_deceleration_m_s2 = 1.8",
        );
        assert_ne!(harder, slower);
        fs::write(bench.robot_file(), harder).expect("written");
        bench.is_refused("reload", "drive.stop_deceleration_m_s2");
        bench.drives_for(Duration::from_millis(500));
        bench.until_fast();

        // A file that is no robot at all: nothing pauses.
        fs::write(bench.robot_file(), slower.replace("[control]", "[contrl]")).expect("written");
        bench.is_refused("reload", "contrl");
        bench.drives_for(Duration::from_millis(500));

        fs::write(bench.robot_file(), slower).expect("written");
        let runtime = Runtime::new(Some(bench.runtime_folder())).expect("the runtime folder");
        let over = AtomicBool::new(false);
        let seen = std::thread::scope(|scope| {
            let watcher = scope.spawn(|| watch(&runtime, &over));
            // Also where what follows panics: the scope waits for the watcher.
            let ends = Ends(&over);
            bench.ask("reload");
            bench.until_driving();
            drop(ends);
            watcher.join().expect("it watches")
        });
        for activity in ["navigation", "motion-tube", "control"] {
            let states = &seen[activity];
            let at = |state: u64| {
                let found = states.iter().position(|&seen| seen == state);
                found.unwrap_or_else(|| panic!("{activity} was never in state {state}: {states:?}"))
            };
            assert!(at(PAUSED) < at(RECONFIGURING), "{activity}: {states:?}");
            assert_eq!(states.last(), Some(&RUNNING), "{activity}: {states:?}");
        }
        for other in ["drive", "lidar", "proprioception", "communication"] {
            assert_eq!(seen[other], [RUNNING], "{other}");
        }
        let fastest = bench.fastest_m_s(Duration::from_secs(1));
        assert!(fastest < 0.3, "{fastest:.3} m/s, expected about 0.20 m/s");
        bench.finish();
    });
}
