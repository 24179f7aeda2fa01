//! A stepped campaign that is killed goes on where it was, and comes to the same.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use onboard::process::runtime::Runtime;
use rig::campaign::faults::{Ground, Times, faults};
use rig::campaign::shrink::Again;
use rig::campaign::stepped::{Faults, Setup};
use rig::scenario::{Changes, load};
use rig::stepped::Plans;
use rustix::process::{Pid, Signal};
use serde_json::{Value as Json, json};

/// A campaign of a few runs, one after the other, into this folder.
fn campaign(out: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rig"));
    // So that what it leaves is told from what others leave.
    let scratch = out.with_extension("tmp");
    fs::create_dir_all(&scratch).expect("a folder");
    command
        .env("TMPDIR", scratch)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
        .args(["campaign", "lap", "--stepped", "--runs", "3"])
        .args(["--rounds", "1", "--jobs", "1", "--out"])
        .arg(out);
    command
}

fn said(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    text(&output.stdout) + &text(&output.stderr)
}

/// What a campaign has left, but for the time that it took.
fn left(out: &Path) -> Json {
    let text = fs::read_to_string(out.join("campaign.json")).expect("campaign.json");
    let mut json: Json = serde_json::from_str(&text).expect("JSON");
    let elapsed_s = json["elapsed_s"].take();
    assert!(elapsed_s.as_f64() > Some(0.1), "{elapsed_s}");
    json
}

fn goes_on(process: &mut Child) -> bool {
    process.try_wait().is_ok_and(|ended| ended.is_none())
}

fn signal(process: &Child, signal: Signal) {
    rustix::process::kill_process(Pid::from_child(process), signal).expect("it runs");
}

/// What is in the temporary folder of a campaign.
fn left_over(out: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(out.with_extension("tmp")).expect("a folder");
    entries.flatten().map(|entry| entry.path()).collect()
}

/// What names of shared memory begin with in its runtime folders: one for each run below the campaign's own.
fn prefixes(out: &Path) -> Vec<String> {
    let own = left_over(out);
    let runs = own.iter().flat_map(fs::read_dir).flatten();
    let runtime = |run: fs::DirEntry| Runtime::new(Some(run.path())).expect("a folder");
    runs.flatten()
        .map(|run| runtime(run).place().prefix)
        .collect()
}

/// The shared memory of these.
fn shared_memory(prefixes: &[String]) -> Vec<String> {
    let entries = fs::read_dir("/dev/shm").into_iter().flatten().flatten();
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    let is_theirs = |name: &String| prefixes.iter().any(|prefix| name.starts_with(prefix));
    names.filter(is_theirs).collect()
}

#[test]
fn a_campaign_that_was_killed_goes_on_where_it_was() {
    let folder = tempfile::tempdir().expect("a folder");
    let [killed, whole] = ["killed", "whole"].map(|name| folder.path().join(name));
    let mut first = campaign(&killed)
        .stdout(Stdio::null())
        .spawn()
        .expect("started");
    let runs = killed.join("runs.jsonl");
    let began = Instant::now();
    let made = loop {
        // The first line is the campaign itself.
        let text = fs::read_to_string(&runs).unwrap_or_default();
        let made = text.lines().count().saturating_sub(1);
        if made > 0 {
            break made;
        }
        let waits = began.elapsed() < Duration::from_secs(300);
        assert!(waits && goes_on(&mut first));
        std::thread::sleep(Duration::from_millis(5));
    };
    // Between two runs there is no robot that could leave something.
    let prefixes = loop {
        assert!(goes_on(&mut first), "it ended before it was killed");
        signal(&first, Signal::STOP);
        let prefixes = prefixes(&killed);
        if !shared_memory(&prefixes).is_empty() {
            break prefixes;
        }
        signal(&first, Signal::CONT);
        std::thread::sleep(Duration::from_millis(5));
    };
    first.kill().expect("killed");
    first.wait().expect("ended");
    let began = Instant::now();
    while !(left_over(&killed).is_empty() && shared_memory(&prefixes).is_empty()) {
        let left = (left_over(&killed), shared_memory(&prefixes));
        assert!(began.elapsed() < Duration::from_secs(30), "left: {left:?}");
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(made < 3 && !killed.join("campaign.json").exists());
    // It was writing a line.
    let mut text = fs::read_to_string(&runs).expect("there");
    let made = text.lines().count() - 1;
    text.push_str("{\"elapsed_s\":1.0,\"run\":{\"scen");
    fs::write(&runs, text).expect("written");

    let second = campaign(&killed).output().expect("run");
    let said = said(&second);
    assert!(second.status.success(), "{said}");
    let resumed = format!("resumed: {made} of 3 runs were made before");
    assert!(said.contains(&resumed), "{said}");
    let third = campaign(&whole).output().expect("run");
    assert!(third.status.success(), "{}", self::said(&third));
    assert_eq!(left(&killed), left(&whole));
    assert_eq!(left(&whole)["seeds"], json!([1, 3]));
    assert_eq!(left(&whole)["passed"], 3);
    // Nothing is left to do.
    let fourth = campaign(&killed).output().expect("run");
    assert!(self::said(&fourth).contains("resumed: 3 of 3"));
    assert_eq!(left(&killed), left(&whole));
}

#[test]
fn runs_are_compared_seed_by_seed() {
    for (scenario, shorter) in [("lap", &["--laps", "1"][..]), ("overtaking", &[])] {
        is_compared(scenario, shorter);
    }
}

/// The same of this scenario, with these arguments of its run.
fn is_compared(scenario: &str, shorter: &[&str]) {
    let folder = tempfile::tempdir().expect("a folder");
    let rig = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rig"));
        command
            .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
            .args(arguments);
        command.output().expect("run")
    };
    let (real, one) = (folder.path(), folder.path().join("4"));
    let [real, one_text] = [real, &one].map(|path| path.to_str().expect("text"));
    let agreement = || rig(&["agreement", scenario, "--rounds", "1", "--real", real]);
    let (none, asked) = (agreement(), format!("rig campaign {scenario}"));
    assert!(said(&none).contains(&asked), "{}", said(&none));
    // A stepped run stands for the real one: it agrees with itself, until its summary is changed.
    let run = [scenario, "--stepped", "--seed", "4", "--out", one_text];
    let run = rig(&[&run, shorter].concat());
    assert!(run.status.success(), "{}", said(&run));
    let file = one.join("summary.json");
    let change = |key: &str, value: Json| {
        let text = fs::read_to_string(&file).expect("a summary");
        let mut summary: Json = serde_json::from_str(&text).expect("JSON");
        summary[key] = value;
        fs::write(&file, summary.to_string()).expect("written");
    };
    change("scenario", json!(scenario));
    // What a stepped campaign leaves of a run that failed is not a run of the real programs.
    for other in ["seed-9", "stepped", "4/spoiled"] {
        let other = folder.path().join(other);
        fs::create_dir_all(&other).expect("a folder");
        fs::copy(&file, other.join("summary.json")).expect("copied");
    }
    let agree = agreement();
    assert!(agree.status.success(), "{}", said(&agree));
    assert!(said(&agree).contains("1 of 1 seeds agree"));
    // Unless told otherwise, times must have been compared in all.
    let report = json(&folder.path().join("agreement.json"));
    assert_eq!([&report["timed"], &report["asked"]], [1, 1]);
    change("duration_s", json!(1.0));
    let differ = agreement();
    assert!(!differ.status.success() && said(&differ).contains("duration in seconds: real 1.000"));
}

/// A scenario of a quarter of a minute, in which the second of two faults keeps the robot where it is.
const UNPLUGGED: &str = r#"
name = "unplugged"
about = "a robot without a lidar goes nowhere"
site = "SITES/corridor.toml"
patience_s = 60.0
standstill_s = 8.0
faults = [
    { at_s = 4.0, for_s = 1.0, what = "lose-frames", robot = "amr-1", share = 0.001 },
    { at_s = 6.0, for_s = 600.0, what = "unplug", robot = "amr-1" },
]

[robots.amr-1]
file = "ROBOTS/amr-1.toml"
goal = { rounds = 1, through = [{ region = { min_m = [4.0, -2.0], max_m = [12.0, 2.0] } }] }
"#;

/// The same, in this folder.
fn unplugged(folder: &Path) -> PathBuf {
    let config = |name: &str| format!("{}/../../config/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = UNPLUGGED
        .replace("SITES", &config("sites"))
        .replace("ROBOTS", &config("robots"));
    let file = folder.join("un plugged.toml");
    fs::write(&file, text).expect("written");
    file
}

fn json(file: &Path) -> Json {
    let text = fs::read_to_string(file).unwrap_or_else(|error| panic!("{file:?}: {error}"));
    serde_json::from_str(&text).expect("JSON")
}

/// Runs a command that was printed, with its results in this folder; returns its summary. It fails, is shrunk once more, and prints the
/// same command.
fn again(command: &str, out: &Path) -> Json {
    let words = command.strip_prefix("rig ").expect("the program's name");
    let line = format!(
        "{} {words} --headless --out {}",
        env!("CARGO_BIN_EXE_rig"),
        out.display()
    );
    let output = Command::new("sh").args(["-c", &line]).output();
    let output = output.expect("run");
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(said(&output).contains(command), "{}", said(&output));
    let summary = json(&out.join("summary.json"));
    let shrunk = out.join(format!("seed-{}", summary["seed"]));
    assert!(shrunk.join("report.html").is_file(), "{}", said(&output));
    assert_eq!(json(&shrunk.join("summary.json")), summary);
    summary
}

#[test]
fn faults_of_seeds_change_what_comes_of_a_campaign() {
    let folder = tempfile::tempdir().expect("a folder");
    let [calm, faulty] = [&[][..], &["--faults"]].map(|faults| {
        let out = folder.path().join(format!("out-{}", faults.len()));
        let output = campaign(&out).args(faults).output().expect("run");
        assert!(output.status.success(), "{}", said(&output));
        let campaign = left(&out);
        // How often each run drew faults that its robot told of.
        let raised = campaign["faults"].as_array().map(Vec::len);
        (campaign["faults_of_seeds"].clone(), raised)
    });
    assert_eq!((&calm.0, &faulty.0), (&json!("none"), &json!("drawn")));
    assert!(faulty.1 > calm.1, "{faulty:?}, {calm:?}");
}

#[test]
fn a_run_that_failed_is_made_again_by_the_command_that_is_printed() {
    let folder = tempfile::tempdir().expect("a folder");
    let (scenario, out) = (unplugged(folder.path()), folder.path().join("out"));
    let mut rig = Command::new(env!("CARGO_BIN_EXE_rig"));
    rig.args(["campaign", "--stepped", "--runs", "2", "--rounds", "3"]);
    let output = rig.arg("--out").args([&out, &scenario]).output();
    let output = output.expect("run");
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    let campaign = json(&out.join("campaign.json"));
    assert_eq!(campaign["failures"].as_array().map(Vec::len), Some(2));
    for (number, seed) in [(0, 1), (1, 2)] {
        let failure = &campaign["failures"][number];
        assert_eq!(failure["seed"], seed);
        assert_eq!([&failure["faults"], &failure["of_faults"]], [1, 2]);
        let command = failure["command"].as_str().expect("a command");
        assert!(command.contains("unplug") && !command.contains("lose-frames"));
        assert!(said(&output).contains(command), "{}", said(&output));
        let own = out.join(format!("seed-{seed}"));
        let report = own.join("report.html");
        assert_eq!(failure["report"].as_str(), report.to_str());
        assert!(
            report.is_file() && said(&output).contains(&format!("report: {}", report.display()))
        );
        let again = again(command, &folder.path().join("again"));
        assert_eq!(again, json(&own.join("summary.json")));
        assert_ne!(again["outcome"], "done");
        assert_eq!(again["seed"], seed);
    }
}

#[test]
fn a_bad_run_of_the_campaign_of_faults_is_made_smaller_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = load(&unplugged(folder.path()), &Changes::default());
    let mut scenario = scenario.unwrap_or_else(|failure| panic!("{failure:?}"));
    scenario.faults.clear();
    // The corridor does not allow it, also without any fault.
    scenario.limits.clearance_m = 1.0;
    let plans = Plans::of(&scenario).unwrap_or_else(|failure| panic!("{failure:?}"));
    let setup = Setup {
        seeds: 1..2,
        faults: Faults::None,
        mediator: true,
        nets: true,
        jobs: 1,
        again: Again {
            scenario: "own.toml".into(),
            arguments: Vec::new(),
            has_faults: false,
        },
        fresh: true,
        out: folder.path(),
    };
    let times = Times {
        runs: 1,
        pairs: true,
        only: ["slip", "drift"].map(str::to_owned).to_vec(),
    };
    let ground = Ground::new(scenario, plans, setup.again.clone());
    let result = faults([&ground, &ground], &setup, &times, &AtomicBool::new(false));
    assert!(result.is_err());
    let faults = json(&folder.path().join("faults.json"));
    let rows = faults["rows"].as_array().expect("rows");
    let cases: Vec<_> = rows.iter().filter_map(|row| row["case"].as_str()).collect();
    assert_eq!(cases.len(), 3, "{cases:?}");
    for row in rows {
        let bad = &row["bad"][0];
        let case = row["case"].as_str().expect("a name");
        let all = if case == "pairs" { 2 } else { 1 };
        assert_eq!([&bad["faults"], &bad["of_faults"]], [0, all], "{row}");
        assert_eq!(bad["command"], "rig scenario own.toml --stepped --seed 1");
        assert!(
            folder
                .path()
                .join(case)
                .join("seed-1/report.html")
                .is_file()
        );
    }
    // A campaign of other pairs is another one: its seeds stand for other faults.
    let made = std::fs::read_to_string(folder.path().join("pairs/runs.jsonl"));
    let made = made.expect("a list of runs");
    let head = made.lines().next().expect("a first line");
    assert!(head.contains("\"pairs from 1: "), "{head}");
    assert!(["slip", "drift"].iter().all(|kind| head.contains(kind)));
}

#[test]
fn what_is_to_go_wrong_is_refused_by_name() {
    let refused = |arguments: &[&str]| {
        let mut rig = Command::new(env!("CARGO_BIN_EXE_rig"));
        rig.current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
        let output = rig.args(arguments).output().expect("it runs");
        assert_eq!(output.status.code(), Some(2), "{}", said(&output));
        // Without the line breaks of a narrow terminal.
        let words = said(&output).replace('│', " ");
        words.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let fault = |fault: &str| refused(&["scenario", "lap", "--stepped", "--fault", fault]);
    for (written, expected) in [
        ("{ at_s = 1.0 }", "missing field `for_s`"),
        (
            "{ at_s = 1.0, for_s = 1.0, what = \"unplug\" }",
            "found no `robot`, expected one for this fault",
        ),
        (
            "{ at_s = 1.0, for_s = 1.0, what = \"hang\", robot = \"amr-1\", thread = \"movement\" }",
            "found thread `movement`, expected one of `fieldbus`",
        ),
    ] {
        let said = fault(written);
        assert!(said.contains(expected), "{said}");
    }
    let campaign = |scenario: &str, kinds: &[&str]| {
        refused(&[&["campaign", scenario, "--stepped", "--runs", "1"], kinds].concat())
    };
    let said = campaign("overtaking", &["--pairs"]);
    assert!(
        said.contains("--pairs and --only are for `rig campaign faults`"),
        "{said}"
    );
    let said = campaign("faults", &["--only", "slip,slide"]);
    assert!(
        said.contains("found `slide`, expected some of: lose, repeat"),
        "{said}"
    );
}
