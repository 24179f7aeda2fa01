//! The command: what the controller wants, within the limits of areas, borders and the ramp.

use super::control::Control;
use super::output::NavigationInput;
use super::state::Navigator;
use crate::borders::{AreaSet, BorderVerdict, Curve};
use crate::control::{REACTION_S, approach_speed_m_s};
use crate::schedule::Hold;
use crate::schedule::controllers::motion::{Ahead, PATH_POSES};
use description::areas::AreaIndex;
use description::geometry::{MotionCommand, Pose2};

/// The border guard looks at least this far ahead,
const LOOK_M: f64 = 0.15;
/// and this far behind the robot.
const BEHIND_M: f64 = 0.5;
/// A slower command becomes 0: the wheels would not turn evenly.
const SLOWEST_M_S: f64 = 0.008;
/// Areas that a robot can be leaving at once.
const LEAVING: usize = 4;
/// A path leads closer to an area when it shrinks the gap by more than this.
const NEARER_M: f64 = 1e-3;

/// What is commanded, and why not more.
#[derive(Clone, Copy, Debug)]
pub(super) struct Commanded {
    pub(super) command: MotionCommand,
    pub(super) hold: Option<Hold>,
    pub(super) border: BorderVerdict,
    pub(super) at_border: bool,
    /// Distance behind the robot without a forbidden area, straight and on the tightest curves.
    pub(super) behind_m: f64,
}

impl Navigator {
    /// Plans the path ahead and limits what the controller wants.
    pub(super) fn command(
        &mut self,
        input: &NavigationInput,
        control: &Control,
        dt_s: f64,
    ) -> Commanded {
        let speed_m_s = self.speed_m_s(input);
        if self.by_hand {
            self.plan_by_hand(control);
        } else {
            self.plan_ahead(control, speed_m_s);
        }
        let border = self.look_ahead(input, speed_m_s);
        let border_m_s = border.speed_limit_m_s(self.gains.deceleration_m_s2, REACTION_S);
        let stand = if self.by_hand {
            self.stands_by_hand(input)
        } else if self.pose.is_uncertain() {
            Some(Hold::PoseUncertain)
        } else if !input.motion_allowed {
            Some(Hold::Forbidden)
        } else {
            None
        };
        let safe_m_s = if stand.is_some() {
            0.0
        } else {
            control.safe_m_s.min(border_m_s)
        };
        let area_m_s = self.area_limit_m_s();
        let wish_m_s = control.wish_m_s.max(-area_m_s).min(area_m_s);
        let mut commanded_m_s = self.ramp.step(wish_m_s, safe_m_s, speed_m_s, dt_s);
        // The ramp starts below `SLOWEST_M_S`; only a limit below it means standing.
        if safe_m_s < SLOWEST_M_S {
            commanded_m_s = 0.0;
        }
        let moving = control.steer.direction != 0.0;
        let curvature_1_m = if moving && control.steer.curvature_1_m.is_finite() {
            control.steer.curvature_1_m
        } else {
            // Coming to rest, it stays on the curve that it was on.
            self.last_curvature_1_m
        };
        self.last_curvature_1_m = curvature_1_m;
        let at_border = border.area.is_some()
            && (border.inside || border_m_s < control.safe_m_s.min(control.wish_m_s.abs()));
        let hold = stand
            .or(control.hold)
            .or((at_border && border_m_s < SLOWEST_M_S).then_some(Hold::Border));
        Commanded {
            command: MotionCommand::new(commanded_m_s, curvature_1_m),
            hold,
            border,
            at_border,
            behind_m: self.look_behind_m(&input.allowed),
        }
    }

    fn plan_ahead(&mut self, control: &Control, speed_m_s: f64) {
        let lane = self.schedule_now().lane;
        let length_m = self.path_step_m * PATH_POSES as f64;
        let ahead = Ahead {
            lane: lane.map(|lane| &self.map.lanes()[lane]),
            speed_m_s,
            step_m: self.path_step_m,
            length_m: length_m.min(control.left_m),
            gains: &self.gains,
        };
        self.motion.plan(&mut self.path, self.pose.pose(), &ahead);
    }

    /// Fastest speed here, and slow enough for the areas that the planned path leads through, whatever the state is about.
    fn area_limit_m_s(&self) -> f64 {
        let limit_m_s = |pose: &Pose2| {
            let area = self.map.area_at(pose.position());
            area.map_or(f64::INFINITY, |area| self.map.area(area).speed_limit_m_s)
        };
        let deceleration_m_s2 = self.gains.deceleration_m_s2;
        let ahead = self.path.iter().enumerate().map(|(index, pose)| {
            // The border lies somewhere after the pose before.
            let way_m = index as f64 * self.path_step_m;
            approach_speed_m_s(way_m, limit_m_s(pose), deceleration_m_s2)
        });
        ahead.fold(limit_m_s(&self.pose.pose()), f64::min)
    }

    /// Looks along the planned path as far as the robot needs to stop.
    fn look_ahead(&self, input: &NavigationInput, speed_m_s: f64) -> BorderVerdict {
        let speed_m_s = speed_m_s.abs().max(self.ramp.speed_m_s().abs());
        let reach_m = speed_m_s * speed_m_s / (2.0 * self.gains.deceleration_m_s2)
            + 2.0 * REACTION_S * speed_m_s
            + LOOK_M;
        let poses = (reach_m / self.path_step_m).ceil() as usize;
        let ahead = &self.path[..poses.min(self.path.len())];
        let mut allowed = if self.by_hand {
            self.allowed_by_hand(input)
        } else {
            input.allowed
        };
        let mut verdict = self.judge(&allowed, ahead);
        for _ in 0..LEAVING {
            match verdict.area {
                Some(area)
                    if self.is_leaving(&verdict, area, ahead)
                        || self.is_driven_out(&verdict, area, ahead) =>
                {
                    allowed.insert(area);
                    verdict = self.judge(&allowed, ahead);
                }
                _ => break,
            }
        }
        verdict
    }

    /// How far back the robot might go, straight or on the tightest curves.
    fn look_behind_m(&self, allowed: &AreaSet) -> f64 {
        let tightest_1_m = self.gains.max_curvature_1_m;
        let (pose, covariance) = (self.pose.pose(), self.pose.covariance());
        let back = [-tightest_1_m, 0.0, tightest_1_m].map(|curvature_1_m| {
            let curve = Curve {
                curvature_1_m,
                reach_m: -BEHIND_M,
            };
            let verdict = self.guard.along_curve(allowed, pose, covariance, curve);
            verdict.distance_m
        });
        back.into_iter().fold(BEHIND_M, f64::min)
    }

    fn judge(&self, allowed: &AreaSet, ahead: &[Pose2]) -> BorderVerdict {
        let (pose, covariance) = (self.pose.pose(), self.pose.covariance());
        self.guard
            .along_poses(allowed, pose, covariance, ahead.iter().copied())
    }

    /// Only the uncertainty of the pose touches the area, and the path ahead leads no closer to it. Holding such a robot
    /// would gain nothing, and could be a deadlock.
    fn is_leaving(&self, verdict: &BorderVerdict, area: AreaIndex, ahead: &[Pose2]) -> bool {
        if verdict.inside || verdict.distance_m > 0.0 || ahead.is_empty() {
            return false;
        }
        let region = &self.map.area(area).region;
        let gap_m = |pose: Pose2| self.footprint.gap_m(pose, region);
        let now_m = gap_m(self.pose.pose());
        ahead.iter().all(|pose| gap_m(*pose) >= now_m - NEARER_M)
    }
}
