//! One run of a plan with certain robots.

use std::collections::VecDeque;
use std::sync::Arc;

use super::part::Part;
use super::plan::{Kind, Plan, Script};
use crate::journal::{CoordinationRecord, LevelRecord, PartRecord};
use contract::protocols::{ACQUIRE, RELEASE};
use coordination::petri::{Budget, Executor, PlaceId, TransitionId};
use coordination::protocol::{FlagId, Party, Position};

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
pub(crate) enum Stage {
    /// The net runs, since this situation.
    Running {
        situation: usize,
        executor: Executor,
    },
    /// All robots are told to get out of the way.
    Yielding,
}

#[derive(Clone, Debug)]
pub(crate) struct Instance {
    pub(crate) number: u64,
    pub(crate) plan: Arc<Plan>,
    pub(crate) stage: Stage,
    /// By role.
    pub(crate) parts: Vec<Part>,
    pub(crate) since_ns: u64,
    /// When a flag was last set or read.
    pub(crate) progress_ns: u64,
    pub(crate) alarmed: bool,
    pub(crate) firings: VecDeque<Firing>,
    pub(crate) fired: u64,
}

/// Why an instance of the journal cannot go on.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Unrestorable(pub(crate) String);

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
        let executor = plan.situations[situation].wired.net.executor();
        let stage = Stage::Running {
            situation,
            executor,
        };
        Self::new(plan, number, stage, robots, now_ns)
    }

    /// Tells all robots to get out of the way.
    pub(crate) fn yielding(plan: &Arc<Plan>, number: u64, robots: &[usize], now_ns: u64) -> Self {
        Self::new(plan, number, Stage::Yielding, robots, now_ns)
    }

    fn new(plan: &Arc<Plan>, number: u64, stage: Stage, robots: &[usize], now_ns: u64) -> Self {
        let mut instance = Self {
            number,
            plan: Arc::clone(plan),
            stage,
            parts: Vec::new(),
            since_ns: now_ns,
            progress_ns: now_ns,
            alarmed: false,
            firings: VecDeque::new(),
            fired: 0,
        };
        instance.parts = { robots.iter().enumerate() }
            .map(|(role, &robot)| {
                let derived = matches!(plan.roles[role].kind, Kind::Access(_));
                Part::new(robot, &instance.script(role).protocol, derived)
            })
            .collect();
        instance
    }

    /// The protocol with the robot of a role, in the present stage.
    pub(crate) fn script(&self, role: usize) -> &Script {
        match (&self.stage, &self.plan.preempt) {
            (Stage::Yielding, Some(preempt)) => &preempt.yields[role].script,
            _ => &self.plan.roles[role].script,
        }
    }

    pub(crate) fn robots(&self) -> Vec<usize> {
        self.parts.iter().map(|part| part.robot).collect()
    }

    /// The robot's control is, or is about to be, with this instance.
    pub(crate) fn controls(&self, robot: usize) -> Option<usize> {
        let role = self.parts.iter().position(|part| part.robot == robot)?;
        let is_control = matches!(self.plan.roles[role].kind, Kind::Control);
        (is_control && !self.parts[role].is_over()).then_some(role)
    }

    /// Every robot has its discrete control back.
    pub(crate) fn is_over(&self) -> bool {
        let mut parts = self.parts.iter().zip(&self.plan.roles);
        self.plan.controls()
            && parts.all(|(part, role)| matches!(role.kind, Kind::Access(_)) || part.is_over())
    }

    /// Nobody is in the middle of a run: there is nothing that could stand still.
    pub(crate) fn is_idle(&self) -> bool {
        !self.plan.controls() && { self.parts.iter() }
            .all(|part| part.position() == Position::START)
    }

    /// The names of the marked places.
    pub(crate) fn marking(&self) -> Vec<String> {
        match &self.stage {
            Stage::Running { executor, .. } => executor
                .marking()
                .map(|place| executor.net().place_name(place).to_owned())
                .collect(),
            Stage::Yielding => Vec::new(),
        }
    }

    // ---------------------------------------------------------------- running

    /// Reads what robots have set, fires what is enabled, and sets the flags of full sinks.
    pub(crate) fn step(&mut self, now_ns: u64) -> Stepped {
        let mut stepped = Stepped::default();
        for round in 0..=ROUNDS {
            let before = stepped.changed;
            stepped.changed = false;
            match self.stage {
                Stage::Running { .. } => self.step_net(now_ns, &mut stepped),
                Stage::Yielding => self.step_yielding(&mut stepped),
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
        let Stage::Running {
            situation,
            executor,
        } = &mut self.stage
        else {
            return;
        };
        let plan = Arc::clone(&self.plan);
        let wired = &plan.situations[*situation].wired;
        let mut flags = 0;
        for (part, sources) in self.parts.iter_mut().zip(&wired.sources) {
            while let Some(flag) = part.peek() {
                // A flag that the net cannot take yet stays unread, and so comes again after a restart.
                if let Some((event, places)) = &sources[flag.index()] {
                    let full = |place: &PlaceId| {
                        executor.is_marked(*place) || executor.waiting(*place) > 0
                    };
                    if places.iter().any(full) || executor.offer(*event).is_err() {
                        break;
                    }
                }
                part.poll();
                flags += 1;
            }
        }
        let mut trace = [TransitionId::default(); FIRINGS];
        let budget = Budget {
            firings: FIRINGS as u32,
            rounds: 4,
        };
        let evaluation = executor.evaluate_traced(budget, &mut trace);
        let net = executor.net().clone();
        for &transition in &trace[..evaluation.fired as usize] {
            if self.firings.len() == REMEMBERED {
                self.firings.pop_front();
            }
            self.firings.push_back(Firing {
                transition: net.transition_name(transition).to_owned(),
                at_ns: now_ns,
            });
        }
        self.fired += u64::from(evaluation.fired);
        executor.drain_sinks(|event| {
            let Some(&(role, flag)) = wired.sinks.get(&event) else {
                return false;
            };
            let part = &mut self.parts[role];
            // One that is not next waits in its sink.
            let set = part.set(flag).is_ok();
            if set {
                flags += 1;
                part.tell_own();
                part.keep(&plan.roles[role].script.enters[flag.index()]);
            }
            set
        });
        if flags > 0 {
            self.progress_ns = now_ns;
            self.alarmed = false;
        }
        stepped.changed |= flags > 0 || evaluation.fired > 0;
    }

    /// Acquires every robot, and tells it to get out of the way.
    fn step_yielding(&mut self, stepped: &mut Stepped) {
        for role in 0..self.parts.len() {
            let release = self.parts[role].protocol().flag(RELEASE);
            let enters = self.script(role).enters.clone();
            let part = &mut self.parts[role];
            while part.peek().is_some() {
                part.poll();
                stepped.changed = true;
            }
            let Some(flag) = part
                .next_of_mediator()
                .filter(|&next| Some(next) != release)
            else {
                continue;
            };
            if part.set(flag).is_ok() {
                part.keep(&enters[flag.index()]);
                stepped.changed = true;
            }
        }
    }

    /// The robot of a role has read that it is to get out of the way, and waits for its release.
    pub(crate) fn has_read_halt(&self, role: usize) -> bool {
        let part = &self.parts[role];
        let release = part.protocol().flag(RELEASE);
        matches!(self.stage, Stage::Yielding)
            && (part.is_over() || (release.is_some() && part.next_of_mediator() == release))
    }

    /// The robot of a role has set a flag, so that it knows of this coordination until it is over.
    pub(crate) fn is_known_to(&self, role: usize) -> bool {
        let part = &self.parts[role];
        let protocol = part.protocol();
        { protocol.set_flags(part.position()) }
            .any(|(flag, _)| protocol.owner(flag) == Some(Party::First))
    }

    /// Some robot was released after yielding: there is no way back.
    pub(crate) fn releases(&self) -> bool {
        matches!(self.stage, Stage::Yielding) && { self.parts.iter() }.any(|part| {
            let release = part.protocol().flag(RELEASE);
            let mut set = part.protocol().set_flags(part.position());
            part.is_over() || set.any(|(flag, _)| Some(flag) == release)
        })
    }

    /// Gives all robots that have yielded their control back.
    pub(crate) fn release(&mut self, now_ns: u64) -> bool {
        let mut changed = false;
        for part in &mut self.parts {
            let release = part.protocol().flag(RELEASE);
            if let Some(flag) = part
                .next_of_mediator()
                .filter(|&next| Some(next) == release)
            {
                changed |= part.set(flag).is_ok();
            }
        }
        if changed {
            self.progress_ns = now_ns;
        }
        changed
    }

    /// The net has let the robot of a role into an area, and knows that it may still be there.
    pub(crate) fn lets_in(&self, role: usize, area: usize) -> bool {
        let Kind::Access(passages) = &self.plan.roles[role].kind else {
            return false;
        };
        let at = self.parts[role].own_position();
        { passages.iter() }.any(|passage| {
            let inside = at == Some(passage.granted_at) || at == Some(passage.entered_at);
            inside && passage.areas.contains(&area)
        })
    }

    /// Follows protocol 1 of a role's robot: `asks`, `has` and `is_in` say how it stands with an area.
    pub(crate) fn follow_access(
        &mut self,
        role: usize,
        asks: impl Fn(usize) -> bool,
        has: impl Fn(usize) -> bool,
        is_in: impl Fn(usize) -> bool,
    ) -> bool {
        let Kind::Access(passages) = &self.plan.roles[role].kind else {
            return false;
        };
        let part = &mut self.parts[role];
        part.tell_own();
        let Some(at) = part.own_position() else {
            return false;
        };
        let mut changed = false;
        if at == Position::START {
            let wants = |areas: &[usize]| {
                areas.iter().all(|&area| asks(area) || has(area)) && areas.iter().any(|&a| asks(a))
            };
            if let Some(passage) = passages.iter().find(|passage| wants(&passage.areas)) {
                changed |= part.set_own(passage.request);
            }
            return changed;
        }
        for passage in passages {
            let none_left = !passage.areas.iter().any(|&area| has(area));
            // It has given all back without entering, or was in and out again before that was seen.
            let waits = |&area: &usize| asks(area) && part.keeps(area);
            let gave_up = none_left && !passage.areas.iter().any(waits);
            let entered = passage.areas.iter().any(|&area| is_in(area));
            if at == passage.granted_at && (entered || gave_up) {
                changed |= part.set_own(passage.entered);
            }
            let at = part.own_position();
            if at == Some(passage.entered_at) && none_left && part.set_own(passage.released) {
                part.kept.clear();
                changed = true;
            }
        }
        changed
    }

    // ---------------------------------------------------------------- the journal

    pub(crate) fn record(
        &self,
        robot: impl Fn(usize) -> String,
        area: impl Fn(usize) -> String,
    ) -> CoordinationRecord {
        let parts = self.parts.iter().zip(&self.plan.roles);
        CoordinationRecord {
            coordination: self.plan.id.clone(),
            situation: match &self.stage {
                Stage::Running { situation, .. } => {
                    Some(self.plan.situations[*situation].name.clone())
                }
                Stage::Yielding => None,
            },
            marking: self.marking(),
            parts: parts
                .map(|(part, role)| PartRecord {
                    role: role.name.clone(),
                    robot: robot(part.robot),
                    level: part.read_level().into(),
                    own: part.own.as_ref().map(|own| own.level().into()),
                    kept: { part.kept.iter() }
                        .map(|kept| (area(kept.area), kept.granted))
                        .collect(),
                })
                .collect(),
        }
    }

    pub(crate) fn restore(
        plan: &Arc<Plan>,
        number: u64,
        record: &CoordinationRecord,
        robot: impl Fn(&str) -> Option<usize>,
        area: impl Fn(&str) -> Option<usize>,
        now_ns: u64,
    ) -> Result<Self, Unrestorable> {
        let lost = |what: String| Unrestorable(what);
        let stage =
            match &record.situation {
                None if plan.preempt.is_some() => Stage::Yielding,
                None => return Err(lost("it has no `preempt` any more".into())),
                Some(name) => {
                    let mut all = plan.situations.iter();
                    let situation = { all.position(|own| own.name == *name) }
                        .ok_or_else(|| lost(format!("it has no situation `{name}` any more")))?;
                    let net = &plan.situations[situation].wired.net;
                    let mut executor = net.executor();
                    let mut marking = Vec::new();
                    for place in &record.marking {
                        let found = net.place_id(place);
                        marking.push(found.ok_or_else(|| {
                            lost(format!("its net has no place `{place}` any more"))
                        })?);
                    }
                    { executor.set_marking(&marking) }.map_err(|error| lost(error.to_string()))?;
                    Stage::Running {
                        situation,
                        executor,
                    }
                }
            };
        let mut instance = Self::new(plan, number, stage, &[], now_ns);
        let names = record.parts.iter().map(|part| part.role.as_str());
        if !names.eq(plan.roles.iter().map(|role| role.name.as_str())) {
            return Err(lost("its net has other roles now".into()));
        }
        for (role, stored) in record.parts.iter().enumerate() {
            let robot = { robot(&stored.robot) }
                .ok_or_else(|| lost(format!("there is no robot `{}` any more", stored.robot)))?;
            let derived = matches!(plan.roles[role].kind, Kind::Access(_));
            let own = stored.own.filter(|_| derived).map(LevelRecord::level);
            if derived && own.is_none() {
                return Err(lost(format!("role `{}` has no side", stored.role)));
            }
            let protocol = &instance.script(role).protocol;
            let mut part = Part::resume(robot, protocol, stored.level.level(), own)
                .map_err(|error| lost(format!("role `{}`: {error}", stored.role)))?;
            for (id, granted) in &stored.kept {
                let area =
                    area(id).ok_or_else(|| lost(format!("there is no area `{id}` any more")))?;
                part.kept.push(super::part::Kept {
                    area,
                    granted: *granted,
                });
            }
            if let Some(own) = &part.own {
                let level = own.level();
                { part.merge(level) }
                    .map_err(|error| lost(format!("role `{}`: {error}", stored.role)))?;
            }
            instance.parts.push(part);
        }
        Ok(instance)
    }
}

impl Part {
    /// The mediator's next flag, if it is its turn and there is no choice.
    pub(crate) fn next_of_mediator(&self) -> Option<FlagId> {
        let protocol = self.protocol();
        let (flag, _) = protocol.next(self.position()).next()?;
        let acquire = protocol.flag(ACQUIRE);
        let begins = self.position() == Position::START;
        (protocol.owner(flag) == Some(Party::Second)
            && self.peek().is_none()
            && !self.is_over()
            && (!begins || Some(flag) == acquire))
            .then_some(flag)
    }
}
