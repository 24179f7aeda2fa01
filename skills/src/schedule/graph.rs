//! What the machine's transitions say about the states around a state.

use crate::map::SemanticMap;
use coordination::fsm::{Machine, StateId};
use description::areas::AreaIndex;
use description::site::{ControllerConfig, Site, SkillConfig};
use std::collections::VecDeque;

/// Skill and area of a state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound {
    pub(super) skill: usize,
    pub(super) area: AreaIndex,
    pub(super) lane: Option<usize>,
}

#[derive(Clone, Copy)]
pub(super) enum Towards {
    Before,
    After,
}

/// The machine's states with what is bound to them.
pub(super) struct Graph<'a> {
    pub(super) map: &'a SemanticMap,
    pub(super) machine: &'a Machine,
    pub(super) site: &'a Site,
    pub(super) role: &'a str,
    pub(super) max_speed_m_s: f64,
    pub(super) bound: Vec<Bound>,
}

impl Graph<'_> {
    pub(super) fn of(&self, state: StateId) -> Bound {
        self.bound[state.index()]
    }

    pub(super) fn skill(&self, state: StateId) -> &SkillConfig {
        &self.site.skills[self.of(state).skill]
    }

    /// Fastest speed in a state: of its area, its skill and the robot.
    pub(super) fn speed_limit_m_s(&self, state: StateId) -> f64 {
        let area_m_s = self.map.area(self.of(state).area).speed_limit_m_s;
        let skill_m_s = self.skill(state).speed_m_s.unwrap_or(f64::INFINITY);
        area_m_s.min(skill_m_s).min(self.max_speed_m_s)
    }

    /// The lowest speed limit of the states that follow and move forward; 0 when none does, or one moves backward.
    pub(super) fn exit_speed_m_s(&self, state: StateId) -> f64 {
        let speed_m_s = |next: StateId| match self.skill(next).controller {
            ControllerConfig::Stop => None,
            ControllerConfig::Creep { distance_m } if distance_m < 0.0 => Some(0.0),
            _ => Some(self.speed_limit_m_s(next)),
        };
        self.machine
            .transitions()
            .filter(|transition| transition.from == state && transition.to != state)
            .filter_map(|transition| speed_m_s(transition.to))
            .min_by(f64::total_cmp)
            .unwrap_or(0.0)
    }

    /// The states from which one transition leads here.
    pub(super) fn just_before(&self, state: StateId) -> impl Iterator<Item = StateId> {
        self.machine
            .transitions()
            .filter(move |transition| transition.to == state && transition.from != state)
            .map(|transition| transition.from)
    }

    /// The lane of the nearest state with one (other than `except`), along the transitions.
    pub(super) fn nearest_lane(
        &self,
        state: StateId,
        towards: Towards,
        except: Option<usize>,
    ) -> Option<usize> {
        let mut waiting = VecDeque::from([state]);
        let mut seen = vec![false; self.bound.len()];
        seen[state.index()] = true;
        while let Some(at) = waiting.pop_front() {
            for transition in self.machine.transitions() {
                let (here, next) = match towards {
                    Towards::Before => (transition.to, transition.from),
                    Towards::After => (transition.from, transition.to),
                };
                if here != at || seen[next.index()] {
                    continue;
                }
                seen[next.index()] = true;
                let bound = self.bound[next.index()];
                if let Some(lane) = bound.lane.filter(|lane| Some(*lane) != except) {
                    return Some(lane);
                }
                waiting.push_back(next);
            }
        }
        None
    }
}
