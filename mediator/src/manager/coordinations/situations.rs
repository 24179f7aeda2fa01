//! Which situation has come, and which robots fit its roles.

use super::running::Coordinations;
use super::surroundings::Surroundings;
use crate::nets::{Cast, distinct};
use contract::wire::Instruction;

impl Coordinations {
    /// The first situation of a plan that has come, with a robot for each role.
    pub(super) fn situation(
        &self,
        plan: usize,
        around: &Surroundings<'_>,
    ) -> Option<(usize, Vec<usize>)> {
        let own = &self.plans[plan];
        let occupied = |&area: &usize| around.areas.occupants(area).next().is_some();
        if own.governed.iter().any(occupied) {
            return None;
        }
        (0..own.situations.len()).find_map(|situation| {
            let candidates = self.candidates.of(plan, situation);
            Some((situation, distinct(&candidates)?))
        })
    }

    /// What lets a robot go from a state into which it was sent to be out of the way, and in which it waits for nobody any more:
    /// it had restarted when it was let go.
    pub(crate) fn release_from(&self, robot: usize, state: &str) -> Option<Instruction> {
        if self.control_of(robot).is_some() {
            return None;
        }
        self.plans.iter().find_map(|plan| {
            let roles = plan
                .preempt
                .iter()
                .flat_map(|preempt| preempt.yields.iter().enumerate());
            let mut fitting = roles.filter(|(role, yields)| {
                let mut casts = plan
                    .situations
                    .iter()
                    .map(|situation| &situation.casts[*role]);
                yields.states.iter().any(|own| own == state) && casts.any(|cast| cast.names(robot))
            });
            fitting.find_map(|(_, yields)| yields.script.release())
        })
    }

    /// A robot may play the role of a situation, and is as that wants it.
    pub(super) fn fits(robot: usize, cast: &Cast, around: &Surroundings<'_>) -> bool {
        cast.names(robot) && Self::is_as_wanted(robot, cast, around)
    }

    /// A robot is as the role of a situation wants it.
    pub(super) fn is_as_wanted(robot: usize, cast: &Cast, around: &Surroundings<'_>) -> bool {
        let occupant = around.areas.robot(robot);
        let within = |region: &description::geometry::Rect| {
            { occupant.pose.as_ref() }
                .is_some_and(|pose| region.contains([pose.x_m, pose.y_m].into()))
        };
        around.sessions.is_heard(robot)
            && !around.sessions.robot(robot).without_control
            && occupant.located
            && occupant.placed
            && cast.holds.iter().all(|&area| occupant.holds(area))
            && cast.stands_in.iter().all(|&area| occupant.stands_in(area))
            && !cast.without.iter().any(|&area| occupant.occupies(area))
            && cast.asks.iter().all(|&area| occupant.waits_for(area))
            && (cast.states.is_empty() || cast.states.contains(&occupant.fsm_state))
            && cast.within.as_ref().is_none_or(within)
    }
}
