//! Which robots fit the roles of plans, kept, and judged anew only for robots of which there is news: what a report costs does not
//! grow with the fleet.

use std::collections::BTreeSet;

use crate::nets::{Kind, Plan};

/// A role of a plan, in one of its situations.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) plan: usize,
    pub(super) situation: usize,
    pub(super) role: usize,
    /// Who may play it is a question of how the robot is, and not only of its name.
    pub(super) is_control: bool,
}

/// Robots that fit a role, first those whose last coordination is longest ago: nobody is passed over for ever.
type Fit = BTreeSet<(u64, usize)>;

/// What is known of who fits, and what is to be looked at again.
#[derive(Clone, Debug)]
pub(super) struct Candidates {
    /// By plan, situation and role.
    fit: Vec<Vec<Vec<Fit>>>,
    /// By robot: the number of the last coordination that took over its discrete control, since the start; 0 for none.
    served: Vec<u64>,
    /// By robot: the roles that it may play with its discrete control.
    controls_of: Vec<Vec<Part>>,
    /// By robot: whether it counted as mute when it was judged last; none before.
    was_mute: Vec<Option<bool>>,
    /// Robots of which there is news, each once.
    pub(super) news: Vec<usize>,
    pub(super) has_news: Vec<bool>,
    /// Robots that count as mute.
    pub(super) mute: Vec<usize>,
    /// By plan: who fits its roles, or an area that its net governs, has changed since it was tried last.
    pub(super) due: Vec<bool>,
    /// How often a robot was judged for a role.
    pub(super) looks: u64,
}

impl Candidates {
    /// Nobody has been judged.
    pub(super) fn new(plans: &[impl AsRef<Plan>], robots: usize) -> Self {
        let situations = |plan: &Plan| {
            let casts =
                { plan.situations.iter() }.map(|situation| vec![Fit::new(); situation.casts.len()]);
            casts.collect()
        };
        let controls_of = |robot: usize| {
            let parts = parts_of(plans, robot);
            parts.filter(|part| part.is_control).collect()
        };
        Self {
            fit: plans.iter().map(|plan| situations(plan.as_ref())).collect(),
            served: vec![0; robots],
            controls_of: (0..robots).map(controls_of).collect(),
            was_mute: vec![None; robots],
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

    /// The roles of a robot that are to be judged anew: who has leave to play a role of protocol 1 changes only when it falls mute,
    /// or is heard again.
    pub(super) fn parts_to_judge(
        &mut self,
        plans: &[impl AsRef<Plan>],
        robot: usize,
        is_mute: bool,
    ) -> Vec<Part> {
        match self.was_mute[robot].replace(is_mute) == Some(is_mute) {
            true => self.controls_of[robot].clone(),
            false => parts_of(plans, robot).collect(),
        }
    }

    /// Whether a robot fits a role.
    pub(super) fn put(&mut self, part: Part, robot: usize, fits: bool) {
        self.looks += 1;
        let fit = &mut self.fit[part.plan][part.situation][part.role];
        let own = (self.served[robot], robot);
        let changed = match fits {
            true => fit.insert(own),
            false => fit.remove(&own),
        };
        self.due[part.plan] |= changed;
    }

    /// A coordination of this number takes the robot in: others come first next time.
    pub(super) fn serve(&mut self, robot: usize, number: u64) {
        let before = std::mem::replace(&mut self.served[robot], number);
        for fit in self.fit.iter_mut().flatten().flatten() {
            if fit.remove(&(before, robot)) {
                fit.insert((number, robot));
            }
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
            .map(|fit| {
                fit.iter()
                    .map(|&(_, robot)| robot)
                    .take(roles.len())
                    .collect()
            })
            .collect()
    }
}

/// All roles that a robot may play.
fn parts_of(plans: &[impl AsRef<Plan>], robot: usize) -> impl Iterator<Item = Part> {
    plans.iter().enumerate().flat_map(move |(plan, own)| {
        let situations = own.as_ref().situations.iter().enumerate();
        situations.flat_map(move |(situation, situation_plan)| {
            let roles = situation_plan.casts.iter().zip(&own.as_ref().roles);
            let named = roles
                .enumerate()
                .filter(move |(_, (cast, _))| cast.names(robot));
            named.map(move |(role, (_, role_plan))| Part {
                plan,
                situation,
                role,
                is_control: matches!(role_plan.kind, Kind::Control),
            })
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_was_taken_in_longest_ago_comes_first_and_whoever_was_not_before_all() {
        let part = Part {
            plan: 0,
            situation: 0,
            role: 0,
            is_control: true,
        };
        let mut own = Candidates::new(&[] as &[Box<Plan>], 3);
        (own.fit, own.due) = (vec![vec![vec![Fit::new()]]], vec![false]);
        (0..3).for_each(|robot| own.put(part, robot, true));
        let first = |own: &Candidates| own.of(0, 0)[0][0];
        for (number, robot) in [(1, 0), (2, 1), (3, 2), (4, 0)] {
            assert_eq!(first(&own), robot, "coordination {number}");
            own.serve(robot, number);
        }
        // Whoever does not fit for a while keeps its place.
        assert_eq!(first(&own), 1);
        own.put(part, 1, false);
        assert_eq!(first(&own), 2);
        own.put(part, 1, true);
        assert_eq!(first(&own), 1);
    }
}
