//! Keeps on the lane and stops at a place on it: before a border, at a pose, or where an instruction says. A robot that has driven
//! past a place of its file, as after a stop for a fault, comes back to it.

use super::behaviour::Behaviour;
use super::case::{Case, Lanes};
use super::motion::{Motion, Start, pose_error};
use super::pace::{Hold, Pace, Progress};
use crate::control::{CREEP_SPEED_M_S, Creep, Stopping};
use crate::map::LaneGeometry;
use crate::schedule::room::border_ahead_m;
use description::geometry::{Pose2, wrap_angle};
use description::keys::KeyError;
use description::site::StopPlace;

/// Largest angle and distance between a stop pose in a file and its lane.
const PLANNED_HEADING_RAD: f64 = 0.2;
const PLANNED_BESIDE_M: f64 = 0.3;
/// Largest angle and distance between a stop pose of an instruction and the robot's path.
const INSTRUCTED_HEADING_RAD: f64 = 0.3;
const INSTRUCTED_BESIDE_M: f64 = 0.5;
/// A place counts as missed when it lies this far behind the robot,
const MISSED_M: f64 = 0.05;
/// and up to this far the robot creeps back to it.
const BACK_UP_M: f64 = 0.5;

/// Along [`Schedule::lane`](crate::schedule::Schedule::lane) to a place on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StopAt {
    /// The footprint, and the uncertainty of the pose, before a border.
    Border {
        /// Along the lane, of the border.
        along_m: f64,
        /// From the footprint to it.
        margin_m: f64,
    },
    /// `base_link` there.
    Pose {
        /// Along the lane.
        along_m: f64,
        /// Of the path from the lane's centre, positive to the left.
        offset_m: f64,
    },
    /// Where the instruction says.
    Instructed,
}

impl StopAt {
    pub(super) fn plan(case: &Case, target: &StopPlace) -> Result<(Self, Lanes), KeyError> {
        let lane = case.lane()?;
        let place = match target {
            StopPlace::Instructed => Self::Instructed,
            StopPlace::BeforeArea { area, margin_m } => Self::before(case, lane, area, *margin_m)?,
            StopPlace::Pose(pose) => Self::at(case, lane, *pose)?,
        };
        Ok((place, case.on_lane(Some(lane))))
    }

    fn before(case: &Case, lane: usize, area: &str, margin_m: f64) -> Result<Self, KeyError> {
        let lane = case.geometry(lane);
        let found = case.map().area_index(area);
        let region = found.ok_or_else(|| {
            let key = format!("skills.{}.before_area", case.skill.id);
            KeyError::unknown(key, "area", area)
        })?;
        let region = &case.map().area(region).region;
        let footprint = &case.robot.footprint;
        let wrong = |verb: &str| {
            let found = format!(
                "area `{area}`, which lane `{}` of state `{}` {verb}",
                lane.id, case.name
            );
            let expected = "an area ahead on the state's lane, with room to stop before it";
            case.skill_error("before_area", found, expected.to_owned())
        };
        let along_m = border_ahead_m(&lane.line, region, footprint)
            .filter(|along_m| *along_m > 0.0)
            .ok_or_else(|| wrong("does not lead to"))?;
        if along_m - margin_m - footprint.front_m <= 0.0 {
            return Err(wrong("begins too close to"));
        }
        Ok(Self::Border { along_m, margin_m })
    }

    /// The pose must lie in the state's areas, on the lane or beside it, in the lane's direction.
    fn at(case: &Case, index: usize, pose: Pose2) -> Result<Self, KeyError> {
        let lane = case.geometry(index);
        let at = pose.position();
        let along_m = lane.line.along_m(at);
        let offset_m = lane.line.lateral_m(at);
        let off_rad = wrap_angle(pose.theta_rad - lane.direction_rad);
        let area = case.map().area(case.graph.of(case.state).area);
        let beside_m = area.deviation_limit_m.min(PLANNED_BESIDE_M);
        let off_m = lane.line.distance_m(at);
        if off_rad.abs() > PLANNED_HEADING_RAD || off_m > beside_m || !case.takes(at) {
            let found = format!(
                "({:?}, {:?}, {:?} rad), {off_m:.3} m from lane `{}` of state `{}`",
                at.x_m, at.y_m, pose.theta_rad, lane.id, case.name
            );
            let expected = format!(
                "a pose in the state's areas, at most {beside_m} m from its lane and at most {PLANNED_HEADING_RAD} rad off its direction"
            );
            return Err(case.skill_error("pose", found, expected));
        }
        case.check_offset(index, offset_m)?;
        Ok(Self::Pose { along_m, offset_m })
    }
}

impl Behaviour for StopAt {
    fn motion(&self, _start: &Start) -> Motion {
        Motion::Lane {
            offset_m: self.offset_m(),
        }
    }

    fn pace(&self, motion: &Motion, stopping: &mut Stopping, now: &Progress) -> Pace {
        if let Motion::Creep(back) = motion {
            let pace = now.backward().stop(stopping, back.left_m(now.pose));
            return Pace {
                speed_m_s: pace.speed_m_s.min(CREEP_SPEED_M_S),
                ..pace
            };
        }
        match *self {
            Self::Border { along_m, margin_m } => {
                let bare_m = along_m - margin_m - now.front_along_m();
                if bare_m < -MISSED_M && !stopping.arrived() {
                    return Pace::standing(Hold::StopPose);
                }
                now.stop(stopping, bare_m - now.margin_m)
            }
            Self::Pose { along_m, .. } => stop_there(along_m, motion, stopping, now),
            Self::Instructed if now.instructed => Pace::FREE,
            Self::Instructed => Pace::standing(Hold::NoStopPose),
        }
    }

    fn back_up(&self, now: &Progress) -> Option<Motion> {
        let lane = now.lane?;
        let left_m = match *self {
            Self::Border { along_m, margin_m } => {
                along_m - margin_m - now.front_along_m() - now.margin_m
            }
            Self::Pose { along_m, .. } => along_m - lane.line.along_m(now.pose.position()),
            Self::Instructed => return None,
        };
        (-BACK_UP_M..-MISSED_M)
            .contains(&left_m)
            .then(|| Motion::Creep(Creep::start(now.pose, lane.direction_rad, left_m)))
    }

    fn offset_m(&self) -> f64 {
        match *self {
            Self::Pose { offset_m, .. } => offset_m,
            Self::Border { .. } | Self::Instructed => 0.0,
        }
    }
}

fn stop_there(along_m: f64, motion: &Motion, stopping: &mut Stopping, now: &Progress) -> Pace {
    let left_m = along_m - now.along_m(motion);
    if left_m < -MISSED_M && !stopping.arrived() {
        return Pace::standing(Hold::StopPose);
    }
    now.stop(stopping, left_m)
}

/// The stop pose of an instruction, in the terms of the path that the robot is on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum InstructedStop {
    /// `base_link` at a place along the path, this far beside it.
    Place { along_m: f64, aside_m: f64 },
    /// It cannot be reached from here.
    Impossible,
    /// The robot stands anyway.
    Standing,
}

impl InstructedStop {
    pub fn on(motion: &Motion, lane: Option<&LaneGeometry>, stop: Pose2) -> Self {
        let (along_m, aside_m, direction_rad) = match (motion, lane) {
            (Motion::Lane { .. }, Some(lane)) => {
                let error = pose_error(lane, stop);
                let along_m = lane.line.along_m(stop.position());
                (along_m, error.lateral_m, lane.direction_rad)
            }
            (Motion::Follow(follower), _) => {
                let track = follower.track();
                let place = track.along_lane_m(stop.position());
                if !place.on_lane {
                    return Self::Impossible;
                }
                let direction_rad = track.lane_direction_rad();
                (place.along_m, place.error.lateral_m, direction_rad)
            }
            (Motion::Still, _) => return Self::Standing,
            _ => return Self::Impossible,
        };
        let off_rad = wrap_angle(stop.theta_rad - direction_rad);
        let near = aside_m.abs() <= INSTRUCTED_BESIDE_M && off_rad.abs() <= INSTRUCTED_HEADING_RAD;
        if near && along_m.is_finite() {
            Self::Place { along_m, aside_m }
        } else {
            Self::Impossible
        }
    }

    pub fn pace(&self, motion: &Motion, stopping: &mut Stopping, now: &Progress) -> Pace {
        match *self {
            Self::Place { along_m, .. } => stop_there(along_m, motion, stopping, now),
            Self::Impossible => Pace::standing(Hold::StopPose),
            Self::Standing => Pace::FREE,
        }
    }
}
