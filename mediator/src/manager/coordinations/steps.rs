//! Going on: starting, stepping, breaking off and ending.

use super::running::Coordinations;
use super::surroundings::Surroundings;
use crate::manager::alarm::Alarm;
use crate::manager::areas::Areas;
use crate::nets::{Instance, Phase};

/// At most this many steps that lead to another are followed at once.
const STEPS: usize = 8;

impl Coordinations {
    /// Lets all coordinations go on as far as they can, and starts those whose situation has come.
    pub(crate) fn go_on(&mut self, around: &mut Surroundings<'_>) {
        if self.plans.is_empty() || !around.sessions.awaited().is_empty() {
            return;
        }
        self.judge_news(around);
        for plan in self.take_running_due() {
            self.step(plan, around);
        }
        for plan in 0..self.plans.len() {
            self.judge_news(around);
            if self.get(plan).is_some() || !self.candidates.take_due(plan) {
                continue;
            }
            self.empty(plan, around);
            if around.now_ns < self.held_off_ns[plan] {
                self.candidates.note_plan(plan);
                continue;
            }
            if let Some((situation, robots)) = self.situation(plan, around) {
                let number = self.next_number(around.effects);
                let own = &self.plans[plan];
                let instance = Instance::start(own, number, situation, &robots, around.now_ns);
                self.begin(plan, instance);
                self.changed(plan, around);
                self.step(plan, around);
            }
        }
    }

    /// A net that decides about areas begins when they are empty: whoever has one of them meanwhile, and is not there yet, stays
    /// out. It may meet a robot that the net does not know of.
    fn empty(&self, plan: usize, around: &mut Surroundings<'_>) {
        for &area in &self.plans[plan].governed {
            around.areas.revoke_what_is_not_used(area, around.effects);
        }
    }

    fn step(&mut self, plan: usize, around: &mut Surroundings<'_>) {
        if let Some((robot, area)) = self.bypass(plan, around.areas) {
            let is_its_own = !around.areas.robot(robot).is_only_said_to_be_in(area);
            let coordination = self.name(plan);
            let (robot, area) = (self.names.robot_id(robot), self.names.area_id(area));
            around.effects.alarms.push(if is_its_own {
                Alarm::Bypassed {
                    coordination,
                    robot,
                    area,
                }
            } else {
                Alarm::BypassedBySecond {
                    coordination,
                    robot,
                    area,
                }
            });
            self.end(plan, around);
            return;
        }
        around.effects.counters.steps += 1;
        let mut changed = self.exchange(plan, around);
        for step in 1..=STEPS {
            let Some(instance) = self.get_mut(plan) else {
                return;
            };
            let mut went_on = false;
            for role in 0..instance.participants().len() {
                let number = instance.participants()[role].robot;
                let robot = around.areas.robot(number);
                let can = around.areas.can_use_grants(number, around.sessions);
                went_on |= instance.follow_access(
                    role,
                    // Who cannot use a grant has nothing kept for it: it would keep everybody else out, perhaps for ever.
                    |area| can && robot.waits_for(area),
                    |area| robot.holds(area),
                    |area| robot.has_entered(area),
                );
            }
            went_on |= instance.step(around.now_ns).changed;
            went_on |= self.after_yielding(plan, around);
            changed |= went_on;
            if !went_on {
                break;
            }
            if step == STEPS {
                self.note_running(plan);
            }
        }
        if changed {
            self.changed(plan, around);
        }
        if self.get(plan).is_some_and(Instance::is_over) {
            self.end(plan, around);
        }
    }

    /// A role of protocol 1 whose robot wants nothing of the net, or cannot use what it wants, goes to the one that has waited
    /// longest for it: nets serve whoever comes, not those that were there first.
    fn exchange(&mut self, plan: usize, around: &Surroundings<'_>) -> bool {
        let Some(instance) = self.get(plan) else {
            return false;
        };
        let Phase::Running { situation, .. } = instance.phase else {
            return false;
        };
        let areas_of = |robot: usize| around.areas.robot(robot);
        let can = |robot: usize| around.areas.can_use_grants(robot, around.sessions);
        let mut takes: Vec<(usize, usize)> = Vec::new();
        for (role, cast) in instance.plan.situations[situation].casts.iter().enumerate() {
            let Some(open) = instance.open_areas(role) else {
                continue;
            };
            let number = instance.participants()[role].robot;
            let (present, can_go) = (areas_of(number), can(number));
            let wants = |area: usize| can_go && present.waits_for(area);
            if { open.iter() }.any(|&area| present.occupies(area) || wants(area)) {
                continue;
            }
            // Those who wait are few, however many robots may play the role.
            let waiting = open.iter().flat_map(|&area| {
                let queue = around.areas.area(area).queue.iter();
                queue.map(move |&robot| (areas_of(robot).claim(area), robot))
            });
            let comes = waiting
                .filter_map(|(claim, robot)| Some((claim?.asked_ns, robot)))
                .filter(|&(_, robot)| {
                    instance.role_of(robot).is_none()
                        && takes.iter().all(|&(_, taken)| taken != robot)
                        && can(robot)
                        && cast.names(robot)
                })
                .min();
            takes.extend(comes.map(|(_, robot)| (role, robot)));
        }
        for &(role, robot) in &takes {
            self.look_again_at(robot);
            if let Some(instance) = self.get_mut(plan) {
                instance.exchange(role, robot);
            }
        }
        !takes.is_empty()
    }

    /// A robot that is where the net has not let it in, or another body with its name, which no net lets in: the net does not know how
    /// things are.
    fn bypass(&self, plan: usize, areas: &Areas) -> Option<(usize, usize)> {
        let instance = self.get(plan)?;
        let governed = instance.plan.governed.iter();
        let mut occupied =
            governed.flat_map(|&area| areas.occupants(area).map(move |robot| (robot, area)));
        occupied.find(|&(robot, area)| {
            let role = instance.role_of(robot);
            let is_let_in = role.is_some_and(|role| instance.lets_in(role, area));
            !is_let_in || areas.robot(robot).has_other_body_in(area)
        })
    }

    /// Once all robots are out of the way: begins again in the safe situation, or lets them go.
    fn after_yielding(&mut self, plan: usize, around: &mut Surroundings<'_>) -> bool {
        let Some(instance) = self.get(plan) else {
            return false;
        };
        let Some(preempt) = { instance.plan.preempt.as_ref() }
            .filter(|_| matches!(instance.phase, Phase::Yielding(_)))
        else {
            return false;
        };
        let out_of_the_way = |role: usize| {
            let robot = instance.participants()[role].robot;
            let state = &around.areas.robot(robot).fsm_state;
            instance.participants()[role].is_over()
                || instance.has_read_halt(role)
                    && around.sessions.is_heard(robot)
                    && preempt.yields[role].states.contains(state)
        };
        let releases = instance.releases();
        if !releases && !(0..instance.participants().len()).all(out_of_the_way) {
            return false;
        }
        let robots = instance.robots();
        let whole = { instance.participants().iter() }.all(|own| !own.is_over());
        let again = preempt.situation.filter(|&situation| {
            let casts = &instance.plan.situations[situation].casts;
            let mut cast_robots = robots.iter().zip(casts);
            !releases && whole && cast_robots.all(|(&robot, cast)| Self::fits(robot, cast, around))
        });
        if let Some(situation) = again {
            let number = self.next_number(around.effects);
            let own = &self.plans[plan];
            let next = Instance::start(own, number, situation, &robots, around.now_ns);
            self.follow_with(plan, next, around);
            return true;
        }
        { self.get_mut(plan) }.is_some_and(|instance| instance.release(around.now_ns))
    }

    /// Stores it, tells its robots, and looks at all areas again.
    fn changed(&mut self, plan: usize, around: &mut Surroundings<'_>) {
        self.store(plan, around.effects);
        let Some(instance) = self.get(plan) else {
            return;
        };
        around.news_for(instance);
        for robot in instance.robots() {
            self.look_again_at(robot);
        }
    }

    /// Another run, with another number, in the place of this one.
    fn follow_with(&mut self, plan: usize, next: Instance, around: &mut Surroundings<'_>) {
        self.replace(plan, next, around.now_ns, around.effects);
        self.changed(plan, around);
    }

    pub(super) fn end(&mut self, plan: usize, around: &mut Surroundings<'_>) {
        let Some(instance) = self.remove(plan, around.now_ns, around.effects) else {
            return;
        };
        if matches!(instance.phase, Phase::Yielding(_)) {
            // What stood still would stand still again at once.
            self.held_off_ns[plan] = around.now_ns.saturating_add(instance.plan.alarm_after_ns);
        }
        around.news_for(&instance);
    }

    /// A coordination that cannot go on: its robots get out of the way, or else are let go.
    pub(super) fn break_off(&mut self, plan: usize, around: &mut Surroundings<'_>) {
        if self.plans[plan].preempt.is_none() {
            self.end(plan, around);
            return;
        }
        let number = self.next_number(around.effects);
        let Some(next) = { self.get(plan) }.map(|own| own.yielding(number, around.now_ns)) else {
            return;
        };
        self.follow_with(plan, next, around);
    }

    /// An operator ends a coordination: its robots get out of the way where the site says how, and are let go the second time.
    /// Returns whether they are let go; none if no such coordination runs.
    pub(crate) fn end_by_hand(
        &mut self,
        named: &str,
        around: &mut Surroundings<'_>,
    ) -> Option<(String, bool)> {
        let runs = self.plans_that_run();
        let plan = runs.into_iter().find(|&plan| {
            let number = self.get(plan).map(|own| own.number.to_string());
            self.plans[plan].id == named
                || self.name(plan) == named
                || number.as_deref() == Some(named)
        })?;
        let name = self.name(plan);
        let yields = self
            .get(plan)
            .is_some_and(|own| matches!(own.phase, Phase::Running { .. }))
            && self.plans[plan].preempt.is_some();
        if yields {
            self.break_off(plan, around);
        } else {
            self.end(plan, around);
            // What was ended would begin again at once; without a net that decides about areas, nobody would be let into them.
            let own = &self.plans[plan];
            if own.governed.is_empty() {
                self.held_off_ns[plan] = around.now_ns.saturating_add(own.alarm_after_ns);
            }
        }
        Some((name, !yields))
    }

    /// What runs, by the names that operators use.
    pub(crate) fn names_that_run(&self) -> Vec<String> {
        self.plans_that_run()
            .into_iter()
            .map(|plan| self.name(plan))
            .collect()
    }

    /// An operator has cleared a robot away: what controls it is given up, and the others are let go.
    pub(crate) fn cleared_of(&mut self, robot: usize, around: &mut Surroundings<'_>) {
        for plan in self.plans_that_control(robot) {
            self.end(plan, around);
        }
    }
}
