//! Drives along a track and says when the robot is on the lane at its end.

use super::law::{path_curvature, speed_share};
use super::steer::Steer;
use super::track::Track;
use description::geometry::Pose2;
use description::robot::Navigation;

/// How close to the lane a manoeuvre is done, and after which way the tolerances double.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// At most this far beside the lane,
    pub near_m: f64,
    /// and turned from it by at most this.
    pub near_rad: f64,
    /// After this way along the lane both tolerances double.
    pub settle_m: f64,
}

impl Arrival {
    /// After a turn.
    pub const TURN: Self = Self {
        near_m: 0.10,
        near_rad: 0.15,
        settle_m: 1.0,
    };
    /// After a shift.
    pub const SHIFT: Self = Self {
        near_m: 0.03,
        near_rad: 0.05,
        settle_m: 2.0,
    };
}

/// A manoeuvre under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Follower {
    track: Track,
    arrival: Arrival,
    along_m: f64,
    done: bool,
}

impl Follower {
    /// At the start of a track.
    #[must_use]
    pub fn new(track: Track, arrival: Arrival) -> Self {
        Self {
            track,
            arrival,
            along_m: 0.0,
            done: false,
        }
    }

    /// Goes on from the place of the track that is nearest to this pose.
    pub fn go_on_at(&mut self, pose: Pose2) {
        self.along_m = self.track.nearest_m(pose);
    }

    /// The track.
    #[must_use]
    pub fn track(&self) -> &Track {
        &self.track
    }

    /// Way driven along the track.
    #[must_use]
    pub fn along_m(&self) -> f64 {
        self.along_m
    }

    /// It has been on the lane.
    #[must_use]
    pub fn done(&self) -> bool {
        self.done
    }

    /// One step at `pose` in `map`.
    pub fn step(&mut self, pose: Pose2, speed_m_s: f64, gains: &Navigation) -> Steer {
        let place = self.track.place(pose, self.along_m);
        // The pivot lags, so the curve is commanded before it begins and ended before it ends.
        let early_m = gains.steering_lag_s * speed_m_s.max(0.0);
        if place.along_m.is_finite() {
            self.along_m = place.along_m;
        }
        let curvature_1_m = self.track.curvature_1_m(self.along_m + early_m);
        let on_lane_m = self.along_m + early_m - self.track.length_m();
        let loose = if on_lane_m > self.arrival.settle_m {
            2.0
        } else {
            1.0
        };
        let error = place.error;
        self.done |= on_lane_m >= 0.0
            && error.lateral_m.abs() < loose * self.arrival.near_m
            && error.heading_rad.abs() < loose * self.arrival.near_rad;
        Steer {
            error,
            curvature_1_m: path_curvature(error, curvature_1_m, gains),
            path_curvature_1_m: self.track.curvature_1_m(self.along_m),
            direction: 1.0,
            speed_share: speed_share(error),
        }
    }
}
