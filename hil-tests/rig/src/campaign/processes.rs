//! `rig campaign`: a scenario many times, each run a process of its own with a seed and a folder of its own.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use onboard::cli::Failure;
use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

use super::pool::run_all;
use super::spread::{Spread, spread, together};
use crate::machine::{Machine, round};
use crate::output::write_json;
use crate::process::Process;
use crate::scenario::Scenario;
use crate::stalls::Stalls;
use crate::summary::{Latency, Spoiled};

/// How often running processes are polled.
const LOOK: Duration = Duration::from_millis(50);

/// `campaign.json`.
#[derive(Debug, Serialize)]
struct Campaign {
    scenario: String,
    /// With the rounds and controls of the runs.
    arguments: Vec<String>,
    machine: Machine,
    jobs: usize,
    succeeded: usize,
    violations: usize,
    collisions: u64,
    /// Seconds of runs that succeeded.
    duration_s: Spread,
    /// Of all runs together: the median of their medians, the largest of their 99th percentiles, and the largest.
    grants: Latency,
    /// The same.
    commands: Latency,
    /// Of all runs together.
    stalls: Stalls,
    /// Runs that were made once more, since a stall of the machine had spoiled them.
    repeated: usize,
    /// How often operators reset robots.
    resets: u64,
    runs: Vec<Outcome>,
}

/// One run.
#[derive(Clone, Debug, Serialize)]
struct Outcome {
    seed: u64,
    succeeded: bool,
    outcome: String,
    duration_s: f64,
    collisions: u64,
    least_clearance_m: f64,
    longest_wait_s: f64,
    coordinations: usize,
    /// How often operators reset robots.
    resets: u64,
    grants: Latency,
    commands: Latency,
    violations: Vec<String>,
    /// How often and how long the machine stalled; none without a summary.
    stalls: Option<Stalls>,
    /// The run before it, if a stall of the machine spoiled it: this one is its repetition.
    spoiled: Option<Spoiled>,
    folder: PathBuf,
}

/// What a campaign is.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The scenario as `rig scenario` takes it: its file, or the name of one that ships.
    pub scenario: PathBuf,
    /// More arguments of `rig scenario`, for all runs.
    pub arguments: Vec<String>,
    /// Seed of the first run.
    pub first_seed: u64,
    /// How many runs.
    pub runs: usize,
    /// How many at once.
    pub jobs: usize,
    /// Folder for `campaign.json` and a folder for each run.
    pub out: PathBuf,
}

/// Runs a scenario many times.
///
/// # Errors
/// [`Failure::Refused`] when no run can be started, [`Failure::Failed`] when a run failed.
pub fn campaign(
    scenario: &Scenario,
    setup: &Setup,
    asked_to_end: &AtomicBool,
) -> Result<(), Failure> {
    let program = std::env::current_exe().map_err(Failure::refused)?;
    onboard::say!(
        "campaign: {} times {}, seeds {} to {}, {} at once; in {}",
        setup.runs,
        scenario.name,
        setup.first_seed,
        setup.first_seed + setup.runs as u64 - 1,
        setup.jobs,
        setup.out.display()
    );
    print_head();
    let run = |number: usize| {
        one(
            &program,
            setup,
            setup.first_seed + number as u64,
            asked_to_end,
        )
    };
    let show = |outcome: &Outcome, _| print_line(outcome);
    let runs = run_all(setup.runs, setup.jobs, asked_to_end, run, show)?;
    let campaign = sum_up(scenario, setup.arguments.clone(), setup.jobs, runs);
    let file = write_json(&setup.out, "campaign.json", &campaign)?;
    print_sum(&campaign, &file);
    if campaign.succeeded == setup.runs {
        return Ok(());
    }
    Err(Failure::failed(format_args!(
        "{} of {} runs succeeded{}",
        campaign.succeeded,
        setup.runs,
        if campaign.runs.len() < setup.runs {
            format!("; interrupted after {}", campaign.runs.len())
        } else {
            String::new()
        }
    )))
}

/// One run as a process; a refusal ends the campaign, since the next run would be refused alike.
fn one(
    program: &Path,
    setup: &Setup,
    seed: u64,
    asked_to_end: &AtomicBool,
) -> Result<Outcome, Failure> {
    let folder = setup.out.join(seed.to_string());
    let cannot = |what: String| Failure::refused(format_args!("the run of seed {seed}: {what}"));
    fs::create_dir_all(&folder)
        .map_err(|error| cannot(format!("folder {}: {error}", folder.display())))?;
    let summary = folder.join("summary.json");
    let log = folder.join("rig.log");
    for old in [&summary, &log] {
        // What an earlier campaign left must not be taken for this one's.
        let _ = fs::remove_file(old);
    }
    let mut arguments: Vec<OsString> = vec![
        "scenario".into(),
        (&setup.scenario).into(),
        "--headless".into(),
    ];
    arguments.extend(["--seed".into(), seed.to_string().into()]);
    arguments.extend(["--out".into(), (&folder).into()]);
    arguments.extend(setup.arguments.iter().map(OsString::from));
    let mut process = Process::start(program, &arguments, &[], &log)
        .map_err(|error| cannot(error.to_string()))?;
    let status = loop {
        if let Some(status) = process.poll() {
            break status;
        }
        if asked_to_end.load(Ordering::Relaxed) {
            break process.stop();
        }
        std::thread::sleep(LOOK);
    };
    if status.code() == Some(i32::from(onboard::cli::EXIT_REFUSED)) {
        return Err(cannot(format!("refused:\n{}", process.log_tail(20))));
    }
    let json: Json = fs::read_to_string(&summary)
        .ok()
        .and_then(|text| serde_json::from_str(&text).ok())
        .unwrap_or(Json::Null);
    Ok(read(&json, seed, status.success(), &folder))
}

fn read(json: &Json, seed: u64, succeeded: bool, folder: &Path) -> Outcome {
    let list = |key: &str| json[key].as_array().cloned().unwrap_or_default();
    let latency = |key: &str| Latency {
        count: usize::try_from(json[key]["count"].as_u64().unwrap_or(0)).unwrap_or(usize::MAX),
        p50_ms: json[key]["p50_ms"].as_f64(),
        p99_ms: json[key]["p99_ms"].as_f64(),
        max_ms: json[key]["max_ms"].as_f64(),
    };
    let text = |json: &Json| json.as_str().unwrap_or_default().to_owned();
    let robots = list("robots");
    let clearances = { robots.iter() }.filter_map(|robot| robot["min_clearance_m"].as_f64());
    let waits = list("areas");
    Outcome {
        seed,
        succeeded,
        outcome: match json["outcome"].as_str() {
            Some(outcome) => outcome.to_owned(),
            None => format!("left no summary; see {}", folder.join("rig.log").display()),
        },
        duration_s: json["duration_s"].as_f64().unwrap_or(0.0),
        collisions: { robots.iter() }
            .filter_map(|robot| robot["collisions"].as_u64())
            .sum(),
        least_clearance_m: round(clearances.fold(f64::INFINITY, f64::min)),
        longest_wait_s: { waits.iter() }
            .filter_map(|area| area["longest_wait_s"].as_f64())
            .fold(0.0, f64::max),
        coordinations: list("coordinations").len(),
        resets: { robots.iter() }
            .filter_map(|robot| robot["resets"].as_u64())
            .sum(),
        grants: latency("grants"),
        commands: latency("commands"),
        violations: { list("violations").into_iter() }
            .map(|own| format!("{} of {}", text(&own["kind"]), text(&own["robot"])))
            .collect(),
        stalls: Stalls::deserialize(&json["stalls"]).ok(),
        spoiled: Spoiled::deserialize(&json["spoiled"]).ok(),
        folder: folder.to_owned(),
    }
}

fn sum_up(
    scenario: &Scenario,
    arguments: Vec<String>,
    jobs: usize,
    runs: Vec<Outcome>,
) -> Campaign {
    let durations: Vec<f64> = { runs.iter() }
        .filter(|run| run.succeeded)
        .map(|run| run.duration_s)
        .collect();
    Campaign {
        scenario: scenario.name.clone(),
        arguments,
        machine: Machine::here(),
        jobs,
        succeeded: durations.len(),
        violations: runs.iter().map(|run| run.violations.len()).sum(),
        collisions: runs.iter().map(|run| run.collisions).sum(),
        duration_s: spread(&durations),
        grants: together(runs.iter().map(|run| &run.grants)),
        commands: together(runs.iter().map(|run| &run.commands)),
        stalls: Stalls::together(runs.iter().filter_map(|run| run.stalls)),
        repeated: runs.iter().filter(|run| run.spoiled.is_some()).count(),
        resets: runs.iter().map(|run| run.resets).sum(),
        runs,
    }
}

fn print_head() {
    onboard::say!(
        "{:>6}  {:<9} {:>8}  {:>9} {:>9}  {:>9} {:>9}  {:>9}  outcome",
        "seed",
        "",
        "time s",
        "grant p50",
        "p99 ms",
        "cmd p50",
        "p99 ms",
        "clear m"
    );
}

fn print_line(run: &Outcome) {
    let ms = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
    let violations = if run.violations.is_empty() {
        String::new()
    } else {
        format!("; VIOLATIONS {}", run.violations.join(", "))
    };
    if let Some(Spoiled { reason, stalls }) = &run.spoiled {
        onboard::say!(
            "{:>6}  {:<9} {reason} ({stalls}); once more:",
            run.seed,
            "SPOILED"
        );
    }
    onboard::say!(
        "{:>6}  {:<9} {:>8.1}  {:>9} {:>9}  {:>9} {:>9}  {:>9.3}  {}{violations}",
        run.seed,
        if run.succeeded { "succeeded" } else { "FAILED" },
        run.duration_s,
        ms(run.grants.p50_ms),
        ms(run.grants.p99_ms),
        ms(run.commands.p50_ms),
        ms(run.commands.p99_ms),
        run.least_clearance_m,
        run.outcome
    );
}

fn print_sum(campaign: &Campaign, file: &Path) {
    let ms = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
    onboard::say!(
        "{} of {} succeeded, {} violations, {} collisions; {:.1} to {:.1} s, median {:.1} s",
        campaign.succeeded,
        campaign.runs.len(),
        campaign.violations,
        campaign.collisions,
        campaign.duration_s.min,
        campaign.duration_s.max,
        campaign.duration_s.p50
    );
    for (what, own) in [
        ("grants", &campaign.grants),
        ("commands", &campaign.commands),
    ] {
        onboard::say!(
            "{what}: {} measured, p50 {} ms, worst p99 of a run {} ms, max {} ms",
            own.count,
            ms(own.p50_ms),
            ms(own.p99_ms),
            ms(own.max_ms)
        );
    }
    let again = match campaign.repeated {
        0 => String::new(),
        runs => format!("; {runs} runs that it spoiled were made once more"),
    };
    onboard::say!("{}{again}; {} resets", campaign.stalls, campaign.resets);
    onboard::say!("wrote {}", file.display());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_without_a_summary_has_failed_and_says_where_to_look() {
        let run = read(&Json::Null, 7, false, Path::new("somewhere/7"));
        assert!(!run.succeeded);
        assert!(
            run.outcome.contains("somewhere/7/rig.log"),
            "{}",
            run.outcome
        );
    }

    #[test]
    fn figures_of_runs_are_put_together() {
        let run = |ms: f64, seconds: f64| {
            let json = serde_json::json!({
                "outcome": "done", "duration_s": seconds,
                "robots": [{ "collisions": 1, "min_clearance_m": ms, "resets": 2 }, { "collisions": 0, "resets": 1 }],
                "areas": [{ "longest_wait_s": ms }],
                "grants": { "count": 2, "p50_ms": ms, "p99_ms": 2.0 * ms, "max_ms": 2.0 * ms },
                "violations": [{ "kind": "collision", "robot": "a" }],
                "stalls": { "count": 2, "longest_ms": ms, "steal_ms": 0.5 },
                "spoiled": { "reason": "stuck", "stalls": Stalls::default() },
            });
            read(&json, 1, true, Path::new("x"))
        };
        let runs = [run(1.0, 10.0), run(2.0, 30.0), run(9.0, 20.0)];
        let grants = together(runs.iter().map(|run| &run.grants));
        assert_eq!(
            (grants.count, grants.p50_ms, grants.p99_ms),
            (6, Some(2.0), Some(18.0))
        );
        assert_eq!(together(runs.iter().map(|run| &run.commands)).p50_ms, None);
        assert_eq!(runs[0].violations, ["collision of a"]);
        assert_eq!((runs[2].collisions, runs[2].longest_wait_s), (1, 9.0));
        let spread = spread(&runs.each_ref().map(|run| run.duration_s));
        assert_eq!((spread.min, spread.p50, spread.max), (10.0, 20.0, 30.0));
        let quiet = read(&Json::Null, 4, false, Path::new("x"));
        assert_eq!((quiet.stalls, quiet.spoiled.is_none()), (None, true));
        let scenario = crate::testing::scenario("lap");
        let runs = [&runs[..], &[quiet]].concat();
        let all = sum_up(&scenario, Vec::new(), 1, runs);
        let (stalls, repeated) = (all.stalls, all.repeated);
        assert_eq!((stalls.count, stalls.longest_ms, repeated), (6, 9.0, 3));
        assert_eq!((all.resets, all.runs[0].resets), (9, 3));
    }
}
