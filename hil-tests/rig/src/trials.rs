//! `rig course` and `rig clutter`: trials on the simulated clock by the thousand, and through the real programs.

use std::fmt::Write;
use std::time::Duration;

use onboard::cli::Files;
use onboard::plan::Plan;
use sim::rt::monotonic_ns;
use sim::world::{Shape, Truth};

use crate::campaign::campaign;
use crate::cli::{Failure, TrialArgs};
use crate::folder::Folder;
use crate::lap::print_figures;
use crate::progress::Progress;
use crate::report::{self, Limits};
use crate::stage::{Stage, StageSetup, end_flag, write};
use crate::stepped::{self, Outcome, Setup, Trace};
use crate::summary::{Machine, RobotSummary, Summary, round};
use crate::trial::clutter::Clutter;
use crate::trial::course::Course;
use crate::trial::insight::Insight;
use crate::trial::operator::Operator;
use crate::trial::scenario::Scenario;
use crate::trial::{Figures, Judge, Look};

/// Longest time of a round of the course: driven in about five minutes, with waits in between.
const COURSE_S: f64 = 900.0;
/// Longest time through the clutter: driven freely in under half a minute.
const CLUTTER_S: f64 = 180.0;
/// From how far people heed a robot that is in their way.
const PEOPLE_HEED_M: f64 = 0.0;
/// How often the judge looks.
const LOOK: Duration = Duration::from_millis(20);
/// The first motion may take so much longer through the real programs.
const START_PATIENCE_S: f64 = 30.0;

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
    let set = ["1", "2"].map(|area| format!("areas.{area}.deviation_limit_m=1.2"));
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
        match live(arguments, files, plan, scenario, seed, &out, &asked_to_end) {
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
        .map(|change| crate::listener::Change {
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
fn leave(out: &std::path::Path, summary: &Summary, svg: &str) -> Result<(), Failure> {
    let json = serde_json::to_string_pretty(summary).map_err(Failure::failed)?;
    write(out, "summary.json", &json)?;
    write(out, "report.svg", svg)?;
    write(out, "report.html", &report::html(summary, svg))?;
    Ok(())
}

/// How a run through the real programs ended.
#[derive(Clone, Debug, PartialEq)]
enum Ending {
    Done,
    Interrupted,
    TooSlow,
    RobotEnded(std::process::ExitStatus),
}

/// A run through the real programs.
struct Live<'a> {
    stage: Stage,
    judge: Judge,
    plan: &'a Plan,
    scenario: &'a dyn Scenario,
    insight: Option<Insight>,
    operator: Operator,
    path: Vec<Truth>,
}

fn live(
    arguments: &TrialArgs,
    files: &Files,
    plan: &Plan,
    scenario: &dyn Scenario,
    seed: u64,
    out: &std::path::Path,
    asked_to_end: &std::sync::atomic::AtomicBool,
) -> Result<(), Failure> {
    let stage = Stage::set(
        &StageSetup {
            robot_file: &files.robot,
            site_file: &files.site,
            set: &files.set,
            seed,
            out,
        },
        |world| scenario.furnish(world, seed),
    )?;
    println!(
        "{}: robot {} in {}, seed {seed}; log in {}",
        scenario.name(),
        stage.robot.identity.id,
        stage.site.name,
        stage.process.setup().log.display()
    );
    let judge = Judge::new(
        &plan.robot,
        &plan.site,
        &plan.fsm,
        scenario.rules(),
        stage.start_ns,
    );
    let mut live = Live {
        stage,
        judge,
        plan,
        scenario,
        insight: None,
        operator: Operator::new(seed),
        path: Vec::new(),
    };
    let ending = live.drive(arguments.headless, asked_to_end);
    live.finish(seed, out, &ending)
}

impl Live<'_> {
    fn drive(&mut self, headless: bool, asked_to_end: &std::sync::atomic::AtomicBool) -> Ending {
        let mut progress = Progress::new(headless);
        let ending = loop {
            std::thread::sleep(LOOK);
            if self.look() {
                break Ending::Done;
            }
            if let Some(truth) = self.path.last() {
                let heard = self.stage.listener.heard(&self.plan.robot.identity.id);
                let state = heard.as_ref().map(|heard| &heard.state);
                progress.show(self.scenario.name(), state, truth);
            }
            self.stage.usage.look();
            if let Some(status) = self.stage.process.poll() {
                break Ending::RobotEnded(status);
            }
            if asked_to_end.load(std::sync::atomic::Ordering::Relaxed) {
                break Ending::Interrupted;
            }
            if self.stage.elapsed_s() > self.scenario.patience_s() + START_PATIENCE_S {
                break Ending::TooSlow;
            }
        };
        progress.end();
        ending
    }

    /// One look of the judge and the operator; true when the trial is done.
    fn look(&mut self) -> bool {
        self.path.extend(self.stage.new_truths());
        let id = &self.plan.robot.identity.id;
        if self.insight.is_none() {
            // It runs when its symbols can be read.
            self.insight = Insight::open(id, &self.stage.runtime.place()).ok();
        }
        let belief = self.insight.as_mut().map(Insight::look).unwrap_or_default();
        let truth = {
            let mut world = self.stage.world.lock();
            world.advance_to(monotonic_ns());
            let Some(truth) = world.truth(0) else {
                return false;
            };
            self.judge.observe(&Look {
                world: &world,
                robot: 0,
                truth: &truth,
                belief: &belief,
                granted: &[],
            });
            truth
        };
        let (site, fsm) = (&self.plan.site, &self.plan.fsm);
        if let Some(instruction) = self.operator.look(site, fsm, &belief.state, &truth) {
            if let Some(pose) = instruction.stop_at {
                self.judge.instructed(pose);
            }
            if let Err(why) = stepped::send(&self.stage.runtime, id, &instruction) {
                self.judge.report("instruction", truth.time_ns, why);
            }
        }
        let figures = self.judge.figures();
        self.scenario.is_done(site, fsm, figures, &truth)
    }

    fn finish(mut self, seed: u64, out: &std::path::Path, ending: &Ending) -> Result<(), Failure> {
        // Before it ends: afterwards there is nothing to look into.
        let symbols = self.stage.symbols();
        let status = self.stage.process.stop();
        self.path.extend(self.stage.new_truths());
        let now_ns = monotonic_ns();
        for (kind, detail) in self.stage.device_violations() {
            self.judge.report(kind, now_ns, detail);
        }
        if !matches!(ending, Ending::RobotEnded(_))
            && let Some((kind, detail)) = Stage::end_violation(status)
        {
            self.judge.report(kind, now_ns, detail);
        }
        let figures = self.judge.figures().clone();
        let fastest_m_s = self
            .path
            .iter()
            .map(|truth| truth.twist.v_m_s.abs())
            .fold(0.0, f64::max);
        let robot = RobotSummary {
            max_speed_m_s: round(fastest_m_s),
            ..self.stage.robot_summary(self.path.last(), &symbols)
        };
        let missing = self
            .scenario
            .missing(&self.plan.site, &self.plan.fsm, &figures);
        let summary = Summary {
            scenario: self.scenario.name().to_owned(),
            outcome: match ending {
                Ending::Done => "done".to_owned(),
                Ending::Interrupted => "interrupted".to_owned(),
                Ending::TooSlow => missing,
                Ending::RobotEnded(status) => format!("the robot ended by itself with {status}"),
            },
            seed,
            duration_s: round(self.stage.elapsed_s()),
            machine: Machine::here(),
            robots: vec![robot],
            violations: self.judge.violations().to_vec(),
            figures: Some(figures),
        };
        let obstacles: Vec<Shape> = self
            .stage
            .world
            .lock()
            .obstacles()
            .map(|(_, shape)| shape)
            .filter(|shape| !matches!(shape, Shape::Wall(_)))
            .collect();
        let svg = report::svg(
            &self.plan.site,
            &self.plan.robot,
            &self.path,
            &self.stage.listener.changes(),
            &summary,
            &Limits::CONTACT,
            &obstacles,
        );
        leave(out, &summary, &svg)?;
        print_figures(&summary, out);
        if let Some(figures) = &summary.figures {
            print!("{}", in_words(figures));
        }
        if *ending == Ending::Done && summary.violations.is_empty() {
            return Ok(());
        }
        let log = self.stage.process.log_tail(12);
        Err(Failure::failed(format_args!(
            "{}; {} violations; the robot's last words:\n{log}",
            summary.outcome,
            summary.violations.len()
        )))
    }
}

/// Figures of one run for people.
fn in_words(figures: &Figures) -> String {
    let mut text = String::new();
    let list = |errors: &[f64]| {
        let errors: Vec<String> = errors.iter().map(|error| format!("{error:+.3}")).collect();
        if errors.is_empty() {
            "none".to_owned()
        } else {
            errors.join(", ")
        }
    };
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "  pose error in view at most {:.3} m, {:.2}°; docking {} m; stops at a pose {} m, before an area {} m",
        figures.max_pose_error_m,
        figures.max_heading_error_rad.to_degrees(),
        list(&figures.dock_errors_m),
        list(&figures.pose_stop_errors_m),
        list(&figures.border_stop_errors_m)
    );
    let _ = writeln!(
        text,
        "  {} skills ran: {}; run into {} times while standing; held {:.1} s",
        figures.skills.len(),
        figures
            .skills
            .iter()
            .cloned()
            .collect::<Vec<_>>()
            .join(", "),
        figures.run_into,
        figures.held_s
    );
    text
}
