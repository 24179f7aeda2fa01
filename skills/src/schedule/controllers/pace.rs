//! How fast the robot may be on its way, and why it stands although it has something to do.

use super::motion::Motion;
use crate::control::Stopping;
use crate::map::{LaneGeometry, LaneWall};
use description::geometry::{Footprint, Pose2};
use description::robot::Navigation;

/// Why a robot that has something to do stands still.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Hold {
    /// Motion is not allowed, as in pause.
    Forbidden,
    /// It does not know well enough where it is.
    PoseUncertain,
    /// An area ahead, or under it, is not allowed.
    Border,
    /// The instruction allows no speed.
    SpeedLimit,
    /// The state waits for a stop pose that no instruction brought.
    NoStopPose,
    /// The stop pose cannot be reached from here: behind the robot, or too far beside its path.
    StopPose,
    /// The wall to dock at is not seen.
    WallUnseen,
    /// Somebody drives it by hand, and wants it to stand.
    ByHand,
}

impl Hold {
    /// The reason in words.
    #[must_use]
    pub const fn reason(self) -> &'static str {
        match self {
            Self::Forbidden => "motion is not allowed",
            Self::PoseUncertain => "the pose is uncertain",
            Self::Border => "area ahead is not allowed",
            Self::SpeedLimit => "speed limit is 0",
            Self::NoStopPose => "no stop pose was given",
            Self::StopPose => "stop pose cannot be reached",
            Self::WallUnseen => "wall to dock at is unseen",
            Self::ByHand => "driven by hand",
        }
    }
}

/// What is known in a step.
#[derive(Clone, Copy)]
pub(crate) struct Progress<'a> {
    pub pose: Pose2,
    pub lane: Option<&'a LaneGeometry>,
    pub end_wall: Option<&'a LaneWall>,
    /// From `base_link` to the lane's end, by the lidar or else by the map.
    pub end_m: f64,
    /// The lidar has measured it well, and just now.
    pub end_measured: bool,
    /// Margin for the uncertainty of the pose along the lane.
    pub margin_m: f64,
    pub speed_m_s: f64,
    pub limit_m_s: f64,
    /// An instruction has brought a stop pose.
    pub instructed: bool,
    pub dt_s: f64,
    pub footprint: &'a Footprint,
    pub gains: &'a Navigation,
}

/// How fast the robot may be in a step, and whether it is there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    /// No faster than this.
    pub speed_m_s: f64,
    /// Way that remains, where it is known.
    pub left_m: f64,
    pub done: bool,
    pub hold: Option<Hold>,
}

impl Pace {
    /// Nothing ends it.
    pub(super) const FREE: Self = Self {
        speed_m_s: f64::INFINITY,
        left_m: f64::INFINITY,
        done: false,
        hold: None,
    };

    pub fn standing(hold: Hold) -> Self {
        Self {
            speed_m_s: 0.0,
            left_m: 0.0,
            hold: Some(hold),
            ..Self::FREE
        }
    }

    /// Done when the robot is on the lane that a manoeuvre leads to.
    pub(super) fn until_on_lane(motion: &Motion) -> Self {
        Self {
            done: matches!(motion, Motion::Follow(follower) if follower.done()),
            ..Self::FREE
        }
    }

    /// Both hold; either ends it.
    pub fn and(self, other: Self) -> Self {
        Self {
            speed_m_s: self.speed_m_s.min(other.speed_m_s),
            left_m: self.left_m.min(other.left_m),
            done: self.done || other.done,
            hold: self.hold.or(other.hold),
        }
    }
}

impl Progress<'_> {
    /// The same for a way that may lead backward.
    pub(super) fn backward(&self) -> Self {
        Self {
            speed_m_s: self.speed_m_s.abs(),
            ..*self
        }
    }

    pub(super) fn stop(&self, stopping: &mut Stopping, left_m: f64) -> Pace {
        let deceleration_m_s2 = self.gains.deceleration_m_s2;
        Pace {
            speed_m_s: stopping.speed_m_s(left_m, self.speed_m_s, deceleration_m_s2, self.dt_s),
            left_m: left_m.max(0.0),
            done: stopping.arrived(),
            hold: None,
        }
    }

    /// How far along its path the robot is.
    pub(super) fn along_m(&self, motion: &Motion) -> f64 {
        match (motion, self.lane) {
            (Motion::Follow(follower), _) => follower.along_m(),
            (_, Some(lane)) => lane.line.along_m(self.pose.position()),
            (_, None) => f64::NAN,
        }
    }

    /// How far along the lane the foremost corner of the footprint is.
    pub(super) fn front_along_m(&self) -> f64 {
        let Some(lane) = self.lane else {
            return f64::NAN;
        };
        self.footprint
            .corners()
            .map(|corner| lane.line.along_m(self.pose.transform(corner)))
            .into_iter()
            .fold(f64::NEG_INFINITY, f64::max)
    }
}
