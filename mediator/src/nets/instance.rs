//! One run of a plan with certain robots.

use std::collections::VecDeque;
use std::sync::Arc;

use super::participant::Participant;
use super::plan::{Kind, Plan, Script};
use coordination::binding::NetBinding;
use coordination::petri::{Budget, TransitionId};
use coordination::protocol::{Position, Side};

/// The last firings are remembered.
const REMEMBERED: usize = 256;
/// How much one step does; what is left waits for the next.
const ROUNDS: usize = 16;
const FIRINGS: usize = 32;

/// A transition fired.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Firing {
    pub(crate) transition: String,
    pub(crate) at_ns: u64,
}

/// What an instance is at.
#[derive(Clone, Debug)]
pub(crate) enum Phase {
    /// The net runs, since this situation.
    Running {
        situation: usize,
        /// Its sides are by role.
        net: Box<NetBinding<Participant>>,
    },
    /// All robots, by role, are told to get out of the way.
    Yielding(Vec<Participant>),
}

#[derive(Clone, Debug)]
pub(crate) struct Instance {
    pub(crate) number: u64,
    pub(crate) plan: Arc<Plan>,
    pub(crate) phase: Phase,
    pub(crate) since_ns: u64,
    /// When a flag was last set or read.
    pub(crate) progress_ns: u64,
    pub(crate) alarmed: bool,
    pub(crate) firings: VecDeque<Firing>,
    pub(crate) fired: u64,
}

/// What a step did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Stepped {
    /// There is something to store and to tell.
    pub(crate) changed: bool,
    /// There is more to do.
    pub(crate) remaining: bool,
}

impl Instance {
    /// Starts the net in a situation, with a robot for each role.
    pub(crate) fn start(
        plan: &Arc<Plan>,
        number: u64,
        situation: usize,
        robots: &[usize],
        now_ns: u64,
    ) -> Self {
        let participants = robots.iter().zip(&plan.roles).map(|(&robot, role)| {
            let derived = matches!(role.kind, Kind::Access(_));
            Participant::new(robot, &role.script, derived)
        });
        let own = &plan.situations[situation];
        let names = plan.roles.iter().map(|role| role.name.as_str());
        let net = NetBinding::new(&own.proof, &own.net, names.zip(participants))
            .expect("the plan was made with a trial of just this");
        Self::new(
            plan,
            number,
            Phase::Running {
                situation,
                net: Box::new(net),
            },
            now_ns,
        )
    }

    /// Tells its robots to get out of the way; not those that have their discrete control back.
    pub(crate) fn yielding(&self, number: u64, now_ns: u64) -> Self {
        let plan = &self.plan;
        let participants = { self.participants().iter().enumerate() }.map(|(role, before)| {
            let script = yield_script(plan, role);
            if before.is_over() {
                Participant::released(before.robot, script)
            } else {
                Participant::new(before.robot, script, false)
            }
        });
        Self::new(
            plan,
            number,
            Phase::Yielding(participants.collect()),
            now_ns,
        )
    }

    pub(super) fn new(plan: &Arc<Plan>, number: u64, phase: Phase, now_ns: u64) -> Self {
        Self {
            number,
            plan: Arc::clone(plan),
            phase,
            since_ns: now_ns,
            progress_ns: now_ns,
            alarmed: false,
            firings: VecDeque::new(),
            fired: 0,
        }
    }

    /// By role.
    pub(crate) fn participants(&self) -> &[Participant] {
        match &self.phase {
            Phase::Running { net, .. } => net.sides(),
            Phase::Yielding(participants) => participants,
        }
    }

    /// By role.
    pub(crate) fn participants_mut(&mut self) -> &mut [Participant] {
        match &mut self.phase {
            Phase::Running { net, .. } => net.sides_mut(),
            Phase::Yielding(participants) => participants,
        }
    }

    /// The protocol with the robot of a role, in the present phase.
    pub(crate) fn script(&self, role: usize) -> &Script {
        match &self.phase {
            Phase::Running { .. } => &self.plan.roles[role].script,
            Phase::Yielding(_) => yield_script(&self.plan, role),
        }
    }

    pub(crate) fn robots(&self) -> Vec<usize> {
        self.participants()
            .iter()
            .map(|participant| participant.robot)
            .collect()
    }

    /// The role that the robot has in it.
    pub(crate) fn role_of(&self, robot: usize) -> Option<usize> {
        { self.participants().iter() }.position(|participant| participant.robot == robot)
    }

    /// The robot's control is, or is about to be, with this instance.
    pub(crate) fn controls(&self, robot: usize) -> Option<usize> {
        let role = self.role_of(robot)?;
        let is_control = matches!(self.plan.roles[role].kind, Kind::Control);
        (is_control && !self.participants()[role].is_over()).then_some(role)
    }

    /// Every robot has its discrete control back.
    pub(crate) fn is_over(&self) -> bool {
        let mut participants = self.participants().iter().zip(&self.plan.roles);
        self.plan.controls()
            && participants.all(|(participant, role)| {
                matches!(role.kind, Kind::Access(_)) || participant.is_over()
            })
    }

    /// Nobody is in the middle of a run: there is nothing that could stand still.
    pub(crate) fn is_idle(&self) -> bool {
        !self.plan.controls() && { self.participants().iter() }
            .all(|participant| participant.read_to() == Position::START)
    }

    /// The names of the marked places.
    pub(crate) fn marking(&self) -> Vec<String> {
        match &self.phase {
            Phase::Running { net, .. } => { net.executor() }
                .marking()
                .map(|place| net.executor().net().place_name(place).to_owned())
                .collect(),
            Phase::Yielding(_) => Vec::new(),
        }
    }

    // ---------------------------------------------------------------- running

    /// Reads what robots have set, fires what is enabled, and sets the flags of full sinks.
    pub(crate) fn step(&mut self, now_ns: u64) -> Stepped {
        let mut stepped = Stepped::default();
        for round in 0..=ROUNDS {
            let before = stepped.changed;
            stepped.changed = false;
            match self.phase {
                Phase::Running { .. } => self.step_net(now_ns, &mut stepped),
                Phase::Yielding(_) => self.step_yielding(&mut stepped),
            }
            let went_on = stepped.changed;
            stepped.changed |= before;
            stepped.remaining = went_on;
            if !went_on || round == ROUNDS {
                break;
            }
        }
        stepped
    }

    fn step_net(&mut self, now_ns: u64, stepped: &mut Stepped) {
        let Phase::Running { net, .. } = &mut self.phase else {
            return;
        };
        let mut trace = [TransitionId::default(); FIRINGS];
        let budget = Budget {
            firings: FIRINGS as u32,
            rounds: 4,
        };
        // All sinks are flags.
        let progress = net.step_traced(budget, &mut trace, |_| false);
        let fired = progress.evaluation.fired;
        for &transition in &trace[..fired as usize] {
            if self.firings.len() == REMEMBERED {
                self.firings.pop_front();
            }
            let net = net.executor().net();
            self.firings.push_back(Firing {
                transition: net.transition_name(transition).to_owned(),
                at_ns: now_ns,
            });
        }
        self.fired += u64::from(fired);
        let flags = progress.read + progress.set;
        if flags > 0 {
            self.progress_ns = now_ns;
            self.alarmed = false;
        }
        stepped.changed |= flags > 0 || fired > 0;
    }
}

/// How the robot of a role is told to get out of the way.
fn yield_script(plan: &Plan, role: usize) -> &Script {
    let own = plan.preempt.as_ref();
    own.map_or(&plan.roles[role].script, |preempt| {
        &preempt.yields[role].script
    })
}
