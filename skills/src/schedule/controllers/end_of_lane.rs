//! Keeps on the lane, up to a distance from the wall at its end.

use super::behaviour::Behaviour;
use super::case::{Case, Lanes};
use super::motion::Motion;
use super::pace::{Pace, Progress};
use crate::control::{EndOfLane, Stopping};
use description::keys::KeyError;

pub(super) fn plan(case: &Case, distance_m: f64) -> Result<(EndOfLane, Lanes), KeyError> {
    let lane = case.lane()?;
    if case.geometry(lane).end.is_none() {
        return Err(case.no_lane("a lane that a wall closes"));
    }
    let end = EndOfLane {
        distance_m,
        exit_speed_m_s: case.graph.exit_speed_m_s(case.state),
    };
    Ok((end, case.on_lane(Some(lane))))
}

impl Behaviour for EndOfLane {
    fn pace(&self, _motion: &Motion, _stopping: &mut Stopping, now: &Progress) -> Pace {
        let (speed_m_s, done) = self.step(now.end_m, now.limit_m_s, now.speed_m_s, now.gains);
        let stops = self.exit_speed_m_s <= 0.0;
        Pace {
            speed_m_s,
            left_m: if stops {
                (now.end_m - self.distance_m).max(0.0)
            } else {
                f64::INFINITY
            },
            done,
            hold: None,
        }
    }
}
