//! A stepped campaign that is killed goes on where it was, and comes to the same.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use onboard::process::runtime::Runtime;
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
        .args(["campaign", "overtaking", "--stepped", "--runs", "4"])
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
        assert!(waits && first.try_wait().is_ok_and(|ended| ended.is_none()));
        std::thread::sleep(Duration::from_millis(5));
    };
    // Between two runs there is no robot that could leave something.
    let prefixes = loop {
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
    assert!(made < 4 && !killed.join("campaign.json").exists());
    // It was writing a line.
    let mut text = fs::read_to_string(&runs).expect("there");
    let made = text.lines().count() - 1;
    text.push_str("{\"elapsed_s\":1.0,\"run\":{\"scen");
    fs::write(&runs, text).expect("written");

    let second = campaign(&killed).output().expect("run");
    let said = said(&second);
    assert!(second.status.success(), "{said}");
    let resumed = format!("resumed: {made} of 4 runs were made before");
    assert!(said.contains(&resumed), "{said}");
    let third = campaign(&whole).output().expect("run");
    assert!(third.status.success(), "{}", self::said(&third));
    assert_eq!(left(&killed), left(&whole));
    assert_eq!(left(&whole)["seeds"], json!([1, 4]));
    assert_eq!(left(&whole)["passed"], 4);
    // Nothing is left to do.
    let fourth = campaign(&killed).output().expect("run");
    assert!(self::said(&fourth).contains("resumed: 4 of 4"));
    assert_eq!(left(&killed), left(&whole));
}

#[test]
fn runs_are_compared_seed_by_seed() {
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
    let none = rig(&["agreement", "lap", "--real", real]);
    assert!(said(&none).contains("rig campaign lap"), "{}", said(&none));
    // A stepped run stands for the real one: it agrees with itself, until its summary is changed.
    let run = rig(&["lap", "--stepped", "--seed", "4", "--out", one_text]);
    assert!(run.status.success(), "{}", said(&run));
    let file = one.join("summary.json");
    let change = |key: &str, value: Json| {
        let text = fs::read_to_string(&file).expect("a summary");
        let mut summary: Json = serde_json::from_str(&text).expect("JSON");
        summary[key] = value;
        fs::write(&file, summary.to_string()).expect("written");
    };
    change("scenario", json!("lap"));
    let agree = rig(&["agreement", "lap", "--real", real]);
    assert!(agree.status.success(), "{}", said(&agree));
    assert!(said(&agree).contains("1 of 1 seeds agree"));
    change("duration_s", json!(1.0));
    let differ = rig(&["agreement", "lap", "--real", real]);
    assert!(!differ.status.success() && said(&differ).contains("duration in seconds: real 1.000"));
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
