//! Which robots fit the roles of plans, kept, and judged anew only for robots of which there is news: what a report costs does not
//! grow with the fleet.

use std::collections::BTreeSet;

use crate::nets::Plan;

/// What is known of who fits, and what is to be looked at again.
#[derive(Clone, Debug)]
pub(super) struct Candidates {
    /// By plan, situation and role.
    pub(super) fit: Vec<Vec<Vec<BTreeSet<usize>>>>,
    /// By robot: plans with a role that it may play.
    pub(super) plans_of: Vec<Vec<usize>>,
    /// Robots of which there is news, each once.
    pub(super) news: Vec<usize>,
    pub(super) has_news: Vec<bool>,
    /// Robots that count as mute.
    pub(super) mute: Vec<usize>,
    /// By plan: a robot that may play in it, or an area that its net governs, has changed since it was tried last.
    pub(super) due: Vec<bool>,
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
