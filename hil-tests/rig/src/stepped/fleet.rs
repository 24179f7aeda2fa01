//! The robots of a scenario, their mediator and the network between them, stepped together.

use contract::wire::{MediatorReport, RobotReport, RobotState};
use contract::{decode, keys};
use onboard::cli::Failure;
use onboard::process::ctl::Request;
use onboard::symbols::faults::{Fault, FaultTable};
use serde_json::Value as Json;
use sim::world::{ObstacleId, Random, SharedWorld};

use super::checkpoints::Checkpoints;
use super::clock::{START_NS, STEP_NS, drawn_ahead_ns};
use super::clones::ClonedRobot;
use super::devices::Devices;
use super::disk::Disk;
use super::driving_out::DrivingOut;
use super::faults::Schedule;
use super::mediator::{Ending, SteppedMediator};
use super::member::Member;
use super::message::{Message, MessageKind};
use super::motors_off::MotorsOff;
use super::network::Network;
use super::plans::Plans;
use super::reloading::Reloading;
use super::restarting::Restarting;
use super::robot::SteppedRobot;
use super::sending_on::SendingOn;
use super::start::{Fleet, Start};
use super::trace::Traces;
use crate::folder::Folder;
use crate::network::mediator_status::Told;
use crate::network::observations::Observations;
use crate::run::LOOK_NS;
use crate::scenario::{Scenario, ScriptedKind};
use crate::stand_ins::caretaker::Caretaker;
use crate::stand_ins::clutter::furnish;
use crate::testbed::{drawn_starts, plain_world, start_delays_ns};

/// First part of every key.
const PREFIX: &str = "stepped";
/// Boot epochs come from the seed.
const EPOCH_STREAM: u64 = 0x4550_4F43;
/// And for how long each robot's computer has run already.
const CLOCK_STREAM: u64 = 0x434C_4F43;
/// Robots on the simulated clock.
pub struct Stepped<'a> {
    /// Their world.
    pub world: SharedWorld,
    pub(super) plans: &'a Plans,
    pub(super) robots: Vec<Member>,
    /// Second robots of one identity, which should not be there.
    pub(super) clones: Vec<ClonedRobot>,
    pub(super) mediator: Option<SteppedMediator>,
    /// When each start of the mediator began and ended.
    pub(super) mediator_spans_ns: Vec<(u64, Option<u64>)>,
    /// What found no room at mediators that have ended.
    pub(super) dropped: u64,
    pub(super) disk: Disk,
    /// The journal's disk, as it was copied last.
    pub(super) journal_copy: Disk,
    /// Another mediator, which should not be there.
    pub(super) second_mediator: Option<SteppedMediator>,
    /// How its process is about to end, if it is.
    pub(super) ending: Option<Ending>,
    pub(super) faults: Schedule,
    /// A latch that nobody is to end, and since when.
    pub(super) stranded: Option<(Fault, u64)>,
    /// Processes that have panicked by themselves, each with its robot.
    pub(super) panicked: Vec<(String, String)>,
    /// What stands in a robot's way.
    pub(super) in_the_way: Vec<(ScriptedKind, usize, ObstacleId)>,
    pub(super) network: Network,
    pub(super) told: Told,
    pub(super) leave: Leave,
    /// What the listener has heard.
    pub(super) observations: Observations,
    epochs: Random,
    next_ns: u64,
    /// Nobody has looked since time passed.
    pub(super) fresh: bool,
    /// Of all robots, when they are wanted.
    traces: Option<Traces>,
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
        let clones = ClonedRobot::all(scenario);
        let mut bodies = drawn_starts(scenario, seed);
        bodies.extend(clones.iter().map(|own| (&own.config, own.store)));
        let mut world = plain_world(&scenario.site, &bodies, seed)?;
        if let Some(clutter) = &scenario.clutter {
            furnish(&mut world, clutter, seed).map_err(Failure::refused)?;
        }
        world.advance_to(START_NS);
        let world = SharedWorld::from(world);
        let disk = Disk::default();
        let mediator = { plans.mediator.as_ref() }
            .map(|plan| SteppedMediator::start(plan, disk.clone(), START_NS))
            .transpose()?;
        let mut clocks = Random::new(seed, CLOCK_STREAM);
        let robots = { scenario.robots.iter().zip(&plans.robots) }
            .zip(start_delays_ns(scenario, seed))
            .map(|((player, (_, plan)), delay_ns)| {
                let devices = Devices::new(&world, plan, START_NS)?;
                let drive = devices.drive_faults();
                drive.set_encoders_ahead(player.encoders_ahead_rad());
                Ok(Member {
                    id: plan.robot.identity.id.clone(),
                    devices,
                    starts_ns: START_NS + delay_ns,
                    robot: None,
                    killed: None,
                    gone: false,
                    ahead_ns: drawn_ahead_ns(&mut clocks),
                    checkpoints: Checkpoints::default(),
                    was_in: None,
                    has_driven: false,
                    caretaker: Caretaker::default(),
                    driving_out: DrivingOut::default(),
                    sending_on: SendingOn::default(),
                    reloading: Reloading::default(),
                    restarting: Restarting::default(),
                    faults: FaultTable::default(),
                    motors_off: MotorsOff::default(),
                    raised_before: vec![0; Fault::ALL.len()],
                    symbols: Json::Null,
                    allowed: Vec::new(),
                })
            })
            .collect::<Result<_, Failure>>()?;
        Ok(Self {
            world,
            plans,
            robots,
            clones,
            mediator_spans_ns: { mediator.iter() }.map(|_| (START_NS, None)).collect(),
            mediator,
            dropped: 0,
            second_mediator: None,
            ending: None,
            journal_copy: Disk::default(),
            disk,
            faults: Schedule::new(scenario),
            stranded: None,
            panicked: Vec::new(),
            in_the_way: Vec::new(),
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
            traces: traced.then(|| Traces::of(scenario.robots.len())),
            folder: plans.folder.below()?,
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
        self.look_after(self.now_ns());
        self.clear_what_is_empty();
        self.clear_of_other_bodies();
        self.say_who_is_absent();
        Ok(())
    }

    /// Traces, when they were wanted.
    pub fn take_traces(&mut self) -> Option<Traces> {
        self.traces.take()
    }

    /// What a new process of a robot starts with.
    pub(super) fn start_of(&mut self, number: usize, now_ns: u64) -> Start {
        let fleet = match self.leave {
            Leave::Withheld => Fleet::Rig,
            Leave::Ignored => Fleet::Alone,
            Leave::OfMediator => Fleet::Network(self.network.session_of(number)),
        };
        Start {
            fleet,
            boot_epoch: (self.epochs.unit() * (u64::MAX >> 16) as f64) as u64 + 1,
            at_ns: now_ns,
            ahead_ns: self.robots[number].ahead_ns,
            checkpoints: self.robots[number].checkpoints.clone(),
        }
    }

    fn start(&mut self, number: usize, now_ns: u64) -> Result<(), Failure> {
        let start = self.start_of(number, now_ns);
        let (files, plan) = &self.plans.robots[number];
        let folder = self.folder.path();
        let member = &mut self.robots[number];
        let mut robot = SteppedRobot::new(plan, files, folder, &member.devices, start)?;
        robot.allow(&member.allowed);
        robot.be_late(self.faults.lateness(number));
        robot.hang(&self.faults.hung_threads(number));
        robot.clock().drift(self.faults.drift(Some(number)));
        member.robot = Some(robot);
        if self.faults.lasts(ScriptedKind::Reload, Some(number)) {
            member.reloading.want();
        }
        // Whoever stopped it, or tried to, is still there.
        for (what, request) in [
            (ScriptedKind::Pause, Request::Pause),
            (ScriptedKind::Stop, Request::Stop),
        ] {
            if self.faults.lasts(what, Some(number)) {
                self.ask(number, Some(request));
            }
        }
        Ok(())
    }

    /// One step of everything: faults come and go, messages arrive, the mediator goes on, robots go on.
    fn step(&mut self, now_ns: u64) -> Result<(), Failure> {
        for change in self.faults.changes(now_ns) {
            self.apply(change, now_ns)?;
        }
        for number in 0..self.robots.len() {
            if self.may_start(number, now_ns) {
                self.start(number, now_ns)?;
            }
        }
        self.world.lock().advance_to(now_ns);
        while let Some(message) = self.network.arrived(now_ns) {
            let mediator = match message.kind {
                MessageKind::Report => &mut self.mediator,
                MessageKind::SecondReport => &mut self.second_mediator,
                MessageKind::Answer | MessageKind::SecondAnswer => {
                    if let Ok(answer) = decode::<MediatorReport>(&message.bytes) {
                        self.observations.delivered(&answer, now_ns);
                    }
                    continue;
                }
                MessageKind::State => continue,
            };
            if let Some(mediator) = mediator {
                // The loader has checked both names.
                let key = keys::report(PREFIX, &self.robots[message.robot].id).unwrap_or_default();
                mediator.deliver(&key, &message.bytes);
            }
        }
        self.step_mediator(now_ns)?;
        for number in 0..self.robots.len() {
            self.step_robot(number, now_ns);
        }
        for clone in &mut self.clones {
            clone.step(now_ns);
        }
        self.note_panicked(now_ns);
        self.note_ended();
        for message in self.network.take_sent() {
            self.send(message, now_ns);
        }
        Ok(())
    }

    fn step_robot(&mut self, number: usize, now_ns: u64) {
        let hangs = self.faults.hangs(number);
        let motors_off = self.faults.lasts(ScriptedKind::CutMotors, Some(number));
        let member = &mut self.robots[number];
        let running = member.robot.as_mut().filter(|_| !hangs);
        let killed = member.killed.take();
        member.devices.step(now_ns, || match (running, killed) {
            (Some(robot), None) => robot.step(now_ns),
            (Some(robot), Some(_)) => robot.step_in_part(now_ns),
            (None, _) => {}
        });
        if let Some(what) = killed {
            self.lose_process(number, what, now_ns);
            return;
        }
        let member = &mut self.robots[number];
        if let Some(robot) = &member.robot {
            let exchanges = motors_off.then(|| member.devices.drive().setpoints);
            let owes_an_answer = || robot.owes_an_answer_to_a_reset();
            (member.motors_off).look(exchanges, robot.resets_asked(), owes_an_answer);
        }
    }

    /// Sends a message. The listener hears it as it leaves, whatever becomes of it.
    pub(super) fn send(&mut self, message: Message, now_ns: u64) {
        let (bytes, observations) = (&message.bytes[..], &mut self.observations);
        let understood = match message.kind {
            MessageKind::State => decode::<RobotState>(bytes)
                .map(|state| observations.state(state, now_ns))
                .is_ok(),
            MessageKind::Report | MessageKind::SecondReport => decode::<RobotReport>(bytes)
                .map(|report| observations.report(&report, now_ns))
                .is_ok(),
            MessageKind::Answer | MessageKind::SecondAnswer => decode::<MediatorReport>(bytes)
                .map(|answer| observations.answer(&answer, now_ns))
                .is_ok(),
        };
        if !understood {
            observations.note_malformed(now_ns);
        }
        if message.kind == MessageKind::Report && self.second_mediator.is_some() {
            let kind = MessageKind::SecondReport;
            let second = Message {
                kind,
                ..message.clone()
            };
            self.carry(second, now_ns);
        }
        self.carry(message, now_ns);
    }

    fn carry(&mut self, message: Message, now_ns: u64) {
        let weather = self.faults.weather(message.robot, message.kind);
        self.network.send(message, weather, now_ns);
    }

    /// Takes in what the robots say of themselves, and traces.
    fn hear(&mut self) {
        let now_ns = self.now_ns();
        let world = self.world.lock();
        if let Some(traces) = &mut self.traces {
            traces.add_others(now_ns, world.obstacles().map(|(_, shape)| shape));
        }
        for (number, member) in self.robots.iter_mut().enumerate() {
            let Some(robot) = &mut member.robot else {
                continue;
            };
            let faults = robot.insight().faults();
            if let Some(traces) = &mut self.traces
                && let Some(truth) = world.truth(number)
            {
                let (trace, belief) = (&mut traces.robots[number], robot.insight().look());
                trace.note(now_ns, &belief, &member.faults, &faults);
                trace.add(&truth, &belief);
            }
            member.faults = faults;
        }
    }
}
