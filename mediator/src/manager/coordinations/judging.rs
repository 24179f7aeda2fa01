//! Judges anew which robots fit the roles of plans, as far as there is news.

use super::running::Coordinations;
use super::surroundings::Surroundings;

impl Coordinations {
    /// There may be news of a robot: of what it does, or of what it has.
    pub(crate) fn look_again_at(&mut self, robot: usize) {
        self.candidates.note_robot(robot);
    }

    /// Robots judged for roles since the start.
    pub(crate) fn looks(&self) -> u64 {
        self.candidates.looks
    }

    /// Judges anew what has changed, and notes for what runs it is news.
    pub(super) fn judge_news(&mut self, around: &mut Surroundings<'_>) {
        while let Some(area) = around.areas.take_news() {
            if let Some(plan) = self.governor_of(area) {
                self.candidates.note_plan(plan);
                self.note_running(plan);
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
        self.note_running_with(robot);
        let is_mute = self.is_mute(robot, around.now_ns);
        let is_controlled = self.control_of(robot).is_some();
        let parts = self.candidates.parts_to_judge(&self.plans, robot, is_mute);
        for part in parts {
            let cast = &self.plans[part.plan].situations[part.situation].casts[part.role];
            let is_free =
                !part.is_control || !is_controlled && Self::is_as_wanted(robot, cast, around);
            self.candidates.put(part, robot, is_free && !is_mute);
        }
    }
}
