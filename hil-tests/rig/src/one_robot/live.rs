//! One trial through the real programs.

use std::fmt::Write;
use std::path::Path;
use std::process::ExitStatus;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use onboard::cli::Files;
use onboard::composition::plan::Plan;
use sim::rt::monotonic_ns;
use sim::world::{Shape, Truth};

use crate::belief::Insight;
use crate::cli::Failure;
use crate::judge::{Figures, Look, conduct::Judge};
use crate::one_robot::lap::print_figures;
use crate::one_robot::progress::Progress;
use crate::one_robot::stage::{Stage, StageSetup};
use crate::one_robot::summary::{Machine, RobotSummary, Summary, round};
use crate::one_robot::trial::Scenario;
use crate::one_robot::trials::leave;
use crate::report::{self, Limits};
use crate::stand_ins::operator::Operator;
use crate::stepped;

/// How often the judge looks.
const LOOK: Duration = Duration::from_millis(20);
/// The first motion may take so much longer through the real programs.
const START_PATIENCE_S: f64 = 30.0;

/// How a run through the real programs ended.
#[derive(Clone, Debug, PartialEq)]
enum Ending {
    Done,
    Interrupted,
    TooSlow,
    RobotEnded(ExitStatus),
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

/// Runs one trial through the real programs.
///
/// # Errors
/// [`Failure::Refused`] when nothing was started, [`Failure::Failed`] when it was not done or something was violated.
pub fn live(
    headless: bool,
    files: &Files,
    plan: &Plan,
    scenario: &dyn Scenario,
    seed: u64,
    out: &Path,
    asked_to_end: &AtomicBool,
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
    let ending = live.drive(headless, asked_to_end);
    live.finish(seed, out, &ending)
}

impl Live<'_> {
    fn drive(&mut self, headless: bool, asked_to_end: &AtomicBool) -> Ending {
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
            if asked_to_end.load(Ordering::Relaxed) {
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

    fn finish(mut self, seed: u64, out: &Path, ending: &Ending) -> Result<(), Failure> {
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
