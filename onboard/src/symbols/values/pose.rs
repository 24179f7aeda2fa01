//! Where navigation believes the robot is, and what it does there.

use description::areas::AreaIndex;
use description::geometry::Pose2;
use skills::navigator::{NavigationOutput, Navigator, NavigatorCheckpoint, PoseCheck};

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
        /// What the newest scan did for it: `corrected`, `refused`, `blind`, `nothing` or `contradicted`. Empty: no scan was looked
        /// at since the robot was put there.
        scan: Name,
        /// Walls that the newest scan shows where the pose has them.
        walls_agree: u64,
        /// Walls that it shows elsewhere, or looks through.
        walls_contradict: u64,
    }
}

impl PoseEstimate {
    /// The same with what the newest scan says of it.
    #[must_use]
    pub fn checked(self, check: Option<PoseCheck>) -> Self {
        let Some(check) = check else { return self };
        Self {
            scan: Name::new(check.verdict.name()),
            walls_agree: u64::from(check.agreeing),
            walls_contradict: u64::from(check.contradicting),
            ..self
        }
    }
}

value! {
    /// Where navigation believes the robot is and what it does there, at one moment: numbers, for other activities.
    Whereabouts, "whereabouts" {
        /// Pose, state, and how far the state's path is driven.
        #[serde(flatten)]
        at: NavigatorCheckpoint,
        /// Number of the area ahead that it may not enter, for which it slows down or waits; `u64::MAX` for none.
        waiting_for: u64,
    }
}

impl Whereabouts {
    /// What navigation knows after a step.
    #[must_use]
    pub fn of(navigator: &Navigator, output: &NavigationOutput) -> Self {
        Self {
            at: navigator.checkpoint(),
            waiting_for: { output.waiting_for }.map_or(u64::MAX, |area| area.place() as u64),
        }
    }

    /// The area ahead that it may not enter.
    #[must_use]
    pub fn waiting_for(&self) -> Option<AreaIndex> {
        usize::try_from(self.waiting_for)
            .ok()
            .and_then(AreaIndex::new)
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
        /// The area ahead that it may not enter, for which it slows down or waits. Empty: none.
        waiting_for: Name,
        /// Distance left to that area, NaN when none is near.
        border_distance_m: f64,
        /// How often the schedule changed.
        schedule_changes: u64,
        /// How often the machine emitted `lap`.
        laps: u64,
        /// Events that the machine's state ignored.
        ignored_events: u64,
        /// Scans that showed nothing where the map has walls.
        blind_scans: u64,
    }
}
