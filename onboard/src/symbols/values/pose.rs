//! Where navigation takes the robot to be, and what it does there.

use description::geometry::Pose2;

use super::Name;

value! {
    /// Pose of `base_link` in `map`, with standard deviations.
    PoseEstimate, "pose_estimate" {
        /// `base_link` in `map`.
        #[serde(flatten)]
        pose: Pose2,
        /// Standard deviation.
        std_x_m: f64,
        /// Standard deviation.
        std_y_m: f64,
        /// Standard deviation.
        std_theta_rad: f64,
        /// 1 when it is too uncertain to drive.
        uncertain: u64,
    }
}

value! {
    /// Where navigation takes the robot to be and what it is doing there, in one moment: numbers, for other activities.
    Whereabouts, "whereabouts" {
        /// `base_link` in `map`.
        #[serde(flatten)]
        pose: Pose2,
        /// Variance of x, in m².
        xx: f64,
        /// Covariance of x and y, in m².
        xy: f64,
        /// Variance of y, in m².
        yy: f64,
        /// Covariance of x and θ, in m rad.
        xt: f64,
        /// Covariance of y and θ, in m rad.
        yt: f64,
        /// Variance of θ, in rad².
        tt: f64,
        /// 1 when it is too uncertain to drive.
        uncertain: u64,
        /// Number of the state of the robot's machine.
        state: u64,
        /// Number of the area ahead that it may not enter, and slows down or waits for; `u64::MAX` for none.
        waiting_for: u64,
    }
}

value! {
    /// What navigation is doing.
    NavigationState, "navigation_state" {
        /// State of the robot's machine.
        state: Name,
        /// Area of that state.
        area: Name,
        /// Skill that is scheduled.
        skill: Name,
        /// Distance from the lane's centre, positive to its left.
        lateral_error_m: f64,
        /// Heading relative to the lane.
        heading_error_rad: f64,
        /// Distance to the lane's end, NaN when it is not tracked.
        lane_end_m: f64,
        /// Why it stands although its skill would move: see `skills::navigator::Hold`. Empty: it does not.
        hold: Name,
        /// The area ahead that it may not enter, and slows down or waits for. Empty: none.
        waiting_for: Name,
        /// Way left before that area, NaN when none is near.
        border_distance_m: f64,
        /// How often the schedule changed.
        schedule_changes: u64,
        /// How often the machine emitted `lap`.
        laps: u64,
        /// Events that the machine's state ignored.
        ignored_events: u64,
    }
}
