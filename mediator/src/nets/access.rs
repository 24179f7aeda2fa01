//! Robots that are only let into areas: protocol 1.

use std::sync::Arc;

use super::instance::Instance;
use super::participant::Participant;
use super::plan::Kind;
use coordination::protocol::{Position, Side};

impl Instance {
    /// The areas that the net lets a role into, while its robot is in the middle of nothing: another one may take the role.
    pub(crate) fn open_areas(&self, role: usize) -> Option<Vec<usize>> {
        let Kind::Access(passages) = &self.plan.roles[role].kind else {
            return None;
        };
        let participant = &self.participants()[role];
        let at_start = participant.own_position() == Some(Position::START)
            && participant.read_to() == Position::START;
        let areas = passages
            .iter()
            .flat_map(|passage| passage.areas.iter().copied());
        (at_start && participant.kept.is_empty()).then(|| areas.collect())
    }

    /// Another robot takes a role that is open.
    pub(crate) fn exchange(&mut self, role: usize, robot: usize) {
        let plan = Arc::clone(&self.plan);
        self.participants_mut()[role] = Participant::new(robot, &plan.roles[role].script, true);
    }

    /// The net has let the robot of a role into an area, and knows that it may still be there.
    pub(crate) fn lets_in(&self, role: usize, area: usize) -> bool {
        let Kind::Access(passages) = &self.plan.roles[role].kind else {
            return false;
        };
        let Some(at) = self.participants()[role].own_position() else {
            return false;
        };
        { passages.iter() }.any(|passage| passage.is_within(at) && passage.areas.contains(&area))
    }

    /// Follows protocol 1 of a role's robot: `asks`, `has` and `is_in` say how it stands with an area.
    pub(crate) fn follow_access(
        &mut self,
        role: usize,
        asks: impl Fn(usize) -> bool,
        has: impl Fn(usize) -> bool,
        is_in: impl Fn(usize) -> bool,
    ) -> bool {
        let plan = Arc::clone(&self.plan);
        let Kind::Access(passages) = &plan.roles[role].kind else {
            return false;
        };
        let participant = &mut self.participants_mut()[role];
        participant.tell_own();
        let Some(at) = participant.own_position() else {
            return false;
        };
        let mut changed = false;
        if at == Position::START {
            let wants = |areas: &[usize]| {
                areas.iter().all(|&area| asks(area) || has(area)) && areas.iter().any(|&a| asks(a))
            };
            if let Some(passage) = passages.iter().find(|passage| wants(&passage.areas)) {
                changed |= participant.set_own(passage.request);
            }
            return changed;
        }
        for passage in passages {
            let none_left = !passage.areas.iter().any(|&area| has(area));
            if passage.is_within(at) && !none_left {
                // It has to go back, or gave an area back by a pose that was wrong, and would wait for itself. What the net lets others
                // into meanwhile is its affair: two where one fits there never are.
                for &area in &passage.areas {
                    if asks(area) && !participant.keeps(area) {
                        participant.keep(&[area]);
                        changed = true;
                    }
                }
            }
            // It has given all back without entering, or was in and out again before that was seen.
            let waits = |&area: &usize| asks(area) && participant.keeps(area);
            let gave_up = none_left && !passage.areas.iter().any(waits);
            let entered = passage.areas.iter().any(|&area| is_in(area));
            if at == passage.granted_at && (entered || gave_up) {
                changed |= participant.set_own(passage.entered);
            }
            let at = participant.own_position();
            if at == Some(passage.entered_at) && none_left && participant.set_own(passage.released)
            {
                participant.kept.clear();
                changed = true;
            }
        }
        changed
    }
}
