//! One trial on the simulated clock.

use std::path::Path;

use onboard::cli::Files;
use onboard::composition::plan::Plan;
use onboard::symbols::faults::{Fault, Resumes};
use serde::Serialize;
use sim::world::{Shape, Truth, World};

use super::robot::SteppedRobot;
use super::supervisor::Note;
use crate::cli::Failure;
use crate::judge::{Figures, Look, conduct::Judge};
use crate::one_robot::listener::Change;
use crate::one_robot::summary::Violation;
use crate::one_robot::trial::Scenario;
use crate::stand_ins::leave::LeaveKeeper;
use crate::stand_ins::operator::Operator;
use crate::testbed::{drawn_start, plain_world, start_pose};

/// The simulated clock begins here: 0 means "never" to the robot.
const START_NS: u64 = 1_000_000_000;
const MILLISECOND_NS: u64 = 1_000_000;
/// The judge looks this often.
const LOOK_NS: u64 = 20 * MILLISECOND_NS;

/// A fault that lasts so long does not end by itself any more.
const STRANDED_NS: u64 = 30_000 * MILLISECOND_NS;

/// What a run is made of.
pub struct Setup<'a> {
    /// The robot and its site.
    pub plan: &'a Plan,
    /// The files that they came from.
    pub files: &'a Files,
    /// What it is to do.
    pub scenario: &'a dyn Scenario,
    /// A folder of this run's own.
    pub folder: &'a Path,
    /// The robot heeds leave that is withheld. One that does not is a control: the judge must find it out.
    pub heeds_leave: bool,
}

/// How a run ended.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// Decides everything.
    pub seed: u64,
    /// It did what it should.
    pub done: bool,
    /// Nothing happened that must not.
    pub clean: bool,
    /// What it did not do, and why as far as it says.
    pub missing: String,
    /// What the judge found out.
    pub figures: Figures,
    /// What must not happen and did.
    pub violations: Vec<Violation>,
    /// Faults that the robot raised, how often.
    pub faults: Vec<(String, u64)>,
    /// Areas that leave was withheld for until the robot had waited.
    pub withheld: u64,
    /// Pictures and traces, when they were asked for.
    #[serde(skip)]
    pub trace: Option<Trace>,
}

/// What a run leaves to look at.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// True states, 50 a second.
    pub path: Vec<Truth>,
    /// Changes of the schedule.
    pub changes: Vec<Change>,
    /// What stood in the way at the end.
    pub obstacles: Vec<Shape>,
    /// One line for each look: time, truth, belief, command, as comma-separated values.
    pub table: String,
    /// One line for each look and each disc or box: time, number, place.
    pub others: String,
    /// What the robot reported.
    pub notes: Vec<String>,
}

impl Outcome {
    /// Done, and nothing wrong.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.done && self.clean
    }

    /// Why it failed, in a line.
    #[must_use]
    pub fn reason(&self) -> String {
        let mut reasons: Vec<String> = self
            .violations
            .iter()
            .take(3)
            .map(|violation| {
                format!(
                    "{} at {:.1} s: {}",
                    violation.kind, violation.at_s, violation.detail
                )
            })
            .collect();
        if !self.done {
            reasons.push(self.missing.clone());
        }
        reasons.join("; ")
    }
}

/// Runs one trial to its end.
///
/// # Errors
/// [`Failure::Refused`] when the robot or the world cannot be built.
pub fn run(setup: &Setup<'_>, seed: u64, traced: bool) -> Result<Outcome, Failure> {
    Run::new(setup, seed, traced)?.drive()
}

struct Run<'a> {
    setup: &'a Setup<'a>,
    seed: u64,
    world: World,
    robot: SteppedRobot,
    judge: Judge,
    leave: LeaveKeeper,
    granted: Vec<bool>,
    operator: Operator,
    faults: Vec<(Fault, u64)>,
    needs_operator: Option<(Fault, u64)>,
    trace: Option<Trace>,
}

impl<'a> Run<'a> {
    fn new(setup: &'a Setup<'a>, seed: u64, traced: bool) -> Result<Self, Failure> {
        let plan = setup.plan;
        let id = &plan.robot.identity.id;
        let start = drawn_start(start_pose(&plan.site, id)?, seed);
        let mut world = plain_world(&plan.site, &[(&plan.robot, start)], seed)?;
        setup
            .scenario
            .furnish(&mut world, seed)
            .map_err(Failure::refused)?;
        world.advance_to(START_NS);
        let mut robot = SteppedRobot::new(
            plan,
            setup.files,
            setup.folder,
            &world,
            0,
            setup.scenario.withholds_leave() && setup.heeds_leave,
            START_NS,
        )?;
        let judge = Judge::new(
            &plan.robot,
            &plan.site,
            &plan.fsm,
            setup.scenario.rules(),
            START_NS,
        );
        let leave = if setup.scenario.withholds_leave() {
            LeaveKeeper::random(&plan.site, judge.footprint(), &start, seed)
        } else {
            LeaveKeeper::generous(&plan.site)
        };
        let granted: Vec<bool> = leave.granted().collect();
        robot.allow(&granted);
        Ok(Self {
            setup,
            seed,
            world,
            robot,
            judge,
            leave,
            granted,
            operator: Operator::new(seed),
            faults: Vec::new(),
            needs_operator: None,
            trace: traced.then(Trace::default),
        })
    }

    fn drive(mut self) -> Result<Outcome, Failure> {
        let patience_ns = (self.setup.scenario.patience_s() * 1e9) as u64;
        let mut now_ns = START_NS;
        let mut done = false;
        while !done && now_ns < START_NS + patience_ns && !self.is_stranded(now_ns) {
            self.robot.step(&mut self.world, now_ns);
            if (now_ns - START_NS).is_multiple_of(LOOK_NS) {
                done = self.look(now_ns);
            }
            now_ns += MILLISECOND_NS;
        }
        Ok(self.outcome(done))
    }

    /// A fault lasts that only an operator ends; nobody does so in a trial.
    fn is_stranded(&self, now_ns: u64) -> bool {
        self.needs_operator
            .is_some_and(|(_, since_ns)| now_ns > since_ns + STRANDED_NS)
    }

    /// One look of judge, operator and keeper of leave; true when the trial is done.
    fn look(&mut self, now_ns: u64) -> bool {
        let Some(truth) = self.world.truth(0) else {
            return false;
        };
        self.hear();
        let belief = self.robot.belief();
        let look = Look {
            world: &self.world,
            robot: 0,
            truth: &truth,
            belief: &belief,
            granted: &self.granted,
        };
        self.judge.observe(&look);
        let (site, fsm) = (&self.setup.plan.site, &self.setup.plan.fsm);
        let instruction = self.operator.look(site, fsm, &belief.state, &truth);
        if let Some(instruction) = instruction {
            if let Some(pose) = instruction.stop_at {
                self.judge.instructed(pose);
            }
            if !self.robot.instruct(&instruction) {
                let detail = format!("the robot's machine does not know `{}`", instruction.event);
                self.judge.report("instruction", now_ns, detail);
            }
        }
        let speed_m_s = truth.twist.v_m_s;
        let footprint = *self.judge.footprint();
        if self
            .leave
            .look(site, &footprint, &truth.pose, speed_m_s, now_ns)
        {
            self.granted = self.leave.granted().collect();
            self.robot.allow(&self.granted);
        }
        if let Some(trace) = &mut self.trace {
            trace.add(&truth, &belief);
            trace.add_others(now_ns, self.world.obstacles().map(|(_, shape)| shape));
        }
        let figures = self.judge.figures();
        self.setup.scenario.is_done(site, fsm, figures, &truth)
    }

    /// Takes in what the activities reported.
    fn hear(&mut self) {
        for (at_ns, note) in self.robot.take_notes() {
            if let Note::Raised(fault, _) = &note {
                match self.faults.iter_mut().find(|(other, _)| other == fault) {
                    Some((_, count)) => *count += 1,
                    None => self.faults.push((*fault, 1)),
                }
                if fault.resumes() == Resumes::Operator {
                    self.needs_operator.get_or_insert((*fault, at_ns));
                }
            }
            if let Note::Cleared(fault) = &note {
                self.needs_operator.take_if(|(other, _)| other == fault);
            }
            if let Some(trace) = &mut self.trace {
                let at_s = (at_ns - START_NS) as f64 / 1e9;
                trace.notes.push(format!("{at_s:8.2} s  {note:?}"));
            }
        }
    }

    fn outcome(mut self, done: bool) -> Outcome {
        let lost = self.robot.lost_commands();
        if lost > 0 {
            let detail = format!("{lost} commands found a full queue");
            let at_ns = self.world.now_ns();
            self.judge.report("command-lost", at_ns, detail);
        }
        let plan = self.setup.plan;
        let figures = self.judge.figures().clone();
        let missing = if done {
            String::new()
        } else {
            let what = self.setup.scenario.missing(&plan.site, &plan.fsm, &figures);
            let why = self.needs_operator.map_or_else(String::new, |(fault, _)| {
                format!("; fault {}", fault.name())
            });
            format!("{what}{why}, after {:.0} s", figures.duration_s)
        };
        if let Some(trace) = &mut self.trace {
            trace.obstacles = self
                .world
                .obstacles()
                .map(|(_, shape)| shape)
                .filter(|shape| !matches!(shape, Shape::Wall(_)))
                .collect();
        }
        let violations = self.judge.violations().to_vec();
        Outcome {
            seed: self.seed,
            done,
            clean: violations.is_empty(),
            missing,
            figures,
            violations,
            faults: self
                .faults
                .iter()
                .map(|(fault, count)| (fault.name().to_owned(), *count))
                .collect(),
            withheld: self.leave.withheld(),
            trace: self.trace,
        }
    }
}

impl Trace {
    fn add_others(&mut self, now_ns: u64, shapes: impl Iterator<Item = Shape>) {
        use std::fmt::Write;
        if self.others.is_empty() {
            self.others.push_str("t_s,number,x_m,y_m\n");
        }
        let at_s = (now_ns - START_NS) as f64 / 1e9;
        for (number, shape) in shapes.enumerate() {
            let [x_m, y_m] = match shape {
                Shape::Wall(_) => continue,
                Shape::Disc { centre_m, .. } => centre_m,
                Shape::Box { pose, .. } => [pose.x_m, pose.y_m],
            };
            // Writing to a string cannot fail.
            let _ = writeln!(self.others, "{at_s:.2},{number},{x_m:.3},{y_m:.3}");
        }
    }

    fn add(&mut self, truth: &Truth, belief: &crate::belief::Belief) {
        use std::fmt::Write;
        if self.table.is_empty() {
            self.table.push_str(
                "t_s,x_m,y_m,theta_rad,v_m_s,omega_rad_s,clearance_m,\
                 believed_x_m,believed_y_m,believed_theta_rad,std_x_m,std_y_m,std_theta_rad,\
                 state,skill,verdict,reason\n",
            );
        }
        let (p, b) = (&truth.pose, &belief.pose);
        // Writing to a string cannot fail.
        let _ = writeln!(
            self.table,
            "{:.3},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{},{},{},{}",
            (truth.time_ns - START_NS) as f64 / 1e9,
            p.x_m,
            p.y_m,
            p.theta_rad,
            truth.twist.v_m_s,
            truth.twist.omega_rad_s,
            truth.clearance_m,
            b.x_m,
            b.y_m,
            b.theta_rad,
            belief.std[0],
            belief.std[1],
            belief.std[2],
            belief.state,
            belief.skill,
            belief.verdict,
            belief.reason
        );
        let changed = self
            .changes
            .last()
            .is_none_or(|last| last.fsm_state != belief.state || last.skill != belief.skill);
        if changed && !belief.skill.is_empty() {
            self.changes.push(Change {
                robot_id: String::new(),
                fsm_state: belief.state.clone(),
                area: belief.area.clone(),
                skill: belief.skill.clone(),
                x_m: b.x_m,
                y_m: b.y_m,
            });
        }
        self.path.push(*truth);
    }
}
