//! Which coordinations run, and what they keep.

use std::collections::VecDeque;
use std::sync::Arc;

use super::answer::Answer;
use super::candidates::Candidates;
use super::status::CoordinationStatus;
use crate::journal::{Entry, Stored};
use crate::manager::alarm::Alarm;
use crate::manager::areas::{Reservations, Reserved};
use crate::manager::effects::Effects;
use crate::manager::names::Names;
use crate::nets::{GivenBack, Instance, Kind, Plan, Unrestorable};

/// The last 32 coordinations that are over are remembered, for people.
const REMEMBERED: usize = 32;

/// A coordination under way.
#[derive(Clone, Debug)]
struct Running {
    /// Its plan. A plan runs once at a time.
    plan: usize,
    instance: Instance,
    /// There is news for it: of its robots, of areas that its net governs, or of robots that wait for those.
    is_due: bool,
}

impl Running {
    fn new(plan: usize, instance: Instance) -> Self {
        Self {
            plan,
            instance,
            is_due: true,
        }
    }
}

/// What happened to an area that is kept for a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum KeptChange {
    Granted,
    GaveBack(GivenBack),
}

/// Everything about coordinations that the manager keeps. Those that run are named by the number of their plan.
#[derive(Clone, Debug)]
pub(crate) struct Coordinations {
    pub(super) names: Arc<Names>,
    pub(super) plans: Vec<Arc<Plan>>,
    /// In the order of their start.
    running: Vec<Running>,
    /// Number of the last coordination.
    number: u64,
    /// What runs is let go on then, without news as well.
    pub(super) look_again_ns: u64,
    /// By plan: not started again before.
    pub(super) held_off_ns: Vec<u64>,
    /// By robot.
    pub(super) answers: Vec<Answer>,
    /// By area: the plan whose net lets robots in.
    governed: Vec<Option<usize>>,
    pub(super) candidates: Candidates,
    over: VecDeque<CoordinationStatus>,
}

impl Coordinations {
    fn new(plans: Vec<Arc<Plan>>, areas: usize, names: &Arc<Names>) -> Self {
        let mut governed = vec![None; areas];
        for (index, plan) in plans.iter().enumerate() {
            for &area in &plan.governed {
                governed[area] = Some(index);
            }
        }
        Self {
            names: Arc::clone(names),
            running: Vec::new(),
            number: 0,
            look_again_ns: 0,
            held_off_ns: vec![0; plans.len()],
            answers: vec![Answer::default(); names.robots().len()],
            governed,
            candidates: Candidates::new(&plans, names.robots().len()),
            over: VecDeque::new(),
            plans,
        }
    }

    /// Takes up what ran. What cannot go on is given up, and its robots are let go.
    pub(crate) fn restore(
        plans: Vec<Arc<Plan>>,
        areas: usize,
        names: &Arc<Names>,
        stored: &Stored,
        now_ns: u64,
        effects: &mut Effects,
    ) -> Self {
        let mut all = Self::new(plans, areas, names);
        let last = stored.coordinations.keys().copied().max();
        all.number = stored.number.max(last.unwrap_or(0));
        for (&number, record) in &stored.coordinations {
            let plan = { all.plans.iter() }.position(|plan| plan.id == record.coordination);
            let restored = { plan.filter(|&plan| all.get(plan).is_none()) }
                .ok_or_else(|| Unrestorable("the site does not have it".to_owned()))
                .and_then(|plan| {
                    let robot = |id: &str| names.robot(id);
                    let area = |id: &str| names.area(id);
                    let own = &all.plans[plan];
                    let instance = Instance::restore(own, number, record, robot, area, now_ns)?;
                    Ok(Running::new(plan, instance))
                });
            match restored {
                Ok(running) => all.running.push(running),
                Err(what) => {
                    effects.alarms.push(Alarm::NotResumed {
                        coordination: record.coordination.clone(),
                        what: what.to_string(),
                    });
                    let record = None;
                    effects.entries.push(Entry::Coordination { number, record });
                }
            }
        }
        all
    }

    // ---------------------------------------------------------------- questions

    /// The plans that run, in the order of their start.
    pub(super) fn plans_that_run(&self) -> Vec<usize> {
        self.running.iter().map(|own| own.plan).collect()
    }

    /// What runs by a plan.
    pub(crate) fn get(&self, plan: usize) -> Option<&Instance> {
        let own = self.running.iter().find(|own| own.plan == plan)?;
        Some(&own.instance)
    }

    pub(super) fn get_mut(&mut self, plan: usize) -> Option<&mut Instance> {
        let own = self.running.iter_mut().find(|own| own.plan == plan)?;
        Some(&mut own.instance)
    }

    /// All that run, in the order of their start.
    pub(crate) fn instances(&self) -> impl Iterator<Item = &Instance> {
        self.running.iter().map(|own| &own.instance)
    }

    pub(super) fn instances_mut(&mut self) -> impl Iterator<Item = &mut Instance> {
        self.running.iter_mut().map(|own| &mut own.instance)
    }

    /// The last ones that are over, for people.
    pub(crate) fn over(&self) -> impl Iterator<Item = &CoordinationStatus> {
        self.over.iter()
    }

    /// Which coordination has the robot's discrete control, and its role there.
    pub(crate) fn control_of(&self, robot: usize) -> Option<(&Instance, usize)> {
        self.instances()
            .find_map(|instance| Some((instance, instance.controls(robot)?)))
    }

    /// The plans whose coordinations have the robot's discrete control.
    pub(super) fn plans_that_control(&self, robot: usize) -> Vec<usize> {
        { self.running.iter() }
            .filter(|own| own.instance.controls(robot).is_some())
            .map(|own| own.plan)
            .collect()
    }

    /// The plan whose net lets robots into an area, and what runs by it.
    pub(crate) fn governor(&self, area: usize) -> Option<(&Plan, Option<&Instance>)> {
        let plan = self.governed[area]?;
        Some((&self.plans[plan], self.get(plan)))
    }

    /// The plan whose net lets robots into an area.
    pub(super) fn governor_of(&self, area: usize) -> Option<usize> {
        self.governed[area]
    }

    /// Number of the last coordination.
    pub(super) fn number(&self) -> u64 {
        self.number
    }

    /// What alarms call it: the plan's id, and the number by which it is listed.
    pub(super) fn name(&self, plan: usize) -> String {
        self.get(plan)
            .map_or_else(String::new, |own| format!("{}/{}", own.plan.id, own.number))
    }

    // ---------------------------------------------------------------- beginning and ending

    /// Gives out the next number.
    pub(super) fn next_number(&mut self, effects: &mut Effects) -> u64 {
        self.skip_to(self.number + 1, effects);
        self.number
    }

    /// No coordination gets a number up to this one again.
    pub(super) fn skip_to(&mut self, number: u64, effects: &mut Effects) {
        self.number = number;
        effects.entries.push(Entry::Number(number));
    }

    pub(super) fn begin(&mut self, plan: usize, instance: Instance) {
        self.look_again_at_all(&instance);
        self.note_served(plan, &instance);
        self.running.push(Running::new(plan, instance));
    }

    /// Its robots come last next time. Those with protocol 1 are exchanged for whoever asks.
    fn note_served(&mut self, plan: usize, instance: &Instance) {
        for (role, participant) in self.plans[plan].roles.iter().zip(instance.participants()) {
            if matches!(role.kind, Kind::Control) {
                self.candidates.serve(participant.robot, instance.number);
            }
        }
    }

    /// Ends what runs by a plan, and remembers it.
    pub(super) fn remove(
        &mut self,
        plan: usize,
        now_ns: u64,
        effects: &mut Effects,
    ) -> Option<Instance> {
        let place = self.running.iter().position(|own| own.plan == plan)?;
        let instance = self.running.remove(place).instance;
        self.look_again_at_all(&instance);
        self.candidates.note_plan(plan);
        self.remember(&instance, now_ns, effects);
        Some(instance)
    }

    /// Ends what runs by a plan, and begins another in its place.
    pub(super) fn replace(
        &mut self,
        plan: usize,
        next: Instance,
        now_ns: u64,
        effects: &mut Effects,
    ) {
        self.note_served(plan, &next);
        if let Some(own) = self.running.iter_mut().find(|own| own.plan == plan) {
            let old = std::mem::replace(own, Running::new(plan, next)).instance;
            self.look_again_at_all(&old);
            self.remember(&old, now_ns, effects);
        }
    }

    /// There is news for what runs by a plan.
    pub(super) fn note_running(&mut self, plan: usize) {
        for own in self.running.iter_mut().filter(|own| own.plan == plan) {
            own.is_due = true;
        }
    }

    /// There is news for whatever a robot plays a role in.
    pub(super) fn note_running_with(&mut self, robot: usize) {
        for own in &mut self.running {
            own.is_due |= own.instance.role_of(robot).is_some();
        }
    }

    /// There may be news for all that runs.
    pub(super) fn note_all_running(&mut self) {
        self.running.iter_mut().for_each(|own| own.is_due = true);
    }

    /// The plans that run and for which there is news, in the order of their start; from now on there is none.
    pub(super) fn take_running_due(&mut self) -> Vec<usize> {
        let due = self.running.iter_mut();
        due.filter_map(|own| std::mem::take(&mut own.is_due).then_some(own.plan))
            .collect()
    }

    /// Whether they are in a coordination may have changed.
    pub(super) fn look_again_at_all(&mut self, instance: &Instance) {
        for participant in instance.participants() {
            self.look_again_at(participant.robot);
        }
    }

    fn remember(&mut self, instance: &Instance, now_ns: u64, effects: &mut Effects) {
        let mut status = CoordinationStatus::of(instance, &self.names, now_ns);
        status.over = true;
        if self.over.len() == REMEMBERED {
            self.over.pop_front();
        }
        self.over.push_back(status);
        effects.entries.push(Entry::Coordination {
            number: instance.number,
            record: None,
        });
    }

    /// Writes down how what runs by a plan stands.
    pub(super) fn store(&self, plan: usize, effects: &mut Effects) {
        if let Some(instance) = self.get(plan) {
            let robot = |robot: usize| self.names.robot_id(robot);
            let area = |area: usize| self.names.area_id(area);
            effects.entries.push(Entry::Coordination {
                number: instance.number,
                record: Some(instance.record(robot, area)),
            });
        }
    }

    /// An area that is kept for a robot was granted to it, or given back: perhaps it is kept no more.
    fn kept_changed(
        &mut self,
        robot: usize,
        area: usize,
        effects: &mut Effects,
        change: KeptChange,
    ) {
        for plan in self.plans_that_run() {
            let mut changed = false;
            for participant in self
                .get_mut(plan)
                .into_iter()
                .flat_map(|own| own.participants_mut())
            {
                if participant.robot == robot && participant.keeps(area) {
                    changed |= match change {
                        KeptChange::Granted => participant.granted(area),
                        KeptChange::GaveBack(how) => participant.gave_back(area, how),
                    };
                }
            }
            if changed {
                self.store(plan, effects);
            }
        }
    }
}

impl Reservations for Coordinations {
    fn kept(&self, area: usize) -> Vec<usize> {
        let participants = self
            .instances()
            .flat_map(|instance| instance.participants());
        participants
            .filter(|participant| participant.keeps(area))
            .map(|participant| participant.robot)
            .collect()
    }

    fn decide(&self, area: usize, robot: usize, stands_in: &[usize]) -> bool {
        if self.control_of(robot).is_some() {
            return true;
        }
        self.governed[area].is_some_and(|plan| {
            let governed = &self.plans[plan].governed;
            // As one whose process was started again in the middle of its passage: the net begins when that is empty.
            let is_caught = governed.iter().any(|area| stands_in.contains(area));
            self.get(plan).is_some() || !is_caught
        })
    }

    fn open(&self) -> Vec<Reserved> {
        let participants = self
            .instances()
            .flat_map(|instance| instance.participants());
        participants
            .flat_map(|participant| {
                let open = participant.kept.iter().filter(|kept| !kept.granted);
                open.map(|kept| Reserved {
                    area: kept.area,
                    robot: participant.robot,
                })
            })
            .collect()
    }

    fn granted(&mut self, robot: usize, area: usize, effects: &mut Effects) {
        self.look_again_at(robot);
        self.kept_changed(robot, area, effects, KeptChange::Granted);
    }

    fn gave_back(&mut self, robot: usize, area: usize, how: GivenBack, effects: &mut Effects) {
        let change = KeptChange::GaveBack(how);
        self.kept_changed(robot, area, effects, change);
    }
}
