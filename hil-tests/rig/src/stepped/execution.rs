//! The robots of a scenario in one process on a simulated clock.

use description::instruction::Instruction;
use onboard::cli::{Failure, Files};
use onboard::composition::plan::Plan;
use onboard::symbols::faults::{Fault, Resumes};
use sim::world::{Truth, TruthRecord, World};

use super::clock::{START_NS, STEP_NS};
use super::robot::SteppedRobot;
use super::supervisor::Note;
use super::trace::Trace;
use crate::belief::Belief;
use crate::folder::Folder;
use crate::machine::round;
use crate::network::mediator_status::Told;
use crate::network::observations::Observations;
use crate::run::{Ending, Execution, Found, LOOK_NS, MediatorRuns};
use crate::scenario::{Player, Scenario};
use crate::stand_ins::clutter::furnish;
use crate::summary::RobotSummary;
use crate::testbed::{drawn_starts, plain_world};

/// A fault that only an operator can clear ends the run after this time.
const STRANDED_NS: u64 = 30_000_000_000;

/// What is common to all runs of a scenario: each robot's plan, in the order of the scenario.
pub struct Plans(Vec<(Files, Plan)>);

impl Plans {
    /// Makes the plans of a scenario.
    ///
    /// # Errors
    /// [`Failure::Refused`] when a plan cannot be made, or the scenario needs a mediator, which does not run here yet.
    pub fn of(scenario: &Scenario) -> Result<Self, Failure> {
        if scenario.site.areas_managed && !scenario.withholds_areas {
            return Err(Failure::refused(format_args!(
                "scenario `{}` needs a mediator, which does not run on the simulated clock",
                scenario.name
            )));
        }
        let plan = |player: &Player| {
            let files = Files {
                robot: player.file.clone(),
                site: scenario.site_file.clone(),
                set: scenario.set_of(player),
            };
            Ok((files.clone(), Plan::load(&files)?))
        };
        { scenario.robots.iter() }
            .map(plan)
            .collect::<Result<_, _>>()
            .map(Self)
    }
}

/// Robots on the simulated clock.
pub struct Stepped {
    /// Their world.
    pub world: World,
    robots: Vec<Robot>,
    withholds_areas: bool,
    /// Nothing is heard: there is no network.
    observations: Observations,
    next_ns: u64,
    /// Time has passed since the last look.
    fresh: bool,
    /// Traces of the first robot, when they are wanted.
    trace: Option<Trace>,
    _folder: Folder,
}

struct Robot {
    id: String,
    robot: SteppedRobot,
    /// How often each fault was raised.
    faults: Vec<(Fault, u64)>,
    /// A fault that only an operator can clear, and since when.
    needs_operator: Option<(Fault, u64)>,
}

impl Stepped {
    /// Builds world and robots. Robots that do not heed leave are a control: the judge must find their violations. Only the
    /// first robot is traced.
    ///
    /// # Errors
    /// [`Failure::Refused`] when a robot or the world cannot be built.
    pub fn new(
        scenario: &Scenario,
        plans: &Plans,
        seed: u64,
        heeds_leave: bool,
        traced: bool,
    ) -> Result<Self, Failure> {
        let mut world = plain_world(&scenario.site, &drawn_starts(scenario, seed), seed)?;
        if let Some(clutter) = &scenario.clutter {
            furnish(&mut world, clutter, seed).map_err(Failure::refused)?;
        }
        world.advance_to(START_NS);
        let folder = Folder::new()?;
        let takes_leave = scenario.withholds_areas && heeds_leave;
        let robots = { plans.0.iter().enumerate() }
            .map(|(number, (files, plan))| {
                let path = folder.path();
                Ok(Robot {
                    id: plan.robot.identity.id.clone(),
                    robot: SteppedRobot::new(
                        plan,
                        files,
                        path,
                        &world,
                        number,
                        takes_leave,
                        START_NS,
                    )?,
                    faults: Vec::new(),
                    needs_operator: None,
                })
            })
            .collect::<Result<_, Failure>>()?;
        Ok(Self {
            world,
            robots,
            withholds_areas: scenario.withholds_areas,
            observations: Observations::new(&scenario.site, &scenario.nets),
            next_ns: START_NS,
            fresh: false,
            trace: traced.then(Trace::default),
            _folder: folder,
        })
    }

    /// Traces, when they were wanted.
    pub fn take_trace(&mut self) -> Option<Trace> {
        self.trace.take()
    }

    /// Takes in what the activities reported, and records traces.
    fn hear(&mut self) {
        let now_ns = self.now_ns();
        for (number, robot) in self.robots.iter_mut().enumerate() {
            let trace = &mut self.trace;
            let mut trace = trace.as_mut().filter(|_| number == 0);
            for (at_ns, note) in robot.robot.take_notes() {
                if let Some(trace) = &mut trace {
                    trace.note(at_ns, &note);
                }
                robot.take(at_ns, &note);
            }
            if let Some(trace) = trace
                && let Some(truth) = self.world.truth(number)
            {
                trace.add(&truth, &robot.robot.belief());
                trace.add_others(now_ns, self.world.obstacles().map(|(_, shape)| shape));
            }
        }
    }
}

impl Robot {
    fn take(&mut self, at_ns: u64, note: &Note) {
        match note {
            Note::Raised(fault, _) => {
                match self.faults.iter_mut().find(|(other, _)| other == fault) {
                    Some((_, count)) => *count += 1,
                    None => self.faults.push((*fault, 1)),
                }
                if fault.resumes() == Resumes::Operator {
                    self.needs_operator.get_or_insert((*fault, at_ns));
                }
            }
            Note::Cleared(fault) => {
                self.needs_operator.take_if(|(other, _)| other == fault);
            }
            _ => {}
        }
    }
}

impl Execution for Stepped {
    fn start_ns(&self) -> u64 {
        START_NS
    }

    fn now_ns(&self) -> u64 {
        self.next_ns.saturating_sub(STEP_NS).max(START_NS)
    }

    fn pass_time(&mut self) -> Result<(), Failure> {
        // The first look is at the very beginning.
        let steps = if self.next_ns == START_NS {
            1
        } else {
            LOOK_NS / STEP_NS
        };
        for _ in 0..steps {
            for robot in &mut self.robots {
                robot.robot.step(&mut self.world, self.next_ns);
            }
            self.next_ns += STEP_NS;
        }
        self.fresh = true;
        self.hear();
        Ok(())
    }

    fn ended(&mut self) -> Option<Ending> {
        // A look that would come later than that is not waited for.
        let next_look_ns = self.now_ns() + LOOK_NS;
        let stranded = { self.robots.iter() }
            .filter_map(|robot| robot.needs_operator)
            .find(|(_, since_ns)| next_look_ns > since_ns + STRANDED_NS);
        stranded.map(|(fault, _)| Ending::Stranded(fault.name()))
    }

    fn truths(&mut self) -> Vec<TruthRecord> {
        if !std::mem::take(&mut self.fresh) {
            return Vec::new();
        }
        let sequence = (self.now_ns() - START_NS) / LOOK_NS;
        { 0..self.robots.len() }
            .filter_map(|robot| {
                Some(TruthRecord {
                    sequence,
                    robot,
                    truth: self.world.truth(robot)?,
                })
            })
            .collect()
    }

    fn belief(&mut self, robot: usize) -> Option<Belief> {
        self.robots.get_mut(robot).map(|robot| robot.robot.belief())
    }

    fn show<R>(&self, to: impl FnOnce(&World, &Observations) -> R) -> R {
        to(&self.world, &self.observations)
    }

    fn heard<R>(&self, to: impl FnOnce(&Observations) -> R) -> R {
        to(&self.observations)
    }

    fn told<R>(&self, to: impl FnOnce(Option<&Told>) -> R) -> R {
        to(None)
    }

    fn hears_grants(&self) -> bool {
        false
    }

    fn instruct(&mut self, robot: usize, instruction: &Instruction<String>) -> Result<(), String> {
        let known =
            { self.robots.get_mut(robot) }.is_some_and(|robot| robot.robot.instruct(instruction));
        if known {
            Ok(())
        } else {
            Err(format!(
                "the robot's machine does not know `{}`",
                instruction.event
            ))
        }
    }

    fn give_leave(&mut self, robot: usize, areas: &[bool]) -> bool {
        if let Some(robot) = self.robots.get_mut(robot)
            && self.withholds_areas
        {
            robot.robot.allow(areas);
        }
        self.withholds_areas
    }

    fn stop(&mut self) -> Vec<Found> {
        let lost = { self.robots.iter() }.filter(|robot| robot.robot.lost_commands() > 0);
        lost.map(|robot| {
            let detail = format!(
                "{} commands found a full queue",
                robot.robot.lost_commands()
            );
            ("command-lost", robot.id.clone(), detail)
        })
        .collect()
    }

    fn robot_summary(&self, robot: usize, truth: Option<&Truth>) -> RobotSummary {
        let truth = truth.copied().unwrap_or_default();
        let own = &self.robots[robot];
        RobotSummary {
            id: own.id.clone(),
            distance_m: round(truth.distance_m),
            collisions: truth.collisions,
            min_clearance_m: round(truth.min_clearance_m),
            faults: { own.faults.iter() }
                .map(|(fault, count)| (fault.name().to_owned(), *count))
                .collect(),
            ..RobotSummary::default()
        }
    }

    fn mediator(&self) -> Option<MediatorRuns> {
        None
    }
}
