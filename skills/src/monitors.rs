//! Monitors: conditions that are watched while their skill runs, each raising one event when it becomes true.
//!
//! A monitor fires once per schedule; a deviation fires again after the robot was back within half its limit. What is
//! not a number fires nothing. Real time.

use crate::geometry::{Pose2, Rect};
use crate::perception::Feature;
use crate::perception::corridor::CorridorEstimate;
use crate::perception::lane_end::LaneEndEstimate;
use coordination::event::EventId;

/// A condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MonitorKind {
    /// `base_link` is in a region of `map`.
    RegionReached {
        /// The region.
        region: Rect,
    },
    /// A feature was seen where it was expected, scan after scan, and is known well.
    EstimateStable {
        /// Which feature.
        feature: Feature,
        /// Scans in a row.
        scans: u32,
        /// Standard deviation at most this.
        max_std_m: f64,
    },
    /// The controller is done.
    ManoeuvreDone,
    /// The state was entered so long ago.
    After {
        /// How long.
        seconds: f64,
    },
    /// `base_link` is too far from the controller's path.
    Deviation {
        /// How far; without a number the limit of the state's area.
        limit_m: Option<f64>,
    },
}

/// What monitors look at.
#[derive(Clone, Copy, Debug, Default)]
pub struct Situation {
    /// `base_link` in `map`.
    pub pose: Pose2,
    /// The corridor, when it is tracked.
    pub corridor: Option<CorridorEstimate>,
    /// The lane's end, when it is tracked and found.
    pub lane_end: Option<LaneEndEstimate>,
    /// The controller is done.
    pub manoeuvre_done: bool,
    /// From the controller's path.
    pub lateral_error_m: f64,
    /// Of the state's area.
    pub deviation_limit_m: f64,
    /// Since the state was entered.
    pub in_state_s: f64,
}

/// A condition with its event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Monitor {
    /// Raised when the condition becomes true.
    pub event: EventId,
    /// The condition.
    pub kind: MonitorKind,
    fired: bool,
}

impl Monitor {
    /// A monitor that has not fired.
    #[must_use]
    pub fn new(event: EventId, kind: MonitorKind) -> Self {
        Self {
            event,
            kind,
            fired: false,
        }
    }

    /// Begins anew, as when its skill starts.
    pub fn reset(&mut self) {
        self.fired = false;
    }

    /// The event, when the condition has just become true.
    pub fn step(&mut self, situation: &Situation) -> Option<EventId> {
        if let MonitorKind::Deviation { limit_m } = self.kind {
            let limit_m = limit_m.unwrap_or(situation.deviation_limit_m);
            if situation.lateral_error_m.abs() < limit_m / 2.0 {
                self.fired = false;
            }
        }
        if self.fired || !self.holds(situation) {
            return None;
        }
        self.fired = true;
        Some(self.event)
    }

    fn holds(&self, situation: &Situation) -> bool {
        match self.kind {
            MonitorKind::RegionReached { region } => region.contains(situation.pose.position()),
            MonitorKind::EstimateStable {
                feature,
                scans,
                max_std_m,
            } => {
                let known = match feature {
                    Feature::Corridor => situation
                        .corridor
                        .map(|corridor| (corridor.consistent_scans, corridor.lateral_std_m)),
                    Feature::LaneEnd => situation
                        .lane_end
                        .map(|end| (end.consistent_scans, end.std_m)),
                    // They correct the pose and have no estimate of their own.
                    Feature::Walls => None,
                };
                known.is_some_and(|(seen, std_m)| seen >= scans && std_m <= max_std_m)
            }
            MonitorKind::ManoeuvreDone => situation.manoeuvre_done,
            MonitorKind::After { seconds } => situation.in_state_s >= seconds,
            MonitorKind::Deviation { limit_m } => {
                situation.lateral_error_m.abs() > limit_m.unwrap_or(situation.deviation_limit_m)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point2;

    fn monitor(kind: MonitorKind) -> Monitor {
        Monitor::new(EventId(3), kind)
    }

    #[test]
    fn a_region_fires_once_until_reset() {
        let region = Rect::new(Point2::new(5.0, -1.0), Point2::new(6.0, 0.0));
        let mut monitor = monitor(MonitorKind::RegionReached { region });
        let mut situation = Situation::default();
        assert_eq!(monitor.step(&situation), None);
        situation.pose = Pose2::new(5.2, -0.5, 0.0);
        assert_eq!(monitor.step(&situation), Some(EventId(3)));
        assert_eq!(monitor.step(&situation), None);
        monitor.reset();
        assert_eq!(monitor.step(&situation), Some(EventId(3)));
        monitor.reset();
        situation.pose.x_m = f64::NAN;
        assert_eq!(monitor.step(&situation), None);
    }

    #[test]
    fn stable_needs_both_scans_and_precision() {
        let mut monitor = monitor(MonitorKind::EstimateStable {
            feature: Feature::LaneEnd,
            scans: 5,
            max_std_m: 0.05,
        });
        let mut situation = Situation::default();
        let mut end = LaneEndEstimate {
            distance_m: 3.0,
            std_m: 0.1,
            consistent_scans: 9,
            seen: true,
        };
        situation.lane_end = Some(end);
        assert_eq!(monitor.step(&situation), None);
        end.std_m = 0.02;
        end.consistent_scans = 4;
        situation.lane_end = Some(end);
        assert_eq!(monitor.step(&situation), None);
        end.consistent_scans = 5;
        situation.lane_end = Some(end);
        assert!(monitor.step(&situation).is_some());
    }

    #[test]
    fn a_time_fires_once_when_it_has_passed() {
        let mut monitor = monitor(MonitorKind::After { seconds: 3.0 });
        let mut situation = Situation::default();
        let mut fired = |in_state_s| {
            situation.in_state_s = in_state_s;
            monitor.step(&situation).is_some()
        };
        assert!(!fired(0.0) && !fired(2.99) && !fired(f64::NAN));
        assert!(fired(3.01) && !fired(3.05));
    }

    #[test]
    fn a_deviation_fires_again_only_after_it_was_over() {
        let mut monitor = monitor(MonitorKind::Deviation { limit_m: None });
        let mut situation = Situation {
            deviation_limit_m: 0.3,
            ..Situation::default()
        };
        let mut fired = |lateral_error_m| {
            situation.lateral_error_m = lateral_error_m;
            monitor.step(&situation).is_some()
        };
        assert!(!fired(0.2));
        assert!(fired(-0.31));
        assert!(!fired(0.2) && !fired(0.4));
        assert!(!fired(0.1) && fired(0.4));
    }
}
