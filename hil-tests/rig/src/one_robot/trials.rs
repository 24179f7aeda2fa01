//! `rig course` and `rig clutter`: trials on the simulated clock by the thousand, and through the real programs.

use onboard::cli::Files;
use onboard::composition::plan::Plan;

use crate::cli::{Failure, TrialArgs};
use crate::folder::Folder;
use crate::one_robot::campaign::campaign;
use crate::one_robot::course::Course;
use crate::one_robot::live::live;
use crate::one_robot::stage::{end_flag, write};
use crate::one_robot::summary::{Machine, RobotSummary, Summary, round};
use crate::one_robot::trial::Scenario;
use crate::report::{self, Limits};
use crate::stand_ins::clutter::Clutter;
use crate::stepped::{self, Outcome, Setup, Trace};

/// Longest time of a round of the course: driven in about five minutes, with waits in between.
const COURSE_S: f64 = 900.0;
/// Longest time through the clutter: driven freely in under half a minute.
const CLUTTER_S: f64 = 180.0;
/// From how far people heed a robot that is in their way.
const PEOPLE_HEED_M: f64 = 0.0;
/// Runs the course.
///
/// # Errors
/// [`Failure::Refused`] when nothing was started, [`Failure::Failed`] when a run failed.
pub fn course(arguments: &TrialArgs) -> Result<(), Failure> {
    let files = files(arguments, "config/sites/course.toml", &[]);
    let plan = Plan::load(&files)?;
    let scenario = Course {
        start_state: plan
            .start
            .start_state
            .clone()
            .unwrap_or_else(|| plan.fsm.initial.clone()),
        patience_s: COURSE_S,
    };
    trial(arguments, &files, &plan, &scenario)
}

/// Runs the clutter.
///
/// # Errors
/// [`Failure::Refused`] when nothing was started, [`Failure::Failed`] when too many runs failed.
pub fn clutter(arguments: &TrialArgs) -> Result<(), Failure> {
    // Who goes around boxes leaves the lane farther than a robot in an empty corridor may.
    let mut set = ["1", "2"]
        .map(|area| format!("areas.{area}.deviation_limit_m=1.2"))
        .to_vec();
    set.push("tubes.detour_curvature_1_m=4".to_owned());
    let files = files(arguments, "config/sites/corridor.toml", &set);
    let plan = Plan::load(&files)?;
    let scenario = Clutter {
        patience_s: CLUTTER_S,
        people_heed_m: PEOPLE_HEED_M,
    };
    trial(arguments, &files, &plan, &scenario)
}

fn files(arguments: &TrialArgs, site: &str, set: &[String]) -> Files {
    Files {
        robot: arguments.robot.clone(),
        site: arguments.site.clone().unwrap_or_else(|| site.into()),
        set: set.iter().chain(&arguments.set).cloned().collect(),
    }
}

fn trial(
    arguments: &TrialArgs,
    files: &Files,
    plan: &Plan,
    scenario: &dyn Scenario,
) -> Result<(), Failure> {
    let out = arguments.out.clone();
    let out = out.unwrap_or_else(|| format!("target/rig/{}", scenario.name()).into());
    let asked_to_end = end_flag()?;
    if arguments.stepped && arguments.runs > 1 {
        let (statistics, _) = campaign(
            plan,
            files,
            scenario,
            arguments.seed,
            arguments.runs,
            arguments.jobs,
            &asked_to_end,
        )?;
        statistics.print();
        statistics.write(&out)?;
        let share = statistics.done as f64 / statistics.runs.max(1) as f64;
        let good = statistics.clean == statistics.runs
            && statistics.runs == arguments.runs
            && share >= scenario.least_done_share();
        return if good {
            Ok(())
        } else {
            Err(Failure::failed(format_args!(
                "{} of {} runs failed",
                arguments.runs - statistics.passed,
                arguments.runs
            )))
        };
    }
    if arguments.stepped {
        return stepped_once(arguments, files, plan, scenario, &out);
    }
    let mut failed = Vec::new();
    for run in 0..arguments.runs {
        let seed = arguments.seed + run as u64;
        let out = if arguments.runs > 1 {
            out.join(format!("seed-{seed}"))
        } else {
            out.clone()
        };
        match live(
            arguments.headless,
            files,
            plan,
            scenario,
            seed,
            &out,
            &asked_to_end,
        ) {
            Ok(()) => {}
            Err(Failure::Failed(report)) if arguments.runs > 1 => {
                println!("FAILED seed {seed}: {report}");
                failed.push(seed);
            }
            Err(failure) => return Err(failure),
        }
        if asked_to_end.load(std::sync::atomic::Ordering::Relaxed) {
            break;
        }
    }
    if failed.is_empty() {
        return Ok(());
    }
    Err(Failure::failed(format_args!(
        "{} of {} runs failed: seeds {failed:?}",
        failed.len(),
        arguments.runs
    )))
}

/// One run on the simulated clock, with pictures and traces.
fn stepped_once(
    arguments: &TrialArgs,
    files: &Files,
    plan: &Plan,
    scenario: &dyn Scenario,
    out: &std::path::Path,
) -> Result<(), Failure> {
    let folder = Folder::new()?;
    let setup = Setup {
        plan,
        files,
        scenario,
        folder: folder.path(),
        heeds_leave: true,
    };
    let mut outcome = stepped::run(&setup, arguments.seed, true)?;
    let trace = outcome.trace.take().unwrap_or_default();
    let summary = stepped_summary(plan, scenario, &outcome, &trace);
    write(out, "trace.csv", &trace.table)?;
    write(out, "others.csv", &trace.others)?;
    write(out, "notes.txt", &(trace.notes.join("\n") + "\n"))?;
    let changes: Vec<_> = trace
        .changes
        .iter()
        .cloned()
        .map(|change| crate::one_robot::listener::Change {
            robot_id: plan.robot.identity.id.clone(),
            ..change
        })
        .collect();
    let svg = report::svg(
        &plan.site,
        &plan.robot,
        &trace.path,
        &changes,
        &summary,
        &Limits::CONTACT,
        &trace.obstacles,
    );
    leave(out, &summary, &svg)?;
    println!(
        "outcome: {} after {:.1} s of simulated time",
        summary.outcome, summary.duration_s
    );
    for violation in &summary.violations {
        println!(
            "VIOLATION {} at {:.1} s: {}",
            violation.kind, violation.at_s, violation.detail
        );
    }
    println!(
        "wrote report.svg, report.html, summary.json, trace.csv, others.csv and notes.txt to {}",
        out.display()
    );
    if outcome.passed() {
        return Ok(());
    }
    Err(Failure::failed(outcome.reason()))
}

fn stepped_summary(
    plan: &Plan,
    scenario: &dyn Scenario,
    outcome: &Outcome,
    trace: &Trace,
) -> Summary {
    let last = trace.path.last();
    let fastest_m_s = trace
        .path
        .iter()
        .map(|truth| truth.twist.v_m_s.abs())
        .fold(0.0, f64::max);
    let robot = RobotSummary {
        id: plan.robot.identity.id.clone(),
        distance_m: round(outcome.figures.distance_m),
        collisions: last.map_or(0, |truth| truth.collisions),
        min_clearance_m: round(outcome.figures.min_clearance_m),
        max_speed_m_s: round(fastest_m_s),
        ..RobotSummary::default()
    };
    Summary {
        scenario: format!("{} (stepped)", scenario.name()),
        outcome: if outcome.done {
            "done".to_owned()
        } else {
            outcome.missing.clone()
        },
        seed: outcome.seed,
        duration_s: round(outcome.figures.duration_s),
        machine: Machine::here(),
        robots: vec![robot],
        violations: outcome.violations.clone(),
        figures: Some(outcome.figures.clone()),
    }
}

/// What every run leaves: summary and report, as a drawing and as a page.
///
/// # Errors
/// [`Failure::Failed`] when a file cannot be written.
pub fn leave(out: &std::path::Path, summary: &Summary, svg: &str) -> Result<(), Failure> {
    let json = serde_json::to_string_pretty(summary).map_err(Failure::failed)?;
    write(out, "summary.json", &json)?;
    write(out, "report.svg", svg)?;
    write(out, "report.html", &report::html(summary, svg))?;
    Ok(())
}
