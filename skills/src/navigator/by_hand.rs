//! Driven by hand: what a teleoperator wants stands in place of what the controller wants.
//!
//! Everything else goes on: pose, map, borders, limits and ramp hold as for the controller, and areas that lie ahead are
//! asked for. The machine takes what is sent to it from outside, and monitors rest: they judge how a skill gets on, and
//! none drives. When nobody drives by hand any more, the robot stands until motion is allowed; then the path of the
//! machine's state goes on from where the robot is, as after an operator's reset.

use super::control::Control;
use super::output::NavigationInput;
use super::state::Navigator;
use crate::borders::{AreaSet, BorderVerdict};
use crate::control::Steer;
use crate::schedule::Hold;
use crate::schedule::controllers::motion::{PATH_POSES, pose_error};
use description::areas::AreaIndex;
use description::geometry::{Pose2, Twist2};

/// A slower wish is one to stand: no curve follows from it.
const SLOWEST_WISH_M_S: f64 = 0.01;
/// A path leads deeper into an area when its overlap grows by more than this.
const DEEPER_M: f64 = 1e-3;

impl Navigator {
    /// Whether the robot is, or has been and was not sent on since, driven by hand.
    pub(super) fn is_by_hand(&mut self, input: &NavigationInput) -> bool {
        if input.by_hand.is_some() {
            self.by_hand = true;
        } else if self.by_hand && input.motion_allowed {
            self.by_hand = false;
            // Its path is driven on from here, or from where its law leads back to it.
            self.begin_motion_at(self.began);
            self.in_state_s = 0.0;
            self.let_return();
        }
        self.by_hand
    }

    /// What the hand wants, as a controller says it.
    pub(super) fn control_by_hand(&self, input: &NavigationInput) -> Control {
        let schedule = self.schedule_now();
        let lane = schedule.lane.map(|lane| &self.map.lanes()[lane]);
        let error = lane.map(|lane| pose_error(lane, self.pose.pose()));
        let standing = Control {
            steer: Steer {
                error: error.unwrap_or_default(),
                ..Steer::default()
            },
            hold: Some(Hold::ByHand),
            ..Control::default()
        };
        let Some(hand) = input.by_hand else {
            return standing;
        };
        let Twist2 { v_m_s, omega_rad_s } = hand.wish;
        let moves = v_m_s.abs() >= SLOWEST_WISH_M_S && omega_rad_s.is_finite();
        if !(moves && v_m_s.is_finite()) {
            return standing;
        }
        let instructed_m_s = self.parameters.speed_limit_m_s.unwrap_or(f64::INFINITY);
        let creep_m_s = if self.knows_borders(input) {
            f64::INFINITY
        } else {
            hand.creep_m_s
        };
        let limit_m_s = { hand.limit_m_s.min(self.max_speed_m_s) }
            .min(instructed_m_s)
            .min(creep_m_s)
            .max(0.0);
        let tightest_1_m = self.gains.max_curvature_1_m;
        Control {
            steer: Steer {
                curvature_1_m: (omega_rad_s / v_m_s).clamp(-tightest_1_m, tightest_1_m),
                direction: v_m_s.signum(),
                speed_share: 1.0,
                ..standing.steer
            },
            wish_m_s: v_m_s.clamp(-limit_m_s, limit_m_s),
            safe_m_s: f64::INFINITY,
            left_m: f64::INFINITY,
            done: false,
            hold: (instructed_m_s == 0.0).then_some(Hold::SpeedLimit),
        }
    }

    /// Borders mean something: the robot knows where it is, and, where areas are managed, is a part of that. One that may
    /// be in no area at all has nobody who knows where it is.
    pub(super) fn knows_borders(&self, input: &NavigationInput) -> bool {
        !self.pose.is_uncertain() && !input.allowed.is_empty()
    }

    /// Why a robot that is driven by hand must stand, whatever is wanted.
    pub(super) fn stands_by_hand(&self, input: &NavigationInput) -> Option<Hold> {
        if !input.motion_allowed {
            return Some(Hold::Forbidden);
        }
        let lost = !self.knows_borders(input) && self.allowed_by_hand(input) != AreaSet::ALL;
        lost.then_some(Hold::PoseUncertain)
    }

    /// Areas whose borders do not hold up a hand: all, where they mean nothing and somebody sees to it.
    pub(super) fn allowed_by_hand(&self, input: &NavigationInput) -> AreaSet {
        let sees_to_it = { input.by_hand.as_ref() }.is_some_and(|hand| hand.without_borders);
        if sees_to_it && !self.knows_borders(input) {
            AreaSet::ALL
        } else {
            input.allowed
        }
    }

    /// The path ahead is the curve that is wanted.
    pub(super) fn plan_by_hand(&mut self, control: &Control) {
        self.path.clear();
        let Steer {
            direction,
            curvature_1_m,
            ..
        } = control.steer;
        if direction == 0.0 {
            return;
        }
        let way_m = direction * self.path_step_m;
        let step = Twist2::new(way_m, way_m * curvature_1_m);
        let mut pose = self.pose.pose();
        for _ in 0..PATH_POSES {
            pose = pose.advance(step, 1.0);
            if !pose.is_finite() {
                return;
            }
            self.path.push(pose);
        }
    }

    /// A robot that stands in an area without leave may be driven out of it, and along it, but no deeper into it.
    pub(super) fn is_driven_out(
        &self,
        verdict: &BorderVerdict,
        area: AreaIndex,
        ahead: &[Pose2],
    ) -> bool {
        if !(verdict.inside && self.by_hand) || ahead.is_empty() {
            return false;
        }
        let gap_m = |pose: Pose2| self.guard.bare_gap_m(area, pose);
        let now_m = gap_m(self.pose.pose());
        ahead.iter().all(|pose| gap_m(*pose) >= now_m - DEEPER_M)
    }
}
