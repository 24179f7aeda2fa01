//! The path of the present schedule: how to steer along it, and where it leads.

use crate::control::{
    Arrival, Creep, Follower, PathError, Steer, Track, TrackError, keep_lane, manoeuvre,
};
use crate::map::LaneGeometry;
use description::geometry::{Pose2, Segment, Twist2, wrap_angle};
use description::robot::Navigation;

/// Poses of a path that is planned ahead.
pub(crate) const PATH_POSES: usize = 32;

/// Where a state begins.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Start<'a> {
    /// The lane to drive on, or onto.
    pub onto: Option<&'a Segment>,
    /// The lane that a turn leaves.
    pub from: Option<&'a Segment>,
    /// `base_link` in `map`.
    pub pose: Pose2,
    /// The tightest curve.
    pub max_curvature_1_m: f64,
}

/// How the robot moves in the present state.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is one, and it must not be on the heap"
)]
pub(crate) enum Motion {
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
    /// Along the track of a manoeuvre onto the state's lane, or to an offset from it. Without a track the law leads there
    /// from wherever the robot is.
    pub(super) fn onto_lane(
        start: &Start,
        offset_m: f64,
        arrival: Arrival,
        track: impl FnOnce(&Segment) -> Result<Track, TrackError>,
    ) -> Self {
        let Some(onto) = start.onto else {
            return Self::Still;
        };
        let track = track(onto).unwrap_or_else(|_| {
            Track::lane(&manoeuvre::beside(onto, offset_m), start.pose.position())
        });
        Self::Follow(Follower::new(track, arrival))
    }

    /// A part of the way is done: the robot is here.
    pub fn go_on_at(&mut self, pose: Pose2) {
        if let Self::Follow(follower) = self {
            follower.go_on_at(pose);
        }
    }

    /// Keeps this offset from the lane from now on; other motions ignore it.
    pub fn keep_beside(&mut self, aside_m: f64) {
        if let Self::Lane { offset_m } = self {
            *offset_m = aside_m;
        }
    }

    /// One step at `pose`; `error` is that from the lane's centre.
    pub fn steer(
        &mut self,
        pose: Pose2,
        error: PathError,
        speed_m_s: f64,
        gains: &Navigation,
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

    /// Simulates the controller ahead: the poses that it leads to.
    pub fn plan(mut self, poses: &mut Vec<Pose2>, from: Pose2, ahead: &Ahead) {
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

/// How to simulate the controller ahead.
pub(crate) struct Ahead<'a> {
    pub lane: Option<&'a LaneGeometry>,
    pub speed_m_s: f64,
    /// Between the poses.
    pub step_m: f64,
    /// How far; less when that takes more than [`PATH_POSES`] poses.
    pub length_m: f64,
    pub gains: &'a Navigation,
}

/// Relative to a lane's centre.
pub(crate) fn pose_error(lane: &LaneGeometry, pose: Pose2) -> PathError {
    PathError {
        lateral_m: lane.line.lateral_m(pose.position()),
        heading_rad: wrap_angle(pose.theta_rad - lane.direction_rad),
    }
}
