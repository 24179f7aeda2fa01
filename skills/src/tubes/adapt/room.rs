//! How far beside its path a robot may go on a detour.

use std::f64::consts::PI;

use description::geometry::{Pose2, Twist2};

/// A detour keeps this far inside the limit, for the errors of following a tube and of the pose.
const MARGIN_M: f64 = 0.05;
/// Number of poses along a tube that are checked.
const PLACES: usize = 4;
/// Smaller curvatures count as straight.
const STRAIGHT_1_M: f64 = 1e-3;

/// Where the robot is relative to the path that it should keep to, and how far beside it it may be.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "symbols",
    derive(bytemuck::Pod, bytemuck::Zeroable, serde::Serialize)
)]
#[repr(C)]
pub struct Room {
    /// Of `base_link` from the path, positive to the left.
    pub lateral_m: f64,
    /// Of `base_link` from the direction of the path there.
    pub heading_rad: f64,
    /// Of the path there.
    pub path_curvature_1_m: f64,
    /// To either side.
    #[cfg_attr(feature = "symbols", serde(rename = "keep_within_m"))]
    pub limit_m: f64,
    /// How far it may back up, straight and on the tightest curves to both sides.
    pub behind_m: f64,
    /// The tightest curve on which navigation leads it back.
    pub tightest_1_m: f64,
}

impl Room {
    /// Whether a robot that drives a curve for a length, and then turns back along the path as tightly
    /// as it can, stays in the room, or, being outside, gets no farther off than it is.
    pub(super) fn holds(&self, curvature_1_m: f64, length_m: f64) -> bool {
        let most_m = (self.limit_m - MARGIN_M).max(self.lateral_m.abs());
        let start = Pose2::new(0.0, self.lateral_m, self.heading_rad);
        (1..=PLACES).all(|place| {
            let way_m = length_m * place as f64 / PLACES as f64;
            let pose = start.advance(Twist2::new(way_m, way_m * curvature_1_m), 1.0);
            let (lateral_m, off_rad) = self.beside(pose);
            // NaN is outside the room.
            lateral_m.abs() + turning_back_m(lateral_m, off_rad, self.tightest_1_m) <= most_m
        })
    }

    /// Whether a robot may back out for a length, on a curve.
    pub(super) fn holds_behind(&self, curvature_1_m: f64, length_m: f64) -> bool {
        let most_m = (self.limit_m - MARGIN_M).max(self.lateral_m.abs());
        let start = Pose2::new(0.0, self.lateral_m, self.heading_rad);
        let pose = start.advance(Twist2::new(-length_m, -length_m * curvature_1_m), 1.0);
        length_m <= self.behind_m && self.beside(pose).0.abs() <= most_m
    }

    /// Lateral distance and heading relative to the path, which begins along x and goes on with its curvature.
    fn beside(&self, pose: Pose2) -> (f64, f64) {
        if self.path_curvature_1_m.abs() < STRAIGHT_1_M {
            return (pose.y_m, pose.theta_rad);
        }
        let radius_m = 1.0 / self.path_curvature_1_m;
        let (side, across_m) = (radius_m.signum(), radius_m - pose.y_m);
        let swept_rad = pose.x_m.atan2(across_m * side);
        let lateral_m = side * (radius_m.abs() - pose.x_m.hypot(across_m));
        (lateral_m, pose.theta_rad - side * swept_rad)
    }
}

/// How much farther from its path a robot gets while it turns back along it on its tightest curve.
pub(crate) fn turning_back_m(lateral_m: f64, heading_rad: f64, tightest_1_m: f64) -> f64 {
    let outward_rad = heading_rad * lateral_m.signum();
    (1.0 - outward_rad.clamp(0.0, PI).cos()) / tightest_1_m
}

#[cfg(test)]
mod tests {
    use super::*;

    fn room(lateral_m: f64, heading_rad: f64, path_curvature_1_m: f64) -> Room {
        Room {
            lateral_m,
            heading_rad,
            path_curvature_1_m,
            limit_m: 0.3,
            behind_m: 0.4,
            tightest_1_m: 2.5,
        }
    }

    #[test]
    fn what_leads_out_of_it_or_cannot_turn_back_inside_does_not_fit() {
        let on_path = room(0.0, 0.0, 0.0);
        assert!(on_path.holds(0.0, 1.6));
        // 0.5 · 0.6² · 2.5 = 0.45 m aside.
        assert!(!on_path.holds(2.5, 0.6) && !on_path.holds(-2.5, 0.6));
        assert!(on_path.holds(2.5, 0.2));
        let aside = room(0.2, 0.0, 0.0);
        assert!(!aside.holds(2.5, 0.25) && aside.holds(-2.5, 0.25));
        // Its end lies inside, what it takes to turn back does not.
        let turned = room(0.1, 0.8, 0.0);
        assert!(!turned.holds(0.0, 0.1));
        assert!(!room(f64::NAN, 0.0, 0.0).holds(0.0, 0.1));
    }

    #[test]
    fn a_robot_outside_may_come_back_and_not_go_farther() {
        let outside = room(0.5, 0.0, 0.0);
        assert!(outside.holds(-1.0, 1.0) && outside.holds(0.0, 1.0));
        assert!(!outside.holds(0.5, 0.5));
    }

    #[test]
    fn behind_there_is_room_as_far_as_leave_and_the_path_go() {
        assert!(room(0.0, 0.0, 0.0).holds_behind(0.0, 0.4));
        assert!(!room(0.0, 0.0, 0.0).holds_behind(0.0, 0.5));
        assert!(room(0.2, 1.0, 0.0).holds_behind(0.0, 0.4));
        assert!(!room(0.2, -1.0, 0.0).holds_behind(0.0, 0.4));
    }

    #[test]
    fn a_bent_path_takes_its_room_along() {
        for sign in [1.0, -1.0] {
            let bend = room(0.0, 0.0, 2.0 * sign);
            assert!(bend.holds(2.0 * sign, 1.5));
            assert!(!bend.holds(0.0, 1.05));
        }
    }
}
