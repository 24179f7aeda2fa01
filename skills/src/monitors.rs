//! Monitors: conditions that are watched while their skill runs, each raising one event when it becomes true.
//!
//! Each keeps a flag that rises with its condition and stays up: a monitor fires once per schedule; a deviation fires again
//! after the robot was back within half its limit. NaN fires nothing. Real time.
//!
//! When an operator sends on a robot that has strayed, its deviation is known already. It is raised again only when the
//! robot gets farther off than turning back takes, or does not come closer for `NEARER_S`.

use crate::perception::corridor::CorridorEstimate;
use crate::perception::lane_end::LaneEndEstimate;
use coordination::event::EventId;
use coordination::flag::{Flag, Monitor as FlagMonitor};
use description::geometry::Pose2;
use description::site::{Feature, MonitorKind};

/// A returning robot is back once its deviation is below this share of the limit.
const RETURNED_SHARE: f64 = 0.9;
/// On its way back the robot may get this much farther off than where it began plus what turning back takes.
const FARTHER_M: f64 = 0.10;
/// A returning robot must come at least `NEARER_M` closer every `NEARER_S`, or its deviation counts again.
const NEARER_S: f64 = 20.0;
const NEARER_M: f64 = 0.05;

/// What the conditions are evaluated on.
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
    /// How much farther off it gets before it has turned back along that path.
    pub turning_back_m: f64,
    /// Of the state's area.
    pub deviation_limit_m: f64,
    /// Since the state was entered.
    pub in_state_s: f64,
}

/// A condition with its event.
#[derive(Clone, Debug, PartialEq)]
pub struct Monitor {
    /// The condition.
    pub kind: MonitorKind,
    /// Whether the condition was true since the schedule began; of a deviation, since the robot was back.
    flag: Flag,
    on_flag: FlagMonitor,
    way_back: Option<WayBack>,
}

/// The return of a robot that is off its path.
#[derive(Clone, Copy, Debug, PartialEq)]
enum WayBack {
    Begins,
    Goes {
        /// The deviation that it may reach on the way.
        most_m: f64,
        /// The nearest that it came, and when.
        nearest_m: f64,
        nearest_s: f64,
    },
}

impl WayBack {
    /// Whether it is still under way, and as it should be.
    fn goes_on(&mut self, situation: &Situation, limit_m: f64) -> bool {
        let (off_m, now_s) = (situation.lateral_error_m.abs(), situation.in_state_s);
        let (most_m, before_m, before_s) = match *self {
            Self::Begins => {
                let most_m = off_m + situation.turning_back_m + FARTHER_M;
                (most_m, f64::INFINITY, now_s)
            }
            Self::Goes {
                most_m,
                nearest_m,
                nearest_s,
            } => (most_m, nearest_m, nearest_s),
        };
        let (nearest_m, nearest_s) = if off_m < before_m - NEARER_M {
            (off_m, now_s)
        } else {
            (before_m, before_s)
        };
        *self = Self::Goes {
            most_m,
            nearest_m,
            nearest_s,
        };
        off_m >= RETURNED_SHARE * limit_m && off_m <= most_m && now_s - nearest_s <= NEARER_S
    }
}

impl Monitor {
    /// A monitor that has not fired.
    #[must_use]
    pub fn new(event: EventId, kind: MonitorKind) -> Self {
        Self {
            kind,
            flag: Flag::new(false),
            on_flag: FlagMonitor::on_rise(event),
            way_back: None,
        }
    }

    /// Starts again, as when its skill starts.
    pub fn reset(&mut self) {
        self.flag.restart(false);
        self.way_back = None;
    }

    /// The same for a robot that an operator sends on from off its path: it may return from there.
    pub fn reset_for_return(&mut self) {
        self.reset();
        self.way_back = Some(WayBack::Begins);
    }

    /// The event, when the condition has just become true.
    pub fn step(&mut self, situation: &Situation) -> Option<EventId> {
        if let MonitorKind::Deviation { limit_m } = self.kind {
            let limit_m = limit_m.unwrap_or(situation.deviation_limit_m);
            if situation.lateral_error_m.abs() < limit_m / 2.0 {
                self.flag.set(false);
            }
            if let Some(way_back) = &mut self.way_back {
                if way_back.goes_on(situation, limit_m) {
                    return None;
                }
                self.way_back = None;
            }
        }
        let was_true = self.flag.is_set() || self.holds(situation);
        let change = self.flag.set(was_true)?;
        self.on_flag.event_of(change)
    }

    fn holds(&self, situation: &Situation) -> bool {
        match self.kind {
            MonitorKind::RegionReached { region, .. } => region.contains(situation.pose.position()),
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
            MonitorKind::After { after_s } => situation.in_state_s >= after_s,
            MonitorKind::Deviation { limit_m } => {
                situation.lateral_error_m.abs() > limit_m.unwrap_or(situation.deviation_limit_m)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use description::geometry::{Point2, Rect};
    use description::site::RegionRef;

    fn monitor(kind: MonitorKind) -> Monitor {
        Monitor::new(EventId(3), kind)
    }

    #[test]
    fn a_region_fires_once_until_reset() {
        let region = Rect::new(Point2::new(5.0, -1.0), Point2::new(6.0, 0.0));
        let mut monitor = monitor(MonitorKind::RegionReached {
            of: RegionRef::Own,
            region,
        });
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
        let mut monitor = monitor(MonitorKind::After { after_s: 3.0 });
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

    /// One that has been reset for a return, asked at times with deviations.
    fn returning() -> impl FnMut(f64, f64) -> bool {
        let mut monitor = monitor(MonitorKind::Deviation { limit_m: None });
        monitor.reset_for_return();
        move |in_state_s, lateral_error_m| {
            let situation = Situation {
                deviation_limit_m: 0.3,
                turning_back_m: 0.2,
                lateral_error_m,
                in_state_s,
                ..Situation::default()
            };
            monitor.step(&situation).is_some()
        }
    }

    #[test]
    fn a_deviation_that_an_operator_has_seen_is_news_only_when_it_grows() {
        let mut fired = returning();
        assert!(!fired(0.1, -0.8) && !fired(1.0, -1.05));
        assert!(fired(2.0, -1.11), "farther than turning takes");
        assert!(!fired(3.0, -1.2));
    }

    #[test]
    fn who_does_not_come_nearer_has_strayed_again() {
        let mut fired = returning();
        for step in 0..400 {
            // Half a centimetre each second.
            let at_s = 0.1 * f64::from(step);
            assert!(!fired(at_s, 0.8 - 0.005 * at_s), "{at_s}");
        }
        let standing_m = 0.8 - 0.005 * 40.0;
        let later_s = (400..700).map(|step| 0.1 * f64::from(step));
        let raised: Vec<f64> = later_s.filter(|&at_s| fired(at_s, standing_m)).collect();
        assert!(
            raised.len() == 1 && (50.0..62.0).contains(&raised[0]),
            "{raised:?}"
        );
    }

    #[test]
    fn who_is_back_strays_as_ever() {
        let mut fired = returning();
        assert!(!fired(0.1, 0.8) && !fired(1.0, 0.31) && !fired(2.0, 0.28));
        assert!(!fired(2.5, 0.31), "not back yet");
        assert!(!fired(3.0, 0.25) && fired(3.1, 0.31));
        let mut fired = returning();
        assert!(!fired(0.1, 0.0) && fired(1.0, 0.35), "never away");
    }

    proptest::proptest! {
        /// What a monitor fires is what a Boolean by hand would make it fire, whatever the values.
        #[test]
        fn a_monitor_is_a_latch_of_its_condition(
            steps in proptest::collection::vec((proptest::num::f64::ANY, -1.0..1.0_f64, 0u8..8), 0..60),
        ) {
            let mut monitor = monitor(MonitorKind::Deviation { limit_m: None });
            let mut fired = false;
            for (any, near, what) in steps {
                if what == 0 {
                    monitor.reset();
                    fired = false;
                }
                let lateral_error_m = if what == 1 { any } else { near };
                let situation = Situation {
                    deviation_limit_m: 0.3,
                    lateral_error_m,
                    ..Situation::default()
                };
                fired &= lateral_error_m.is_nan() || lateral_error_m.abs() >= 0.15;
                let fires = !fired && lateral_error_m.abs() > 0.3;
                fired |= fires;
                proptest::prop_assert_eq!(monitor.step(&situation), fires.then_some(EventId(3)));
            }
        }
    }
}
