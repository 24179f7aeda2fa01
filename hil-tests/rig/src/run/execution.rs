//! A way to run the robots of a scenario: the seam between what is run and how.
//!
//! Scenario, judge, record, summary and report know only this. Two ways exist: [`Stage`](super::stage::Stage) starts the real
//! programs in real time, [`Stepped`](crate::stepped::Stepped) steps everything on a simulated clock.

use description::instruction::Instruction;
use onboard::cli::Failure;
use sim::world::{Shape, Truth, TruthRecord, World};

use crate::belief::Belief;
use crate::judge::Waiting;
use crate::network::mediator_status::Told;
use crate::network::observations::Observations;
use crate::stalls::StallWatch;
use crate::summary::{MediatorSummary, RobotSummary};
use crate::violation::ViolationKind;

use super::ending::Ending;

/// Time from one look to the next.
pub const LOOK_NS: u64 = 20_000_000;

/// A violation found by the execution itself, not by the judge: kind, robot and a sentence.
pub type Found = (ViolationKind, String, String);

/// The mediator's processes, for summary and record.
#[derive(Clone, Debug, Default)]
pub struct MediatorRuns {
    /// Figures of all of them.
    pub summary: MediatorSummary,
    /// When each began and ended.
    pub spans_ns: Vec<(u64, Option<u64>)>,
}

/// Robots, their world, and whoever coordinates them. Robots have the numbers that they have in the scenario; times are
/// nanoseconds of one monotonic clock, which may be simulated.
pub trait Execution {
    /// When the run began.
    fn start_ns(&self) -> u64;

    /// What time it is.
    fn now_ns(&self) -> u64;

    /// Lets time pass until the next look.
    ///
    /// # Errors
    /// [`Failure::Failed`] when a robot cannot be started.
    fn pass_time(&mut self) -> Result<(), Failure>;

    /// Why it cannot go on, if so.
    fn ended(&mut self) -> Option<Ending>;

    /// What was true since the last call, in order of time. Clones of robots have the numbers of their bodies, after the robots'.
    fn truths(&mut self) -> Vec<TruthRecord>;

    /// What a robot believes; none before it runs.
    fn belief(&mut self, robot: usize) -> Option<Belief>;

    /// Whether a robot waits for its operator, and for what; none: its process does not run, or it is not asked of this way to run.
    fn latch(&self, _robot: usize) -> Option<Waiting> {
        None
    }

    /// Shows the world, and what was heard on the network until now.
    fn show<R>(&self, to: impl FnOnce(&World, &Observations) -> R) -> R;

    /// Shows what was heard on the network until now.
    fn heard<R>(&self, to: impl FnOnce(&Observations) -> R) -> R;

    /// Shows what the mediator told its operators; none without a mediator.
    fn told<R>(&self, to: impl FnOnce(Option<&Told>) -> R) -> R;

    /// Whether grants of areas are heard, so that they can be judged.
    fn hears_grants(&self) -> bool;

    /// Gives a robot's machine an event, as an operator does.
    ///
    /// # Errors
    /// A sentence with the robot's reason.
    fn instruct(&mut self, robot: usize, instruction: &Instruction<String>) -> Result<(), String>;

    /// Gives a robot leave for these areas, in the site's order, where the rig stands in for the mediator. False where it
    /// does not: then the mediator grants them.
    fn give_leave(&mut self, robot: usize, areas: &[bool]) -> bool;

    /// Ends robots and mediator, and returns what is wrong with how they ended and with what devices have recorded.
    fn stop(&mut self) -> Vec<Found>;

    /// A robot's figures, from the truth and from what its devices and the robot itself measured.
    fn robot_summary(&self, robot: usize, truth: Option<&Truth>) -> RobotSummary;

    /// The mediator's processes; none without a mediator.
    fn mediator(&self) -> Option<MediatorRuns>;

    /// Who saw how the machine stalled; none on a simulated clock.
    fn stall_watch(&self) -> Option<&StallWatch> {
        None
    }

    /// Obstacles and walkers that the site file does not know, where they are now.
    fn obstacles(&self) -> Vec<Shape> {
        self.show(|world, _| {
            { world.obstacles() }
                .map(|(_, shape)| shape)
                .filter(|shape| !matches!(shape, Shape::Wall(_)))
                .collect()
        })
    }

    /// Seconds since the start.
    fn seconds(&self, at_ns: u64) -> f64 {
        at_ns.saturating_sub(self.start_ns()) as f64 / 1e9
    }
}
