//! Drives a short way along the direction of the state's lane, and stops.

use super::behaviour::Behaviour;
use super::case::{Case, Lanes};
use super::motion::{Motion, Start};
use super::pace::{Hold, Pace, Progress};
use crate::control::{CREEP_SPEED_M_S, Creep, MAX_BACKWARD_M_S, Stopping};
use description::keys::KeyError;

/// Straight forward or backward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CreepBy {
    /// How far; negative: backward.
    pub distance_m: f64,
}

impl CreepBy {
    pub(super) fn plan(case: &Case, distance_m: f64) -> Result<(Self, Lanes), KeyError> {
        let own_m_s = case.skill.speed_m_s.unwrap_or(CREEP_SPEED_M_S);
        if distance_m < 0.0 && own_m_s > MAX_BACKWARD_M_S {
            return Err(case.impossible(format!(
                "backward at {own_m_s} m/s is faster than the {MAX_BACKWARD_M_S} m/s that a robot may drive blindly"
            )));
        }
        let lanes = case.on_lane(Some(case.lane()?));
        let lanes = Lanes {
            speed_limit_m_s: lanes.speed_limit_m_s.min(own_m_s),
            ..lanes
        };
        Ok((Self { distance_m }, lanes))
    }
}

impl Behaviour for CreepBy {
    fn motion(&self, start: &Start) -> Motion {
        let Start { onto, pose, .. } = *start;
        let direction_rad = onto.map_or(pose.theta_rad, |lane| lane.direction_rad());
        Motion::Creep(Creep::start(pose, direction_rad, self.distance_m))
    }

    fn pace(&self, motion: &Motion, stopping: &mut Stopping, now: &Progress) -> Pace {
        let Motion::Creep(creep) = motion else {
            return Pace::standing(Hold::StopPose);
        };
        now.backward().stop(stopping, creep.left_m(now.pose))
    }

    fn least_way_m(&self, _turn_rad: Option<f64>) -> f64 {
        self.distance_m.abs()
    }
}
