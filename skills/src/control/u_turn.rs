//! Half a circle from one lane onto the other, then along that lane until the robot is on it.

use super::{ControlGains, ControlOutput, PathError, path_curvature};
use crate::geometry::{MotionCommand, Point2, Pose2, Segment, wrap_angle};
use std::f64::consts::{FRAC_PI_2, PI};

/// The turn is done this close to the outgoing lane.
const NEAR_LANE_M: f64 = 0.10;
const NEAR_LANE_RAD: f64 = 0.15;
/// Driving on along the outgoing lane, it gives up being choosy after this way, m.
const SETTLE_M: f64 = 1.0;
/// And takes this.
const SETTLED_M: f64 = 0.25;
const SETTLED_RAD: f64 = 0.35;

/// To which side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TurnDirection {
    /// Counter-clockwise.
    Left,
    /// Clockwise.
    Right,
}

impl TurnDirection {
    /// +1 to the left, −1 to the right.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }
}

/// A turn under way: a circle fixed in `map` when it starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UTurn {
    sign: f64,
    radius_m: f64,
    centre: Point2,
    /// Direction from the centre to where the circle starts.
    start_rad: f64,
    outgoing: Segment,
    /// Angle driven round the centre; grows past a half turn only on the outgoing lane.
    swept_rad: f64,
    on_lane: bool,
}

impl UTurn {
    /// Starts at `pose`. The circle touches the incoming lane beside the robot, so that an offset from that lane is
    /// corrected on the way round.
    #[must_use]
    pub fn start(
        direction: TurnDirection,
        radius_m: f64,
        incoming: Option<&Segment>,
        outgoing: &Segment,
        pose: Pose2,
    ) -> Self {
        let sign = direction.sign();
        let (touch, heading_rad) = match incoming {
            Some(lane) => (
                lane.a + lane.unit() * lane.along_m(pose.position()),
                lane.direction_rad(),
            ),
            None => (pose.position(), pose.theta_rad),
        };
        let start_rad = heading_rad - sign * FRAC_PI_2;
        let (sin, cos) = start_rad.sin_cos();
        Self {
            sign,
            radius_m,
            centre: touch - Point2::new(cos, sin) * radius_m,
            start_rad,
            outgoing: *outgoing,
            swept_rad: 0.0,
            on_lane: false,
        }
    }

    /// Angle driven so far.
    #[must_use]
    pub fn swept_rad(&self) -> f64 {
        self.swept_rad
    }

    /// One step at `pose` in `map`.
    pub fn step(
        &mut self,
        pose: Pose2,
        speed_limit_m_s: f64,
        speed_m_s: f64,
        gains: &ControlGains,
    ) -> ControlOutput {
        self.progress(pose);
        let early_rad = gains.steering_lag_s * speed_m_s.max(0.0) / self.radius_m;
        let turn_rad = PI - early_rad.min(FRAC_PI_2);
        if self.swept_rad >= turn_rad {
            self.on_lane = true;
        }
        let lane = self.lane_error(pose);
        let (error, curvature_1_m) = if self.on_lane {
            (lane, 0.0)
        } else {
            (self.circle_error(pose), self.sign / self.radius_m)
        };
        let settled_m = self.settled_m(pose);
        let near = lane.lateral_m.abs() < NEAR_LANE_M && lane.heading_rad.abs() < NEAR_LANE_RAD;
        let settled = settled_m > SETTLE_M
            && lane.lateral_m.abs() < SETTLED_M
            && lane.heading_rad.abs() < SETTLED_RAD;
        ControlOutput {
            command: MotionCommand::new(
                speed_limit_m_s,
                path_curvature(error, curvature_1_m, gains),
            ),
            error,
            done: self.on_lane && (near || settled),
        }
    }

    fn progress(&mut self, pose: Pose2) {
        let around_rad = (pose.position() - self.centre).direction_rad();
        let from_start_rad = self.sign * wrap_angle(around_rad - self.start_rad);
        // Unwrapped around what was swept before: half a turn lies on the seam of the wrapped angle.
        let step_rad = wrap_angle(from_start_rad - self.swept_rad);
        self.swept_rad = (self.swept_rad + step_rad).clamp(-FRAC_PI_2, 1.5 * PI);
    }

    fn circle_error(&self, pose: Pose2) -> PathError {
        let from_centre = pose.position() - self.centre;
        let tangent_rad = from_centre.direction_rad() + self.sign * FRAC_PI_2;
        PathError {
            lateral_m: self.sign * (self.radius_m - from_centre.norm_m()),
            heading_rad: wrap_angle(pose.theta_rad - tangent_rad),
        }
    }

    fn lane_error(&self, pose: Pose2) -> PathError {
        PathError {
            lateral_m: self.outgoing.lateral_m(pose.position()),
            heading_rad: wrap_angle(pose.theta_rad - self.outgoing.direction_rad()),
        }
    }

    /// Way along the outgoing lane since the circle's end.
    fn settled_m(&self, pose: Pose2) -> f64 {
        self.outgoing.along_m(pose.position()) - self.outgoing.along_m(self.centre)
    }
}
