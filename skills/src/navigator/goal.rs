//! Where the present schedule's motion ends, and how fast it may be on the way.

use super::Hold;
use super::motion::{Motion, pose_error};
use crate::control::{ControlGains, EndOfLane, Stopping, approach_speed_m_s};
use crate::map::{LaneGeometry, LaneWall};
use crate::schedule::{Controller, Schedule, StopPlace};
use description::geometry::{Footprint, Point2, Pose2, wrap_angle};

/// A place that lies so far behind the robot was missed.
const MISSED_M: f64 = 0.05;
/// A stop pose is turned from the path, and beside it, by no more.
const STOP_HEADING_RAD: f64 = 0.3;
const STOP_BESIDE_M: f64 = 0.5;
/// The last part of docking is slow.
const DOCK_SLOW_M: f64 = 1.0;
const DOCK_SPEED_M_S: f64 = 0.15;
/// Without a measured wall, docking ends so far before where the map has it.
const DOCK_BLIND_M: f64 = 0.5;

/// The end of a schedule's motion, in the terms of its path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Goal {
    /// None: monitors end it.
    None,
    /// A distance from the lane's end.
    EndOfLane(EndOfLane),
    /// The footprint before a border.
    Border { along_m: f64, margin_m: f64 },
    /// `base_link` at a place along the lane.
    Place { along_m: f64 },
    /// The footprint at a distance from the lane's end wall.
    Dock { distance_m: f64 },
    /// The end of a creep.
    Creep,
    /// The lane that a manoeuvre leads to.
    OnLane,
    /// There is none, for a reason.
    Impossible(Hold),
}

/// What is known in a step.
#[derive(Clone, Copy)]
pub(super) struct Situation<'a> {
    pub(super) pose: Pose2,
    pub(super) lane: Option<&'a LaneGeometry>,
    pub(super) end_wall: Option<&'a LaneWall>,
    /// From `base_link` to the lane's end, by the lidar or else by the map.
    pub(super) end_m: f64,
    /// The lidar has measured it well, and just now.
    pub(super) end_measured: bool,
    /// Margin for the uncertainty of the pose along the lane.
    pub(super) margin_m: f64,
    pub(super) speed_m_s: f64,
    pub(super) limit_m_s: f64,
    pub(super) dt_s: f64,
    pub(super) footprint: &'a Footprint,
    pub(super) gains: &'a ControlGains,
}

/// What a goal says in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// No faster than this.
    pub(super) speed_m_s: f64,
    /// Way that remains, where it is known.
    pub(super) left_m: f64,
    pub(super) done: bool,
    pub(super) hold: Option<Hold>,
}

impl Pace {
    const FREE: Self = Self {
        speed_m_s: f64::INFINITY,
        left_m: f64::INFINITY,
        done: false,
        hold: None,
    };

    pub(super) fn standing(hold: Hold) -> Self {
        Self {
            speed_m_s: 0.0,
            left_m: 0.0,
            hold: Some(hold),
            ..Self::FREE
        }
    }

    /// Both hold; either ends it.
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            speed_m_s: self.speed_m_s.min(other.speed_m_s),
            left_m: self.left_m.min(other.left_m),
            done: self.done || other.done,
            hold: self.hold.or(other.hold),
        }
    }
}

impl Goal {
    /// The goal of the schedule's own controller.
    pub(super) fn of(schedule: &Schedule, instructed: bool) -> Self {
        match schedule.controller {
            Controller::Stop | Controller::Corridor { .. } => Self::None,
            Controller::EndOfLane(end) => Self::EndOfLane(end),
            Controller::UTurn { .. } | Controller::Shift { .. } | Controller::Turn { .. } => {
                Self::OnLane
            }
            Controller::StopAt(StopPlace::Border { along_m, margin_m }) => {
                Self::Border { along_m, margin_m }
            }
            Controller::StopAt(StopPlace::Pose { along_m, .. }) => Self::Place { along_m },
            Controller::StopAt(StopPlace::Instructed) if instructed => Self::None,
            Controller::StopAt(StopPlace::Instructed) => Self::Impossible(Hold::NoStopPose),
            Controller::Dock { distance_m } => Self::Dock { distance_m },
            Controller::Creep { .. } => Self::Creep,
        }
    }

    /// The stop pose of an instruction, in the terms of the motion's path; with it the offset to keep from a lane.
    pub(super) fn instructed(
        motion: &Motion,
        lane: Option<&LaneGeometry>,
        stop: Pose2,
    ) -> (Self, f64) {
        let impossible = (Self::Impossible(Hold::StopPose), 0.0);
        let (along_m, lateral_m, direction_rad) = match (motion, lane) {
            (Motion::Lane { .. }, Some(lane)) => {
                let error = pose_error(lane, stop);
                let along_m = lane.line.along_m(stop.position());
                (along_m, error.lateral_m, lane.direction_rad)
            }
            (Motion::Follow(follower), _) => {
                let track = follower.track();
                let place = track.along_lane_m(stop.position());
                if !place.on_lane {
                    return impossible;
                }
                let direction_rad = track.lane_direction_rad();
                (place.along_m, place.error.lateral_m, direction_rad)
            }
            (Motion::Still, _) => return (Self::None, 0.0),
            _ => return impossible,
        };
        let off_rad = wrap_angle(stop.theta_rad - direction_rad);
        let near = lateral_m.abs() <= STOP_BESIDE_M && off_rad.abs() <= STOP_HEADING_RAD;
        if near && along_m.is_finite() {
            (Self::Place { along_m }, lateral_m)
        } else {
            impossible
        }
    }

    /// How fast the robot may be, and whether it is there.
    pub(super) fn pace(&self, motion: &Motion, stopping: &mut Stopping, now: &Situation) -> Pace {
        match *self {
            Self::None => Pace::FREE,
            Self::Impossible(hold) => Pace::standing(hold),
            Self::OnLane => Pace {
                done: matches!(motion, Motion::Follow(follower) if follower.done()),
                ..Pace::FREE
            },
            Self::EndOfLane(end) => {
                let (speed_m_s, done) =
                    end.step(now.end_m, now.limit_m_s, now.speed_m_s, now.gains);
                let stops = end.exit_speed_m_s <= 0.0;
                Pace {
                    speed_m_s,
                    left_m: if stops {
                        (now.end_m - end.distance_m).max(0.0)
                    } else {
                        f64::INFINITY
                    },
                    done,
                    hold: None,
                }
            }
            Self::Border { along_m, margin_m } => {
                let bare_m = along_m - margin_m - now.front_along_m();
                if bare_m < -MISSED_M && !stopping.arrived() {
                    return Pace::standing(Hold::StopPose);
                }
                now.stop(stopping, bare_m - now.margin_m)
            }
            Self::Place { along_m } => {
                let left_m = along_m - now.along_m(motion);
                if left_m < -MISSED_M && !stopping.arrived() {
                    return Pace::standing(Hold::StopPose);
                }
                now.stop(stopping, left_m)
            }
            Self::Dock { distance_m } => now.dock(stopping, distance_m),
            Self::Creep => match motion {
                Motion::Creep(creep) => {
                    let forward = Situation {
                        speed_m_s: now.speed_m_s.abs(),
                        ..*now
                    };
                    forward.stop(stopping, creep.left_m(now.pose))
                }
                _ => Pace::standing(Hold::StopPose),
            },
        }
    }
}

impl Situation<'_> {
    fn stop(&self, stopping: &mut Stopping, left_m: f64) -> Pace {
        let deceleration_m_s2 = self.gains.deceleration_m_s2;
        Pace {
            speed_m_s: stopping.speed_m_s(left_m, self.speed_m_s, deceleration_m_s2, self.dt_s),
            left_m: left_m.max(0.0),
            done: stopping.arrived(),
            hold: None,
        }
    }

    /// How far along its path the robot is.
    fn along_m(&self, motion: &Motion) -> f64 {
        match (motion, self.lane) {
            (Motion::Follow(follower), _) => follower.along_m(),
            (_, Some(lane)) => lane.line.along_m(self.pose.position()),
            (_, None) => f64::NAN,
        }
    }

    /// How far along the lane the foremost corner of the footprint is.
    fn front_along_m(&self) -> f64 {
        let Some(lane) = self.lane else {
            return f64::NAN;
        };
        self.footprint
            .corners()
            .map(|corner| lane.line.along_m(self.pose.transform(corner)))
            .into_iter()
            .fold(f64::NEG_INFINITY, f64::max)
    }

    fn dock(&self, stopping: &mut Stopping, distance_m: f64) -> Pace {
        let Some(wall) = self.end_wall else {
            return Pace::standing(Hold::WallUnseen);
        };
        // Towards the wall, from the side that the robot is on.
        let unit = wall.line.unit();
        let side = -wall.line.lateral_m(self.pose.position()).signum();
        let towards = Point2::new(-unit.y_m, unit.x_m) * side;
        let front_m = self
            .footprint
            .corners()
            .map(|corner| self.pose.rotate(corner).dot(towards))
            .into_iter()
            .fold(f64::NEG_INFINITY, f64::max);
        let left_m = self.end_m - front_m - distance_m;
        let blind_m = left_m - DOCK_BLIND_M;
        if !self.end_measured && !stopping.arrived() {
            if blind_m <= 0.02 {
                return Pace::standing(Hold::WallUnseen);
            }
            return Pace {
                speed_m_s: approach_speed_m_s(blind_m, 0.0, self.gains.deceleration_m_s2),
                left_m: blind_m,
                ..Pace::FREE
            };
        }
        let deceleration_m_s2 = self.gains.deceleration_m_s2;
        let slow_m_s = approach_speed_m_s(left_m - DOCK_SLOW_M, DOCK_SPEED_M_S, deceleration_m_s2);
        let pace = self.stop(stopping, left_m);
        Pace {
            speed_m_s: pace.speed_m_s.min(slow_m_s),
            ..pace
        }
    }
}
