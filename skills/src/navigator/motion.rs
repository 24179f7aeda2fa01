//! The path of the present schedule: how to steer along it, and where it leads.

use crate::control::{
    Arrival, ControlGains, Creep, Follower, PathError, Steer, Track, keep_lane, manoeuvre,
};
use crate::map::{LaneGeometry, SemanticMap};
use crate::schedule::{Controller, Schedule, StopPlace};
use description::geometry::{Pose2, Segment, Twist2, wrap_angle};

/// Poses of a path that is planned ahead.
pub(super) const PATH_POSES: usize = 32;

/// How the robot moves in the present state.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is one, and it must not be on the heap"
)]
pub(super) enum Motion {
    /// Not at all.
    Still,
    /// On the schedule's lane, or beside it.
    Lane { offset_m: f64 },
    /// On the path of a manoeuvre.
    Follow(Follower),
    /// A short way along a line.
    Creep(Creep),
}

impl Motion {
    /// What a schedule's controller begins with, at `pose`.
    pub(super) fn begin(
        map: &SemanticMap,
        schedule: &Schedule,
        pose: Pose2,
        max_curvature_1_m: f64,
    ) -> Self {
        let lane = |index: Option<usize>| index.map(|index| &map.lanes()[index].line);
        match schedule.controller {
            Controller::Stop => Self::Still,
            Controller::Creep { distance_m } => {
                let direction_rad =
                    lane(schedule.lane).map_or(pose.theta_rad, |lane| lane.direction_rad());
                Self::Creep(Creep::start(pose, direction_rad, distance_m))
            }
            Controller::Corridor { .. }
            | Controller::EndOfLane(_)
            | Controller::StopAt(_)
            | Controller::Dock { .. } => Self::Lane {
                offset_m: Self::own_offset_m(schedule),
            },
            Controller::UTurn { .. } | Controller::Shift { .. } | Controller::Turn { .. } => {
                let Some(onto) = lane(schedule.lane) else {
                    return Self::Still;
                };
                let from = lane(schedule.from_lane);
                let track = match (schedule.controller, from) {
                    (
                        Controller::UTurn {
                            direction,
                            radius_m,
                        },
                        from,
                    ) => {
                        // Without a lane that it comes from, it comes along a line beside the outgoing one.
                        let beside = manoeuvre::beside(onto, onto.lateral_m(pose.position()));
                        let back = Segment::new(beside.b, beside.a);
                        let from = from.unwrap_or(&back);
                        manoeuvre::u_turn(direction, radius_m, from, onto, pose.position())
                    }
                    (Controller::Turn { radius_m }, Some(from)) => {
                        manoeuvre::turn(radius_m, max_curvature_1_m, from, onto, pose)
                    }
                    (Controller::Shift { offset_m, within_m }, _) => {
                        manoeuvre::shift(onto, offset_m, within_m, max_curvature_1_m, pose)
                    }
                    _ => Ok(Track::lane(onto, pose.position())),
                };
                // Without a path the law leads onto the lane from wherever the robot is.
                let track = track.unwrap_or_else(|_| {
                    let offset_m = match schedule.controller {
                        Controller::Shift { offset_m, .. } => offset_m,
                        _ => 0.0,
                    };
                    Track::lane(&manoeuvre::beside(onto, offset_m), pose.position())
                });
                let arrival = match schedule.controller {
                    Controller::Shift { .. } => Arrival::SHIFT,
                    _ => Arrival::TURN,
                };
                Self::Follow(Follower::new(track, arrival))
            }
        }
    }

    /// The offset from its lane that a schedule's controller keeps.
    pub(super) fn own_offset_m(schedule: &Schedule) -> f64 {
        match schedule.controller {
            Controller::Corridor { offset_m }
            | Controller::StopAt(StopPlace::Pose { offset_m, .. }) => offset_m,
            _ => 0.0,
        }
    }

    /// Keeps beside the lane from now on; without meaning for other motions.
    pub(super) fn keep_beside(&mut self, aside_m: f64) {
        if let Self::Lane { offset_m } = self {
            *offset_m = aside_m;
        }
    }

    /// One step at `pose`; `error` is that from the lane's centre.
    pub(super) fn steer(
        &mut self,
        pose: Pose2,
        error: PathError,
        speed_m_s: f64,
        gains: &ControlGains,
    ) -> Steer {
        match self {
            Self::Still => Steer {
                error,
                ..Steer::default()
            },
            Self::Lane { offset_m } => {
                let error = PathError {
                    lateral_m: error.lateral_m - *offset_m,
                    ..error
                };
                keep_lane(error, gains)
            }
            Self::Follow(follower) => follower.step(pose, speed_m_s, gains),
            Self::Creep(creep) => creep.step(pose, gains),
        }
    }

    /// Drives ahead in thought: the poses that the controller leads to.
    pub(super) fn plan(mut self, poses: &mut Vec<Pose2>, from: Pose2, ahead: &Ahead) {
        poses.clear();
        let mut pose = from;
        let mut left_m = ahead.length_m;
        while left_m > 1e-3 && poses.len() < PATH_POSES {
            let error = ahead
                .lane
                .map_or(PathError::default(), |lane| pose_error(lane, pose));
            let steer = self.steer(pose, error, ahead.speed_m_s, ahead.gains);
            if steer.direction == 0.0 {
                return;
            }
            let way_m = steer.direction * ahead.step_m.min(left_m);
            pose = pose.advance(Twist2::new(way_m, way_m * steer.curvature_1_m), 1.0);
            if !pose.is_finite() {
                return;
            }
            poses.push(pose);
            left_m -= ahead.step_m;
        }
    }
}

/// How to drive ahead in thought.
pub(super) struct Ahead<'a> {
    pub(super) lane: Option<&'a LaneGeometry>,
    pub(super) speed_m_s: f64,
    /// Between the poses.
    pub(super) step_m: f64,
    /// How far; less when there is no room for so many poses.
    pub(super) length_m: f64,
    pub(super) gains: &'a ControlGains,
}

/// Relative to a lane's centre.
pub(super) fn pose_error(lane: &LaneGeometry, pose: Pose2) -> PathError {
    PathError {
        lateral_m: lane.line.lateral_m(pose.position()),
        heading_rad: wrap_angle(pose.theta_rad - lane.direction_rad),
    }
}
