//! `rig lap`: one robot drives laps of a corridor.

use std::path::Path;
use std::process::ExitStatus;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde_json::Value as Json;
use sim::world::Truth;

use crate::cli::{Failure, LapArgs};
use crate::one_robot::judge::Judge;
use crate::one_robot::progress::Progress;
use crate::one_robot::stage::{Stage, StageSetup, end_flag, write};
use crate::one_robot::summary::{Machine, RobotSummary, Summary, round};
use crate::report::{self, Limits};

/// How often the judge looks at the world's log.
const LOOK: Duration = Duration::from_millis(20);
/// Longest time that one lap may take, and that the first motion may take on top.
const LAP_PATIENCE: Duration = Duration::from_secs(150);

/// Runs the scenario.
///
/// # Errors
/// [`Failure::Refused`] when nothing was started, [`Failure::Failed`] when laps are missing or something was violated.
pub fn lap(arguments: &LapArgs) -> Result<(), Failure> {
    let asked_to_end = end_flag()?;
    let stage = Stage::set(
        &StageSetup {
            robot_file: &arguments.robot,
            site_file: &arguments.site,
            set: &[],
            seed: arguments.seed,
            out: &arguments.out,
        },
        |_| Ok(()),
    )?;
    println!(
        "lap: robot {} in {}, seed {}, {} laps; log in {}",
        stage.robot.identity.id,
        stage.site.name,
        arguments.seed,
        arguments.laps,
        stage.process.setup().log.display()
    );
    let mut scenario = Scenario {
        judge: Judge::new(&stage.robot.identity.id, &stage.site, stage.start_ns),
        stage,
        path: Vec::new(),
    };
    let outcome = scenario.drive(arguments, &asked_to_end);
    scenario.finish(arguments, outcome)
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
enum Outcome {
    Done,
    Interrupted,
    TooSlow,
    RobotEnded(ExitStatus),
}

/// A run under way.
struct Scenario {
    stage: Stage,
    judge: Judge,
    path: Vec<Truth>,
}

impl Scenario {
    fn drive(&mut self, arguments: &LapArgs, asked_to_end: &AtomicBool) -> Outcome {
        let mut progress = Progress::new(arguments.headless);
        let began = Instant::now();
        let patience = LAP_PATIENCE * (arguments.laps + 1);
        let outcome = loop {
            std::thread::sleep(LOOK);
            self.look();
            if let Some(truth) = self.path.last() {
                let heard = self.stage.listener.heard(&self.stage.robot.identity.id);
                let state = heard.as_ref().map(|heard| &heard.state);
                let what = format!("lap {}/{}", self.judge.laps(), arguments.laps);
                progress.show(&what, state, truth);
            }
            self.stage.usage.look();
            if let Some(status) = self.stage.process.poll() {
                break Outcome::RobotEnded(status);
            }
            if asked_to_end.load(Ordering::Relaxed) {
                break Outcome::Interrupted;
            }
            if self.judge.laps() >= arguments.laps {
                break Outcome::Done;
            }
            if began.elapsed() > patience {
                break Outcome::TooSlow;
            }
        };
        progress.end();
        outcome
    }

    /// Takes in what the world has logged since the last look.
    fn look(&mut self) {
        for truth in self.stage.new_truths() {
            self.judge.observe(&truth);
            self.path.push(truth);
        }
    }

    fn finish(mut self, arguments: &LapArgs, outcome: Outcome) -> Result<(), Failure> {
        // Before it ends: afterwards there is nothing to look into.
        let symbols = self.stage.symbols();
        let status = self.stage.process.stop();
        self.look();
        let at_s = self.stage.elapsed_s();
        for (kind, detail) in self.stage.device_violations() {
            self.judge.report(kind, at_s, detail);
        }
        if !matches!(outcome, Outcome::RobotEnded(_))
            && let Some((kind, detail)) = Stage::end_violation(status)
        {
            self.judge.report(kind, at_s, detail);
        }
        let summary = self.summary(arguments, &outcome, &symbols);
        let json = serde_json::to_string_pretty(&summary).map_err(Failure::failed)?;
        write(&arguments.out, "summary.json", &json)?;
        let svg = report::svg(
            &self.stage.site,
            &self.stage.robot,
            &self.path,
            &self.stage.listener.changes(),
            &summary,
            &Limits::LANE,
            &[],
        );
        write(&arguments.out, "report.svg", &svg)?;
        print_figures(&summary, &arguments.out);
        if outcome == Outcome::Done && summary.violations.is_empty() {
            return Ok(());
        }
        let log = self.stage.process.log_tail(12);
        Err(Failure::failed(format_args!(
            "{}; {} violations; the robot's last words:\n{log}",
            summary.outcome,
            summary.violations.len()
        )))
    }

    fn summary(&self, arguments: &LapArgs, outcome: &Outcome, symbols: &Json) -> Summary {
        let robot = RobotSummary {
            laps: self.judge.laps(),
            max_lateral_error_m: round(self.judge.max_lateral_error_m),
            max_speed_m_s: round(self.judge.max_speed_m_s),
            ..self.stage.robot_summary(self.path.last(), symbols)
        };
        Summary {
            scenario: "lap".to_owned(),
            outcome: match outcome {
                Outcome::Done => "done".to_owned(),
                Outcome::Interrupted => "interrupted".to_owned(),
                Outcome::TooSlow => {
                    format!("only {} of {} laps in time", robot.laps, arguments.laps)
                }
                Outcome::RobotEnded(status) => format!("the robot ended by itself with {status}"),
            },
            seed: arguments.seed,
            duration_s: round(self.stage.elapsed_s()),
            machine: Machine::here(),
            robots: vec![robot],
            violations: self.judge.violations.clone(),
            figures: None,
        }
    }
}

/// Prints what a summary says.
pub fn print_figures(summary: &Summary, out: &Path) {
    println!(
        "outcome: {} after {:.1} s",
        summary.outcome, summary.duration_s
    );
    for robot in &summary.robots {
        println!(
            "{}: {} laps, {:.2} m, {} collisions, clearance at least {:.3} m, lateral error at most {:.3} m",
            robot.id,
            robot.laps,
            robot.distance_m,
            robot.collisions,
            robot.min_clearance_m,
            robot.max_lateral_error_m
        );
        println!(
            "  {:.1} MiB resident, {:.1} % of one core ({}, {} cores)",
            robot.rss_mib, robot.cpu_percent, summary.machine.processor, summary.machine.cores
        );
        println!(
            "  EtherCAT: {} cycles, {} lost, {} wrong counters; lidar: {} scans, {} dropped",
            robot.ethercat.cycles,
            robot.ethercat.lost_frames,
            robot.ethercat.wkc_errors,
            robot.lidar.scans,
            robot.lidar.dropped
        );
        for (name, thread) in robot.threads.as_object().into_iter().flatten() {
            let of = |what: &str, part: &str| thread[what][part].as_f64().unwrap_or(0.0);
            println!(
                "  {name:<14} wake-up p50 {:>6.0} p99 {:>6.0} max {:>7.0} µs; execution p50 {:>5.0} p99 {:>6.0} max {:>7.0} µs; {} overruns of {}",
                of("wakeup_us", "p50"),
                of("wakeup_us", "p99"),
                of("wakeup_us", "max"),
                of("exec_us", "p50"),
                of("exec_us", "p99"),
                of("exec_us", "max"),
                thread["overruns"],
                thread["cycles"]
            );
        }
    }
    for violation in &summary.violations {
        println!(
            "VIOLATION {} at {:.1} s: {}",
            violation.kind, violation.at_s, violation.detail
        );
    }
    println!(
        "wrote {} and report.svg",
        out.join("summary.json").display()
    );
}
