//! Coordinations: starting, stepping, watching, ending.

use std::collections::VecDeque;
use std::sync::Arc;

use super::Manager;
use super::alarm::{Alarm, BadReport};
use super::explain::CoordinationStatus;
use super::run::Run;
use crate::journal::{Entry, Stored};
use crate::nets::{Cast, Handle, Instance, Kind, Plan, Running, Stage, Unrestorable};
use contract::level;
use contract::wire::{Control, RobotReport};

/// What is over is remembered, for people.
const REMEMBERED: usize = 32;
/// No coordination gets a larger number; a report with one is nonsense.
const LAST_NUMBER: u64 = 1 << 62;
/// A step that leads to another is followed at most so often at once.
const STEPS: usize = 8;

/// Everything about coordinations that the manager keeps.
#[derive(Debug)]
pub(super) struct Coordinator {
    pub(super) plans: Vec<Arc<Plan>>,
    pub(super) running: Running,
    /// Of the last one.
    number: u64,
    /// By plan: not started again before.
    held_off_ns: Vec<u64>,
    /// By area: the plan whose net lets robots in.
    pub(super) governed: Vec<Option<usize>>,
    pub(super) over: VecDeque<CoordinationStatus>,
}

impl Coordinator {
    pub(super) fn new(plans: Vec<Arc<Plan>>, areas: usize) -> Self {
        let mut governed = vec![None; areas];
        for (index, plan) in plans.iter().enumerate() {
            plan.governed
                .iter()
                .for_each(|&area| governed[area] = Some(index));
        }
        Self {
            running: Running::default(),
            number: 0,
            held_off_ns: vec![0; plans.len()],
            governed,
            over: VecDeque::new(),
            plans,
        }
    }

    pub(super) fn instances(&self) -> impl Iterator<Item = &Instance> {
        self.running.instances()
    }

    /// Which coordination has the robot's discrete control, and its role there.
    pub(super) fn control_of(&self, robot: usize) -> Option<(&Instance, usize)> {
        self.instances()
            .find_map(|instance| Some((instance, instance.controls(robot)?)))
    }

    /// Robots for which an area is kept.
    pub(super) fn kept(&self, area: usize) -> Vec<usize> {
        let parts = self.instances().flat_map(|instance| &instance.parts);
        parts
            .filter(|part| part.keeps(area))
            .map(|part| part.robot)
            .collect()
    }
}

impl Manager {
    // ---------------------------------------------------------------- from the journal

    /// Takes up what ran. What cannot go on is given up, and its robots are let go.
    pub(super) fn restore_coordinations(&mut self, stored: &Stored, now_ns: u64) {
        let last = stored.coordinations.keys().copied().max();
        self.coordinator.number = stored.number.max(last.unwrap_or(0));
        for (&number, record) in &stored.coordinations {
            let plans = &self.coordinator.plans;
            let plan = plans.iter().find(|plan| plan.id == record.coordination);
            let taken = self.coordinator.instances();
            let plan = { plan.cloned() }
                .filter(|plan| taken.into_iter().all(|other| other.plan.id != plan.id))
                .ok_or_else(|| Unrestorable("the site does not have it".to_owned()));
            let instance = plan.and_then(|plan| {
                let robot = |id: &str| self.robot_index.get(id).copied();
                let area = |id: &str| self.area_index.get(id).copied();
                Instance::restore(&plan, number, record, robot, area, now_ns)
            });
            match instance {
                Ok(instance) => drop(self.coordinator.running.start(instance)),
                Err(what) => {
                    self.alarms.push(Alarm::NotResumed {
                        coordination: record.coordination.clone(),
                        what: what.to_string(),
                    });
                    let record = None;
                    self.entries.push(Entry::Coordination { number, record });
                }
            }
        }
    }

    // ---------------------------------------------------------------- what robots say

    /// Takes in how far a robot is with its discrete control.
    pub(super) fn merge_control(
        &mut self,
        robot: usize,
        report: &RobotReport,
        first: bool,
        now_ns: u64,
    ) {
        let number = report.control.as_ref().map_or(0, |own| own.coordination);
        if first {
            self.miss_control(robot, number, now_ns);
        }
        let Some(control) = &report.control else {
            return;
        };
        if control.coordination > LAST_NUMBER {
            self.complain_of_control(robot, BadReport::Number(control.coordination));
            return;
        }
        if control.coordination > self.coordinator.number {
            // The journal has lost its last entries: never give that number again.
            self.coordinator.number = control.coordination;
            self.entries.push(Entry::Number(control.coordination));
        }
        let found = self.coordinator.running.find(|instance| {
            instance.number == control.coordination && instance.robots().contains(&robot)
        });
        let Some(handle) = found else {
            // It is over, or another one has begun; the robot does not know yet.
            self.tell(robot);
            return;
        };
        match self.merge_level(handle, robot, control) {
            Ok(()) => {}
            Err(BadReport::Merge(_)) if first => {
                self.alarms.push(Alarm::Forgotten {
                    coordination: self.coordination_id(handle),
                    robot: self.robots[robot].id.clone(),
                });
                self.break_off(handle, now_ns);
            }
            Err(what) => self.complain_of_control(robot, what),
        }
    }

    /// A robot that was let go in the past that the journal has lost does not come back by itself.
    fn miss_control(&mut self, robot: usize, number: u64, now_ns: u64) {
        let own = self.coordinator.control_of(robot);
        let missing = own.is_some_and(|(instance, role)| {
            instance.number != number && instance.is_known_to(role)
        });
        let running = &self.coordinator.running;
        let handle = running.find(|instance| instance.controls(robot).is_some());
        if let Some(handle) = handle.filter(|_| missing) {
            self.alarms.push(Alarm::Forgotten {
                coordination: self.coordination_id(handle),
                robot: self.robots[robot].id.clone(),
            });
            self.break_off(handle, now_ns);
        }
    }

    fn merge_level(
        &mut self,
        handle: Handle,
        robot: usize,
        control: &Control,
    ) -> Result<(), BadReport> {
        let level = level::decode(control.level.as_ref())?;
        let Some(instance) = self.coordinator.running.get_mut(handle) else {
            return Ok(());
        };
        if let Some(part) = instance.parts.iter_mut().find(|part| part.robot == robot) {
            part.merge(level)?;
            if part.peek().is_some() {
                // A candidate was told of the level before this one, and must hear the present one first.
                self.robots[robot].candidate = None;
            }
        }
        Ok(())
    }

    fn complain_of_control(&mut self, robot: usize, what: BadReport) {
        self.counters.bad += 1;
        self.alarms.push(Alarm::BadControl {
            robot: self.robots[robot].id.clone(),
            what,
        });
    }

    // ---------------------------------------------------------------- going on

    /// Lets all coordinations go on as far as they can, and starts those whose situation has come.
    pub(super) fn coordinate(&mut self, now_ns: u64) {
        if self.coordinator.plans.is_empty() || !self.awaited.is_empty() {
            return;
        }
        for handle in self.coordinator.running.handles() {
            self.step_coordination(handle, now_ns);
        }
        for plan in 0..self.coordinator.plans.len() {
            if let Some((situation, robots)) = self.situation(plan, now_ns) {
                let plan = Arc::clone(&self.coordinator.plans[plan]);
                let number = self.next_number();
                let instance = Instance::start(&plan, number, situation, &robots, now_ns);
                let handle = self.coordinator.running.start(instance);
                self.changed_coordination(handle);
                self.step_coordination(handle, now_ns);
            }
        }
    }

    fn step_coordination(&mut self, handle: Handle, now_ns: u64) {
        if let Some((robot, area)) = self.bypass(handle) {
            self.alarms.push(Alarm::Bypassed {
                coordination: self.coordination_id(handle),
                robot: self.robots[robot].id.clone(),
                area: self.areas[area].id.clone(),
            });
            self.end_coordination(handle, now_ns);
            return;
        }
        let mut changed = false;
        for _ in 0..STEPS {
            let Self {
                coordinator,
                robots,
                ..
            } = self;
            let Some(instance) = coordinator.running.get_mut(handle) else {
                return;
            };
            let mut went_on = false;
            for role in 0..instance.parts.len() {
                let robot = &robots[instance.parts[role].robot];
                went_on |= instance.follow_access(
                    role,
                    |area| robot.run(area).is_some_and(Run::waits),
                    |area| robot.holds(area),
                    |area| robot.run(area).is_some_and(Run::is_entered),
                );
            }
            let stepped = instance.step(now_ns);
            went_on |= stepped.changed;
            went_on |= self.after_yielding(handle, now_ns);
            changed |= went_on;
            if !went_on {
                break;
            }
        }
        if changed {
            self.changed_coordination(handle);
        }
        let own = self.coordinator.running.get(handle);
        if own.is_some_and(Instance::is_over) {
            self.end_coordination(handle, now_ns);
        }
    }

    /// A robot that is where the net has not let it: the net does not know how things are.
    fn bypass(&self, handle: Handle) -> Option<(usize, usize)> {
        let instance = self.coordinator.running.get(handle)?;
        let governed = instance.plan.governed.iter();
        let occupied =
            governed.flat_map(|&area| self.occupants(area).map(move |robot| (robot, area)));
        let mut bypasses = occupied.filter(|&(robot, area)| {
            let role = instance.parts.iter().position(|part| part.robot == robot);
            !role.is_some_and(|role| instance.lets_in(role, area))
        });
        bypasses.next()
    }

    /// Once all robots are out of the way: begins again in the safe situation, or lets them go.
    fn after_yielding(&mut self, handle: Handle, now_ns: u64) -> bool {
        let Some(instance) = self.coordinator.running.get(handle) else {
            return false;
        };
        let Some(preempt) = instance
            .plan
            .preempt
            .as_ref()
            .filter(|_| matches!(instance.stage, Stage::Yielding))
        else {
            return false;
        };
        let out_of_the_way = |role: usize| {
            let robot = &self.robots[instance.parts[role].robot];
            let safe = preempt.yields[role].states.contains(&robot.fsm_state);
            instance.has_read_halt(role) && robot.is_heard() && safe
        };
        let releases = instance.releases();
        if !releases && !(0..instance.parts.len()).all(out_of_the_way) {
            return false;
        }
        let (plan, robots) = (Arc::clone(&instance.plan), instance.robots());
        let again = preempt.situation.filter(|&situation| {
            let casts = &plan.situations[situation].casts;
            !releases && { robots.iter().zip(casts) }.all(|(&robot, cast)| self.fits(robot, cast))
        });
        if let Some(situation) = again {
            let number = self.next_number();
            let next = Instance::start(&plan, number, situation, &robots, now_ns);
            self.replace(handle, next, now_ns);
            return true;
        }
        self.coordinator
            .running
            .get_mut(handle)
            .is_some_and(|instance| instance.release(now_ns))
    }

    /// Stores it, tells its robots, and looks at all areas again.
    fn changed_coordination(&mut self, handle: Handle) {
        self.store_coordination(handle);
        let Some(instance) = self.coordinator.running.get(handle) else {
            return;
        };
        for robot in instance.robots() {
            self.tell(robot);
        }
        self.touch_all();
    }

    fn store_coordination(&mut self, handle: Handle) {
        let Some(instance) = self.coordinator.running.get(handle) else {
            return;
        };
        let robot = |robot: usize| self.robots[robot].id.clone();
        let area = |area: usize| self.areas[area].id.clone();
        self.entries.push(Entry::Coordination {
            number: instance.number,
            record: Some(instance.record(robot, area)),
        });
    }

    fn next_number(&mut self) -> u64 {
        self.coordinator.number += 1;
        self.entries.push(Entry::Number(self.coordinator.number));
        self.coordinator.number
    }

    fn coordination_id(&self, handle: Handle) -> String {
        self.coordinator.running.name(handle)
    }

    /// Another run, with another number, in the place of this one.
    fn replace(&mut self, handle: Handle, next: Instance, now_ns: u64) {
        self.remember(handle, now_ns);
        let old = self.coordinator.running.replace(handle, next);
        let old = old.map(|instance| instance.number);
        let record = None;
        self.entries
            .extend(old.map(|number| Entry::Coordination { number, record }));
        self.changed_coordination(handle);
    }

    fn end_coordination(&mut self, handle: Handle, now_ns: u64) {
        self.remember(handle, now_ns);
        let Some(instance) = self.coordinator.running.end(handle) else {
            return;
        };
        if matches!(instance.stage, Stage::Yielding) {
            let plans = self.coordinator.plans.iter();
            for (plan, held_off_ns) in plans.zip(&mut self.coordinator.held_off_ns) {
                if plan.id == instance.plan.id {
                    // What stood still would stand still again at once.
                    *held_off_ns = now_ns.saturating_add(plan.alarm_after_ns);
                }
            }
        }
        self.entries.push(Entry::Coordination {
            number: instance.number,
            record: None,
        });
        for robot in instance.robots() {
            self.tell(robot);
        }
        self.touch_all();
    }

    fn remember(&mut self, handle: Handle, now_ns: u64) {
        let Some(instance) = self.coordinator.running.get(handle) else {
            return;
        };
        let mut status = self.coordination_status(instance, now_ns);
        status.over = true;
        if self.coordinator.over.len() == REMEMBERED {
            self.coordinator.over.pop_front();
        }
        self.coordinator.over.push_back(status);
    }

    /// A coordination that cannot go on: its robots get out of the way, or else are let go.
    fn break_off(&mut self, handle: Handle, now_ns: u64) {
        let Some(instance) = self.coordinator.running.get(handle) else {
            return;
        };
        let (plan, robots) = (Arc::clone(&instance.plan), instance.robots());
        if plan.preempt.is_none() {
            self.end_coordination(handle, now_ns);
            return;
        }
        let number = self.next_number();
        let next = Instance::yielding(&plan, number, &robots, now_ns);
        self.replace(handle, next, now_ns);
    }

    /// An operator has cleared a robot away: what controls it is given up, and the others are let go.
    pub(super) fn cleared_of(&mut self, robot: usize, now_ns: u64) {
        let controls = |instance: &Instance| instance.controls(robot).is_some();
        while let Some(handle) = self.coordinator.running.find(controls) {
            self.end_coordination(handle, now_ns);
        }
    }

    // ---------------------------------------------------------------- areas

    /// A robot was granted an area, or has given it back: what was kept for it may be no more.
    pub(super) fn kept_changed(&mut self, robot: usize, area: usize, what: KeptChange) {
        for handle in self.coordinator.running.handles() {
            let Some(instance) = self.coordinator.running.get_mut(handle) else {
                continue;
            };
            let mut changed = false;
            for part in instance
                .parts
                .iter_mut()
                .filter(|part| part.robot == robot && part.keeps(area))
            {
                changed |= match what {
                    KeptChange::Granted => part.granted(area),
                    KeptChange::GaveBack { entered } => part.gave_back(area, entered),
                };
            }
            if changed {
                self.store_coordination(handle);
            }
        }
    }

    // ---------------------------------------------------------------- situations

    /// The first situation of a plan that has come, with a robot for each role.
    fn situation(&self, plan: usize, now_ns: u64) -> Option<(usize, Vec<usize>)> {
        let own = &self.coordinator.plans[plan];
        let runs = { self.coordinator.instances() }.any(|instance| instance.plan.id == own.id);
        if runs || now_ns < self.coordinator.held_off_ns[plan] {
            return None;
        }
        if { own.governed.iter() }.any(|&area| self.occupants(area).next().is_some()) {
            return None;
        }
        own.situations
            .iter()
            .enumerate()
            .find_map(|(index, situation)| {
                let candidates = situation.casts.iter().zip(&own.roles).map(|(cast, role)| {
                    let free = |robot: usize| match role.kind {
                        Kind::Access(_) => true,
                        Kind::Control => {
                            self.coordinator.control_of(robot).is_none() && self.fits(robot, cast)
                        }
                    };
                    let robots = cast.robots.iter().copied();
                    robots.filter(|&robot| free(robot)).collect()
                });
                Some((index, distinct(&candidates.collect::<Vec<_>>())?))
            })
    }

    fn fits(&self, robot: usize, cast: &Cast) -> bool {
        let state = &self.robots[robot];
        let waits = |area: &usize| state.run(*area).is_some_and(Run::waits);
        let within = |region: &config::Rect| {
            { state.pose.as_ref() }.is_some_and(|pose| region.contains([pose.x_m, pose.y_m]))
        };
        cast.robots.contains(&robot)
            && state.is_heard()
            && state.located
            && state.placed
            && cast.holds.iter().all(|&area| state.holds(area))
            && { cast.stands_in.iter() }.all(|area| state.stands_in.contains(area))
            && !cast.without.iter().any(|&area| state.occupies(area))
            && cast.asks.iter().all(waits)
            && (cast.states.is_empty() || cast.states.contains(&state.fsm_state))
            && cast.within.as_ref().is_none_or(within)
    }

    // ---------------------------------------------------------------- the monitor

    /// Finds what stands still, raises the alarm, and has robots get out of the way.
    pub(super) fn watch_coordinations(&mut self, now_ns: u64) {
        for handle in self.coordinator.running.handles() {
            let Some(instance) = self.coordinator.running.get_mut(handle) else {
                continue;
            };
            if instance.is_idle() || !self.awaited.is_empty() {
                instance.progress_ns = now_ns;
                continue;
            }
            let still_ns = now_ns.saturating_sub(instance.progress_ns);
            let plan = Arc::clone(&instance.plan);
            if still_ns < plan.alarm_after_ns {
                continue;
            }
            if !std::mem::replace(&mut instance.alarmed, true) {
                let instance = &*instance;
                let sentences = (0..instance.parts.len()).map(|role| {
                    let name = |robot: usize| self.robots[robot].id.clone();
                    let robot = name(instance.parts[role].robot);
                    format!("{robot}: {}", instance.why(role, name))
                });
                let what = sentences.collect::<Vec<_>>().join("; ");
                self.alarms.push(Alarm::Still {
                    coordination: self.coordination_id(handle),
                    since_s: still_ns / 1_000_000_000,
                    what,
                });
            }
            let Some(instance) = self.coordinator.running.get_mut(handle) else {
                continue;
            };
            let runs = matches!(instance.stage, Stage::Running { .. });
            if { plan.preempt.as_ref() }.is_some_and(|preempt| runs && still_ns >= preempt.after_ns)
            {
                self.alarms.push(Alarm::Preempted {
                    coordination: self.coordination_id(handle),
                });
                self.break_off(handle, now_ns);
            }
        }
    }
}

/// What happened to an area that is kept for a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum KeptChange {
    Granted,
    GaveBack { entered: bool },
}

/// A different robot for each role, if there is one (augmenting paths, Kuhn 1955).
fn distinct(candidates: &[Vec<usize>]) -> Option<Vec<usize>> {
    fn place(
        role: usize,
        candidates: &[Vec<usize>],
        seen: &mut Vec<usize>,
        chosen: &mut Vec<Option<usize>>,
    ) -> bool {
        for &robot in &candidates[role] {
            if seen.contains(&robot) {
                continue;
            }
            seen.push(robot);
            let other = chosen.iter().position(|&taken| taken == Some(robot));
            if other.is_none_or(|other| place(other, candidates, seen, chosen)) {
                chosen[role] = Some(robot);
                return true;
            }
        }
        false
    }
    let mut chosen = vec![None; candidates.len()];
    for role in 0..candidates.len() {
        if !place(role, candidates, &mut Vec::new(), &mut chosen) {
            return None;
        }
    }
    chosen.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::distinct;

    #[test]
    fn each_role_gets_another_robot() {
        assert_eq!(distinct(&[vec![0, 1], vec![0]]), Some(vec![1, 0]));
        assert_eq!(distinct(&[vec![0], vec![0]]), None);
        assert_eq!(
            distinct(&[vec![0, 1], vec![0, 2], vec![0]]),
            Some(vec![1, 2, 0])
        );
        assert_eq!(distinct(&[]), Some(vec![]));
    }
}
