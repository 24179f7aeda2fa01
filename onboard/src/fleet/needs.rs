//! Which areas the robot needs: what its next manoeuvres take, and what it can no longer stop before.

use description::areas::AreaIndex;
use skills::borders::AreaSet;

use super::floor::{Floor, UncertainPose};
use super::route::look_ahead;
use super::sense::Sense;
use super::setup::Setup;

/// From a message of the mediator until navigation obeys it: one cycle of navigation, the braking delay that it assumes, and
/// a reserve.
const REACTION_S: f64 = 0.3;
/// Slower than this is standing.
const STANDING_M_S: f64 = 0.02;
/// An area stays wanted until the robot is `KEEP_M` farther away than where the fastest robot asks for it (hysteresis).
const KEEP_M: f64 = 0.5;

/// What the robot's needs follow from.
pub(super) struct Needs<'a> {
    /// Robot and site.
    pub(super) setup: &'a Setup,
    /// The areas under the footprint.
    pub(super) floor: &'a Floor,
    /// Areas that it holds.
    pub(super) held: AreaSet,
    /// The same, and those that it held before it was placed anew.
    pub(super) may_hold: AreaSet,
    /// Areas that it wanted before.
    pub(super) wanted: AreaSet,
}

impl Needs<'_> {
    /// Areas to ask for, in the order of asking, and those that must not be entered yet although they are held: a manoeuvre
    /// that takes several areas begins when it has them all.
    pub(super) fn wanted(
        &self,
        sense: &Sense,
        place: &UncertainPose,
        stands_in: &AreaSet,
    ) -> (Vec<AreaIndex>, AreaSet) {
        let mut wanted: Vec<AreaIndex> = stands_in.iter().collect();
        let mut held_back = AreaSet::EMPTY;
        let state = sense.state.filter(|&state| state < self.setup.states.len());
        if let Some(state) = state {
            let states = &self.setup.states;
            let present = &states[state].areas;
            wanted.extend(present);
            let ask_m = self.stopping_m(sense.speed_m_s) + self.setup.request_ahead_m;
            let keep_m =
                self.stopping_m(self.setup.max_speed_m_s) + self.setup.request_ahead_m + KEEP_M;
            let was_wanted = |state: usize| {
                let mut new = states[state].areas.iter();
                new.any(|&area| self.wanted.contains(area) && !present.contains(&area))
            };
            let upcoming = look_ahead(
                states,
                state,
                |area| self.floor.gap_m(area, place),
                |state, way_m| way_m <= ask_m || way_m <= keep_m && was_wanted(state),
            );
            let mut complete = AreaSet::EMPTY;
            for next in &upcoming {
                let areas = &states[next.state].areas;
                wanted.extend(areas);
                let whole = areas.iter().all(|&area| self.held.contains(area));
                for &area in areas {
                    let set = if whole { &mut complete } else { &mut held_back };
                    set.insert(area);
                }
            }
            held_back = held_back.difference(&complete);
            held_back = held_back.difference(&present.iter().copied().collect());
        }
        // Wherever its path leads: it needs the area that keeps it from going on.
        wanted.extend(sense.waiting_for);
        let mut seen = AreaSet::EMPTY;
        wanted.retain(|&area| seen.insert(area));
        (wanted, held_back)
    }

    /// Held areas that the robot does not stand in and may reach into before it stops, or may be in already for all that is
    /// known. One that stands before a border can go on standing there, however near it is.
    pub(super) fn committed(&self, place: &UncertainPose, speed_m_s: f64) -> AreaSet {
        let moves = speed_m_s.abs() > STANDING_M_S || !speed_m_s.is_finite();
        let reach_m = self.stopping_m(speed_m_s);
        self.setup
            .area_indices()
            .filter(|&area| self.may_hold.contains(area))
            .filter(|&area| {
                let near = || reach_m.is_nan() || self.floor.gap_m(area, place) <= reach_m;
                let drives_in = moves && self.held.contains(area) && near();
                self.floor.may_be_in(area, place) || drives_in
            })
            .collect()
    }

    /// Distance driven from a message of the mediator to a stop that it demands.
    fn stopping_m(&self, speed_m_s: f64) -> f64 {
        let speed_m_s = speed_m_s.abs();
        speed_m_s * speed_m_s / (2.0 * self.setup.deceleration_m_s2) + speed_m_s * REACTION_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fleet::tests::{at, setup};

    #[test]
    fn one_that_stands_before_a_border_can_go_on_standing_there() {
        let (setup, held) = (setup(), [AreaIndex(0), AreaIndex(1)].into_iter().collect());
        let needs = Needs {
            floor: &Floor::new(&setup),
            setup: &setup,
            held,
            may_hold: held,
            wanted: AreaSet::EMPTY,
        };
        // Its front is a few centimetres before the border to area 2.
        let committed = |std_m, speed_m_s| -> Vec<usize> {
            let all = needs.committed(&at(5.16, -0.5, 0.0, std_m), speed_m_s);
            all.iter().map(AreaIndex::place).collect()
        };
        assert_eq!(committed(0.002, 0.0), [0]);
        assert_eq!(committed(0.002, 0.05), [0, 1], "it moves");
        assert_eq!(committed(0.002, f64::NAN), [0, 1], "it may move");
        assert_eq!(committed(0.05, 0.0), [0, 1], "it may be in it");
    }
}
