//! Which robots fit the roles of plans, kept, and judged anew only for robots of which there is news: what a report costs does not
//! grow with the fleet.

use std::collections::BTreeSet;

use super::running::Coordinations;
use super::surroundings::Surroundings;
use crate::nets::{Kind, Plan};

/// What is known of who fits, and what is to be looked at again.
#[derive(Clone, Debug)]
pub(super) struct Candidates {
    /// By plan, situation and role.
    fit: Vec<Vec<Vec<BTreeSet<usize>>>>,
    /// By robot: plans with a role that it may play.
    plans_of: Vec<Vec<usize>>,
    /// Robots of which there is news, each once.
    news: Vec<usize>,
    has_news: Vec<bool>,
    /// Robots that count as mute.
    mute: Vec<usize>,
    /// By plan: a robot that may play in it, or an area that its net governs, has changed since it was tried last.
    due: Vec<bool>,
    /// How often a robot was judged for a role.
    pub(super) looks: u64,
}

impl Candidates {
    /// Nobody has been judged.
    pub(super) fn new(plans: &[impl AsRef<Plan>], robots: usize) -> Self {
        let situations = |plan: &Plan| {
            let casts = { plan.situations.iter() }
                .map(|situation| vec![BTreeSet::new(); situation.casts.len()]);
            casts.collect()
        };
        let plays = |plan: &Plan, robot: usize| {
            let mut casts = { plan.situations.iter() }.flat_map(|own| &own.casts);
            casts.any(|cast| cast.names(robot))
        };
        let plans_of = |robot: usize| {
            let all = plans.iter().enumerate();
            all.filter(|(_, plan)| plays(plan.as_ref(), robot))
                .map(|(index, _)| index)
                .collect()
        };
        Self {
            fit: plans.iter().map(|plan| situations(plan.as_ref())).collect(),
            plans_of: (0..robots).map(plans_of).collect(),
            news: (0..robots).collect(),
            has_news: vec![true; robots],
            mute: Vec::new(),
            due: vec![true; plans.len()],
            looks: 0,
        }
    }

    pub(super) fn note_robot(&mut self, robot: usize) {
        if !std::mem::replace(&mut self.has_news[robot], true) {
            self.news.push(robot);
        }
    }

    /// It is mute, until it is said not to be, or its time is over.
    pub(super) fn note_mute(&mut self, robot: usize) {
        self.note_robot(robot);
        if !self.mute.contains(&robot) {
            self.mute.push(robot);
        }
    }

    pub(super) fn note_plan(&mut self, plan: usize) {
        self.due[plan] = true;
    }

    /// Whether the plan is to be tried; from now on it is not.
    pub(super) fn take_due(&mut self, plan: usize) -> bool {
        std::mem::take(&mut self.due[plan])
    }

    /// Of those that fit the roles of a situation, as many of each as matter: of so many, one is in no other role.
    pub(super) fn of(&self, plan: usize, situation: usize) -> Vec<Vec<usize>> {
        let roles = &self.fit[plan][situation];
        { roles.iter() }
            .map(|fit| fit.iter().copied().take(roles.len()).collect())
            .collect()
    }
}

impl Coordinations {
    /// There may be news of a robot: of what it does, or of what it has.
    pub(crate) fn look_again_at(&mut self, robot: usize) {
        self.candidates.note_robot(robot);
    }

    /// Robots judged for roles since the start.
    pub(crate) fn looks(&self) -> u64 {
        self.candidates.looks
    }

    /// Judges anew what has changed.
    pub(super) fn judge_news(&mut self, around: &mut Surroundings<'_>) {
        while let Some(area) = around.areas.take_news() {
            if let Some(plan) = self.governor_of(area) {
                self.candidates.note_plan(plan);
            }
        }
        let mut mute = std::mem::take(&mut self.candidates.mute);
        mute.retain(|&robot| {
            let is_mute = self.is_mute(robot, around.now_ns);
            if !is_mute {
                self.candidates.note_robot(robot);
            }
            is_mute
        });
        self.candidates.mute = mute;
        while let Some(robot) = self.candidates.news.pop() {
            self.candidates.has_news[robot] = false;
            self.judge(robot, around);
        }
    }

    fn judge(&mut self, robot: usize, around: &Surroundings<'_>) {
        let is_mute = self.is_mute(robot, around.now_ns);
        let is_controlled = self.control_of(robot).is_some();
        let own = &mut self.candidates;
        for &plan in &own.plans_of[robot] {
            own.due[plan] = true;
            let roles = &self.plans[plan].roles;
            for (situation, fit) in self.plans[plan].situations.iter().zip(&mut own.fit[plan]) {
                for ((cast, role), fit) in situation.casts.iter().zip(roles).zip(fit) {
                    own.looks += 1;
                    let fits = match role.kind {
                        Kind::Access(_) => cast.names(robot),
                        Kind::Control => !is_controlled && Self::fits(robot, cast, around),
                    };
                    if fits && !is_mute {
                        fit.insert(robot);
                    } else {
                        fit.remove(&robot);
                    }
                }
            }
        }
    }
}
