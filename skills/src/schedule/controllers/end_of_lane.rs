//! Keeps on the lane, up to a distance from the wall at its end.

use super::behaviour::Behaviour;
use super::case::{Case, Lanes};
use super::motion::Motion;
use super::pace::{Pace, Progress};
use crate::control::{EndOfLane, Stopping};
use crate::schedule::error::ScheduleError;

pub(super) fn plan(
    case: &Case,
    distance_m: f64,
    exit_speed_m_s: Option<f64>,
) -> Result<(EndOfLane, Lanes), ScheduleError> {
    case.skill.check_positive("distance", distance_m)?;
    let lane = case.lane()?;
    if case.geometry(lane).end.is_none() {
        return Err(case.no_lane("a lane that a wall closes"));
    }
    let exit_speed_m_s = exit_speed_m_s.unwrap_or_else(|| case.graph.exit_speed_m_s(case.state));
    case.skill
        .check_not_negative("exit speed", exit_speed_m_s)?;
    let end = EndOfLane {
        distance_m,
        exit_speed_m_s,
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
