//! Judges anew which robots fit the roles of plans, as far as there is news.

use super::running::Coordinations;
use super::surroundings::Surroundings;
use crate::nets::Kind;

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
