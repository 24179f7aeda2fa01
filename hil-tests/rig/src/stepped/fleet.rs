//! The robots of a scenario, their mediator and the network between them, stepped together.

use contract::wire::{MediatorReport, RobotReport, RobotState};
use contract::{Message as _, decode, keys};
use onboard::cli::Failure;
use onboard::symbols::faults::FaultTable;
use sim::world::{Random, World};

use super::clock::{START_NS, STEP_NS};
use super::mediator::SteppedMediator;
use super::network::{Message, MessageKind, Network};
use super::plans::Plans;
use super::robot::{Fleet, Start, SteppedRobot};
use super::trace::Trace;
use crate::folder::Folder;
use crate::network::mediator_status::Told;
use crate::network::observations::Observations;
use crate::run::LOOK_NS;
use crate::scenario::Scenario;
use crate::stand_ins::clutter::furnish;
use crate::testbed::{drawn_starts, plain_world, start_delays_ns};

/// First part of every key.
const PREFIX: &str = "stepped";
/// Boot epochs come from the seed.
const EPOCH_STREAM: u64 = 0x4550_4F43;

/// Robots on the simulated clock.
pub struct Stepped<'a> {
    /// Their world.
    pub world: World,
    pub(super) plans: &'a Plans,
    pub(super) robots: Vec<Member>,
    pub(super) mediator: Option<SteppedMediator>,
    network: Network,
    pub(super) told: Told,
    pub(super) leave: Leave,
    /// What the listener has heard.
    pub(super) observations: Observations,
    epochs: Random,
    next_ns: u64,
    /// Nobody has looked since time passed.
    pub(super) fresh: bool,
    /// Of the first robot, when they are wanted.
    trace: Option<Trace>,
    folder: Folder,
}

/// Who gives robots leave for areas.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Leave {
    /// The mediator, where there is one.
    OfMediator,
    /// The rig.
    Withheld,
    /// The rig, and robots do not listen.
    Ignored,
}

pub(super) struct Member {
    pub(super) id: String,
    starts_ns: u64,
    /// None before it starts.
    pub(super) robot: Option<SteppedRobot>,
    pub(super) faults: FaultTable,
    /// The areas that the rig has given it leave for.
    pub(super) allowed: Vec<bool>,
}

impl<'a> Stepped<'a> {
    /// Builds the world, and starts the mediator where there is one; robots follow as their times come. Robots that do not
    /// heed leave are a control: the judge must find them out. Traces are of the first robot.
    ///
    /// # Errors
    /// [`Failure::Refused`] when mediator or world cannot be built.
    pub fn new(
        scenario: &Scenario,
        plans: &'a Plans,
        seed: u64,
        heeds_leave: bool,
        traced: bool,
    ) -> Result<Self, Failure> {
        let mut world = plain_world(&scenario.site, &drawn_starts(scenario, seed), seed)?;
        if let Some(clutter) = &scenario.clutter {
            furnish(&mut world, clutter, seed).map_err(Failure::refused)?;
        }
        world.advance_to(START_NS);
        let mediator = { plans.mediator.as_ref() }
            .map(|plan| SteppedMediator::start(plan, START_NS))
            .transpose()?;
        let robots = { plans.robots.iter().zip(start_delays_ns(scenario, seed)) }
            .map(|((_, plan), delay_ns)| Member {
                id: plan.robot.identity.id.clone(),
                starts_ns: START_NS + delay_ns,
                robot: None,
                faults: FaultTable::default(),
                allowed: Vec::new(),
            })
            .collect();
        Ok(Self {
            world,
            plans,
            robots,
            mediator,
            network: Network::new(seed),
            told: Told::default(),
            leave: match scenario.withholds_areas {
                true if heeds_leave => Leave::Withheld,
                true => Leave::Ignored,
                false => Leave::OfMediator,
            },
            observations: Observations::new(&scenario.site, &scenario.nets),
            epochs: Random::new(seed, EPOCH_STREAM),
            next_ns: START_NS,
            fresh: false,
            trace: traced.then(Trace::default),
            folder: Folder::new()?,
        })
    }

    /// What time it is.
    pub(super) fn now_ns(&self) -> u64 {
        self.next_ns.saturating_sub(STEP_NS).max(START_NS)
    }

    /// Lets time pass until the next look: the first is at the very beginning.
    pub(super) fn advance(&mut self) -> Result<(), Failure> {
        let steps = if self.next_ns == START_NS {
            1
        } else {
            LOOK_NS / STEP_NS
        };
        for _ in 0..steps {
            self.step(self.next_ns)?;
            self.next_ns += STEP_NS;
        }
        self.fresh = true;
        self.hear();
        Ok(())
    }

    /// Traces, when they were wanted.
    pub fn take_trace(&mut self) -> Option<Trace> {
        self.trace.take()
    }

    fn start(&mut self, number: usize, now_ns: u64) -> Result<(), Failure> {
        let (files, plan) = &self.plans.robots[number];
        let fleet = match self.leave {
            Leave::Withheld => Fleet::Rig,
            Leave::Ignored => Fleet::Alone,
            Leave::OfMediator => Fleet::Network(self.network.session_of(number)),
        };
        let start = Start {
            fleet,
            boot_epoch: (self.epochs.unit() * (u64::MAX >> 16) as f64) as u64 + 1,
            at_ns: now_ns,
        };
        let folder = self.folder.path();
        let mut robot = SteppedRobot::new(plan, files, folder, &self.world, number, start)?;
        let member = &mut self.robots[number];
        robot.allow(&member.allowed);
        member.robot = Some(robot);
        Ok(())
    }

    /// One step of everything: messages arrive, the mediator goes on, robots go on.
    fn step(&mut self, now_ns: u64) -> Result<(), Failure> {
        for number in 0..self.robots.len() {
            let member = &self.robots[number];
            if member.robot.is_none() && now_ns >= member.starts_ns {
                self.start(number, now_ns)?;
            }
        }
        self.world.advance_to(now_ns);
        while let Some(message) = self.network.arrived(now_ns) {
            self.deliver(&message, now_ns);
        }
        if let Some(mediator) = &mut self.mediator {
            let mut answers = Vec::new();
            mediator.cycle(now_ns, |answer| answers.push(answer))?;
            if let Some(status) = mediator.take_status() {
                self.told.take(status, now_ns);
            }
            for answer in answers {
                self.send(&answer, now_ns);
            }
        }
        for member in &mut self.robots {
            if let Some(robot) = &mut member.robot {
                robot.step(&mut self.world, now_ns);
            }
        }
        self.network.collect(now_ns);
        Ok(())
    }

    fn send(&mut self, answer: &MediatorReport, now_ns: u64) {
        let robot = { self.robots.iter() }.position(|member| member.id == answer.robot_id);
        if let Some(robot) = robot {
            let message = Message {
                robot,
                kind: MessageKind::Answer,
                bytes: answer.encode_to_vec(),
            };
            self.network.send(message, now_ns);
        }
    }

    /// A message is there: for the mediator, and for the listener.
    fn deliver(&mut self, message: &Message, now_ns: u64) {
        let (bytes, observations) = (&message.bytes[..], &mut self.observations);
        let understood = match message.kind {
            MessageKind::State => decode::<RobotState>(bytes)
                .map(|state| observations.state(state, now_ns))
                .is_ok(),
            MessageKind::Report => {
                if let Some(mediator) = &mut self.mediator {
                    // The loader has checked both names.
                    let key = keys::report(PREFIX, &self.robots[message.robot].id);
                    mediator.deliver(&key.unwrap_or_default(), bytes);
                }
                decode::<RobotReport>(bytes)
                    .map(|report| observations.report(&report, now_ns))
                    .is_ok()
            }
            MessageKind::Answer => decode::<MediatorReport>(bytes)
                .map(|answer| observations.answer(&answer, now_ns))
                .is_ok(),
        };
        if !understood {
            observations.malformed();
        }
    }

    /// Takes in what the robots say of themselves, and traces.
    fn hear(&mut self) {
        let now_ns = self.now_ns();
        for (number, member) in self.robots.iter_mut().enumerate() {
            let Some(robot) = &mut member.robot else {
                continue;
            };
            let faults = robot.faults();
            let trace = &mut self.trace;
            if let Some(trace) = trace.as_mut().filter(|_| number == 0)
                && let Some(truth) = self.world.truth(number)
            {
                let belief = robot.belief();
                trace.note(now_ns, &belief, &member.faults, &faults);
                trace.add(&truth, &belief);
                trace.add_others(now_ns, self.world.obstacles().map(|(_, shape)| shape));
            }
            member.faults = faults;
        }
    }
}
