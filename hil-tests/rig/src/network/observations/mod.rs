//! What can be known of a fleet from the messages on its network: who has which area, who waits, which nets have the
//! discrete control of robots, and how fast the mediator answers.
//!
//! Levels only grow within one registration of a robot, and both sides repeat those of the other, so it does not matter in which
//! order its messages are heard.
//! Times are `u64` nanoseconds of the monotonic clock, when a message was heard.

mod access;
mod control;
mod grants;
mod latency;
mod leases;
mod places;
mod registrations;

use std::collections::BTreeMap;

use config::{NetConfig, NetParty, SiteConfig};
use contract::wire::{MediatorReport, RobotReport, RobotState};

use access::{Accesses, is_grant};
use control::Controls;
use grants::Grants;
use leases::Leases;
use places::Places;
use registrations::{Order, Registrations, Source};

pub use access::{Owning, Waiting};
pub use control::Controlled;
pub use latency::Latencies;

/// What a robot said of itself last.
#[derive(Clone, Debug)]
pub struct Said {
    /// The message.
    pub state: RobotState,
    /// When it was heard.
    pub at_ns: u64,
}

/// A robot's state machine changed its state.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// When it was heard.
    pub at_ns: u64,
    /// Robot.
    pub robot: String,
    /// State of its machine.
    pub state: String,
    /// Area in which it believed to be.
    pub area: String,
    /// Skill.
    pub skill: String,
    /// Where it believed to be.
    pub believed_m: [f64; 2],
}

/// Messages that could not be decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Malformed {
    /// How many.
    pub count: u64,
    /// When the first was heard.
    pub first_ns: u64,
}

/// All that was heard.
#[derive(Clone, Debug)]
pub struct Observations {
    said: BTreeMap<String, Said>,
    steps: Vec<Step>,
    registrations: Registrations,
    accesses: Accesses,
    grants: Grants,
    controls: Controls,
    latencies: Latencies,
    leases: Leases,
    places: Places,
    malformed: Option<Malformed>,
}

impl Observations {
    /// An empty one.
    #[must_use]
    pub fn new(site: &SiteConfig, nets: &[NetConfig]) -> Self {
        let capacities = { site.areas.iter() }
            .map(|area| (area.id.clone(), area.capacity))
            .collect();
        Self {
            said: BTreeMap::new(),
            steps: Vec::new(),
            registrations: Registrations::default(),
            accesses: Accesses::new(capacities),
            grants: Grants::default(),
            controls: Controls::default(),
            latencies: Latencies::new(governed(nets)),
            leases: Leases::default(),
            places: Places::default(),
            malformed: None,
        }
    }

    /// A robot's state.
    pub fn state(&mut self, state: RobotState, at_ns: u64) {
        let before = self.said.get(&state.robot_id);
        // Levels: an older message of the same boot of the robot says nothing new.
        if before.is_some_and(|said| {
            said.state.boot_epoch == state.boot_epoch && said.state.sequence >= state.sequence
        }) {
            return;
        }
        let news = before.is_none_or(|said| {
            said.state.fsm_state != state.fsm_state || said.state.skill != state.skill
        });
        let pose = state.pose.unwrap_or_default();
        if news && !state.fsm_state.is_empty() {
            self.steps.push(Step {
                at_ns,
                robot: state.robot_id.clone(),
                state: state.fsm_state.clone(),
                area: state.area.clone(),
                skill: state.skill.clone(),
                believed_m: [pose.x_m, pose.y_m],
            });
        }
        self.said
            .insert(state.robot_id.clone(), Said { state, at_ns });
    }

    /// What a robot told the mediator.
    pub fn report(&mut self, report: &RobotReport, at_ns: u64) {
        let robot = &report.robot_id;
        (self.leases).sent(robot, report.boot_epoch, report.sequence, at_ns);
        self.places.take_in(report, at_ns);
        if report.session == 0 {
            // Before its session a restarted robot does not know its earlier levels.
            return;
        }
        let source = Source {
            instance: report.mediator_instance,
            epoch: report.mediator_epoch,
            journal: report.mediator_journal,
        };
        self.hear(source, at_ns);
        let process = (report.session, report.boot_epoch);
        match self.registrations.report(robot, source, process) {
            Order::Old => return,
            Order::Present => {}
            Order::Begins => {
                let said = report.access.iter();
                let said = said.filter_map(|own| Some((own.area.as_str(), own.level.as_ref()?)));
                self.accesses.begin(robot, &said.collect(), at_ns);
            }
        }
        for access in &report.access {
            let Some(level) = &access.level else { continue };
            let by = (source.journal, access.fence);
            let deeds = (self.accesses).learn(robot, &access.area, level, by, at_ns);
            let free = self.accesses.is_free_for(robot, &access.area)
                && !self.controls.is_controlled(robot);
            self.latencies
                .robot(robot, &access.area, deeds, free, at_ns);
        }
        if let Some(control) = &report.control {
            let deeds = self.controls.answer(robot, control, at_ns);
            self.latencies.control(control.coordination, deeds, at_ns);
        }
    }

    /// What the mediator told a robot.
    pub fn answer(&mut self, answer: &MediatorReport, at_ns: u64) {
        let robot = &answer.robot_id;
        if answer.session == 0 {
            return;
        }
        let source = Source {
            instance: answer.instance,
            epoch: answer.mediator_epoch,
            journal: answer.journal,
        };
        self.hear(source, at_ns);
        for (area, by) in granted(answer) {
            self.grants.said(robot, area, by, at_ns);
        }
        if (self.registrations).is_old(robot, source, answer.session) {
            return;
        }
        for grant in &answer.access {
            let Some(level) = &grant.level else { continue };
            let full = self.accesses.is_full_for(robot, &grant.area);
            let by = (source.journal, grant.fence);
            (self.accesses).confirm(robot, &grant.area, level, grant.fence);
            let deeds = (self.accesses).learn(robot, &grant.area, level, by, at_ns);
            self.accesses.explain(robot, &grant.area, &grant.waits_for);
            let waits = !grant.waits_for.is_empty();
            self.latencies
                .mediator(robot, &grant.area, deeds, waits, full, at_ns);
        }
        match &answer.control {
            Some(control) => {
                let deeds = self.controls.order(robot, control, at_ns);
                self.latencies.command(control.coordination, deeds, at_ns);
            }
            None => self.controls.free(robot, at_ns),
        }
    }

    fn hear(&mut self, source: Source, at_ns: u64) {
        if self.registrations.hear(source) {
            self.controls.free_all(at_ns);
        }
    }

    /// An answer that was heard when it left has reached its robot.
    pub fn delivered(&mut self, answer: &MediatorReport, at_ns: u64) {
        let (robot, boot) = (&answer.robot_id, answer.boot_epoch);
        self.leases.echoed(robot, boot, answer.robot_sequence);
        self.grants.deliver();
        for (area, by) in granted(answer) {
            self.grants.reached(robot, area, by, at_ns);
        }
    }

    /// From when on the robot's lease runs; none: not known.
    #[must_use]
    pub fn lease_began_ns(&self, robot: &str) -> Option<u64> {
        self.leases.began_ns(robot)
    }

    /// Since when a process with the robot's name says that it stands in the area; none: none does.
    #[must_use]
    pub fn stands_since_ns(&self, robot: &str, area: &str) -> Option<u64> {
        self.places.since_ns(robot, area)
    }

    /// A message that could not be decoded.
    pub fn note_malformed(&mut self, at_ns: u64) {
        let first = Malformed {
            count: 0,
            first_ns: at_ns,
        };
        self.malformed.get_or_insert(first).count += 1;
    }

    /// Messages that could not be decoded; none: all could be.
    #[must_use]
    pub fn malformed(&self) -> Option<Malformed> {
        self.malformed
    }

    /// An operator cleared this area of these robots.
    pub fn cleared(&mut self, area: &str, robots: &[&str], at_ns: u64) {
        for robot in robots {
            self.accesses.give_up(robot, area, at_ns);
        }
    }

    /// What a robot said of itself last.
    #[must_use]
    pub fn said(&self, robot: &str) -> Option<&Said> {
        self.said.get(robot)
    }

    /// All steps of state machines, in order.
    #[must_use]
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Who had which area, in the order of grants.
    #[must_use]
    pub fn ownings(&self) -> &[Owning] {
        self.accesses.ownings()
    }

    /// All requests, answered or not, in their order.
    #[must_use]
    pub fn waitings(&self) -> &[Waiting] {
        self.accesses.waitings()
    }

    /// Robots under the discrete control of nets, in the order in which that began.
    #[must_use]
    pub fn controlled(&self) -> &[Controlled] {
        self.controls.all()
    }

    /// How fast the mediator answers.
    #[must_use]
    pub fn latencies(&self) -> &Latencies {
        &self.latencies
    }

    /// Whether the robot had the area at this time, within the tolerance.
    #[must_use]
    pub fn had(&self, robot: &str, area: &str, at_ns: u64, tolerance_ns: u64) -> bool {
        self.ownings().iter().rev().any(|owning| {
            owning.robot == robot && owning.area == area && owning.covers(at_ns, tolerance_ns)
        })
    }

    /// Whether the robot knew at this time, within the tolerance, of a mediator's grant by which it had the area; also where it says that
    /// it has none.
    #[must_use]
    pub fn was_given(&self, robot: &str, area: &str, at_ns: u64, tolerance_ns: u64) -> bool {
        let mut all = { self.ownings().iter().rev() }
            .filter(|own| own.robot == robot && own.area == area)
            .filter(|own| own.covers(at_ns, tolerance_ns))
            .peekable();
        let known_ns = at_ns.saturating_add(tolerance_ns);
        let given =
            |own: &Owning| (self.grants).was_given(robot, area, (own.journal, own.fence), known_ns);
        all.peek().is_none() || all.any(given)
    }

    /// The net that had the discrete control of this robot at this time, if one had.
    #[must_use]
    pub fn control_of(&self, robot: &str, at_ns: u64) -> Option<&Controlled> {
        let mut all = self.controlled().iter().rev();
        all.find(|own| own.robot == robot && own.covers(at_ns))
    }

    /// Whether these robots follow mediators with different journals, as they say.
    #[must_use]
    pub fn follow_different_mediators(&self, robots: [&str; 2]) -> bool {
        let [one, other] = robots.map(|robot| self.registrations.followed_by(robot));
        one.zip(other).is_some_and(|(one, other)| one != other)
    }

    /// Whether a net of this name had the discrete control of any robot at this time.
    #[must_use]
    pub fn coordinated(&self, net: &str, at_ns: u64) -> bool {
        self.controlled()
            .iter()
            .any(|own| own.net == net && own.covers(at_ns))
    }
}

/// The areas that its robot has by an answer, each with journal and fence.
fn granted(answer: &MediatorReport) -> impl Iterator<Item = (&str, (u64, u64))> {
    let has = answer.access.iter();
    has.filter(|own| answer.session != 0 && own.level.as_ref().is_some_and(is_grant))
        .map(|own| (own.area.as_str(), (answer.journal, own.fence)))
}

/// Areas into which a net lets robots by protocol 1, each with the number of its net.
fn governed(nets: &[NetConfig]) -> BTreeMap<String, usize> {
    let mut governed = BTreeMap::new();
    for (number, net) in nets.iter().enumerate() {
        for role in &net.roles {
            let protocol = net.protocols.iter().find(|own| own.id == role.protocol);
            let flags: Vec<_> = { protocol.into_iter() }
                .flat_map(|protocol| &protocol.arrays)
                .flat_map(|array| &array.flags)
                .collect();
            if !flags.first().is_some_and(|flag| flag.by == NetParty::Robot) {
                continue;
            }
            for area in flags.iter().flat_map(|flag| &flag.command.enters) {
                governed.insert(area.clone(), number);
            }
        }
    }
    governed
}

#[cfg(test)]
mod tests;
