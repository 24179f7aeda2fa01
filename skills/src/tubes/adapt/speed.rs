//! How fast the chosen tube may be driven.

use super::motion_tubes::MotionTubes;
use super::outcome::{Adapted, Reason, Verdict};
use super::select::Selection;
use crate::tubes::memory::moving::highest_speed_m_s;
use description::geometry::{MotionCommand, Twist2};

/// Below this speed the robot counts as standing and may reverse.
pub(super) const AT_REST_M_S: f64 = 0.02;
/// Below this speed the twist gives no usable curvature.
const STEERED_M_S: f64 = 0.1;
/// While the robot's curvature differs from the selected one by more, its own curve must be free too.
const STEERED_AWAY_1_M: f64 = 0.5;
/// Share of the available deceleration used to slow down towards something that moves.
const GENTLE_SHARE: f64 = 0.5;
/// Tolerance above the speed that something moving allows, before it becomes a reason to stop.
const OVERSPEED_M_S: f64 = 0.03;

impl MotionTubes {
    /// The command in a tube that was chosen, or the reason to stop.
    pub(super) fn drive(
        &mut self,
        wanted: MotionCommand,
        current: Twist2,
        selection: Selection,
        now_ns: u64,
    ) -> Adapted {
        let delay_s = self.delay_s(now_ns);
        if current.v_m_s.abs() > AT_REST_M_S && current.v_m_s * wanted.speed_m_s < 0.0 {
            self.driven = None;
            return self.stop(Reason::Reversing, None, now_ns, now_ns);
        }
        let length_m = self.length_m(&selection, current);
        let decel = self.stop_deceleration_m_s2;
        let speed_m_s = current.v_m_s.abs();
        if self.is_too_fast(&selection, current, now_ns) {
            self.driven = None;
            return self.stop(Reason::TooFast, Some(selection), now_ns, now_ns);
        }
        let lag_m_s = decel * delay_s;
        let stoppable_m_s = (lag_m_s * lag_m_s + 2.0 * decel * length_m).sqrt() - lag_m_s;
        let Some(unmet_m_s) = self.unmet_m_s(speed_m_s, delay_s) else {
            let since_ns = *self.moving_since_ns.get_or_insert_with(|| {
                self.counters.moving_stops += 1;
                now_ns
            });
            return self.stop(Reason::Moving, Some(selection), since_ns, now_ns);
        };
        self.moving_since_ns = None;
        let mut allowed_m_s = self.set.rows[selection.row].horizon.speed_m_s;
        if self.detour.is_active() {
            allowed_m_s = allowed_m_s.min(self.policy.detour.speed_m_s);
        }
        if self.detour.waits() {
            allowed_m_s = 0.0;
        }
        let wanted_m_s = wanted.speed_m_s.abs();
        let speed_m_s = wanted_m_s
            .min(allowed_m_s)
            .min(stoppable_m_s)
            .min(unmet_m_s)
            .min(self.ceiling_m_s);
        self.ceiling_m_s = speed_m_s;
        self.driven = Some(selection);
        self.last_curvature_1_m = selection.curvature_1_m;
        let slowed = speed_m_s < wanted_m_s;
        let (verdict, reason) = if selection.shift_1_m != 0.0 {
            (Verdict::Shifted, Reason::Blocked)
        } else if slowed && (unmet_m_s <= speed_m_s || self.detour.waits()) {
            (Verdict::Slowed, Reason::Moving)
        } else if slowed {
            (Verdict::Slowed, Reason::Blocked)
        } else {
            (Verdict::Free, Reason::None)
        };
        let sign = if wanted.speed_m_s < 0.0 { -1.0 } else { 1.0 };
        Adapted {
            command: MotionCommand::new(sign * speed_m_s, selection.curvature_1_m),
            verdict,
            reason,
            tube: Some(selection.tube),
            length_m,
            clearance_m: self.clearance_m,
            moving_m: self.moving.nearest_m(),
            scan_age_ns: self.sight.age_ns(now_ns),
            stopped_since_ns: 0,
        }
    }

    /// A hard stop that begins now needs more room than there is.
    pub(super) fn is_too_fast(&self, selection: &Selection, current: Twist2, now_ns: u64) -> bool {
        let speed_m_s = current.v_m_s.abs();
        let braking_m = speed_m_s * speed_m_s / (2.0 * self.stop_deceleration_m_s2);
        speed_m_s * self.delay_s(now_ns) + braking_m > self.length_m(selection, current)
    }

    /// From what the newest scan saw until the wheels answer.
    fn delay_s(&self, now_ns: u64) -> f64 {
        self.sight.age_ns(now_ns) as f64 * 1e-9 + self.policy.reaction_s
    }

    /// How far it is free: along the selected tube and, while the robot still turns otherwise, along that curve, too.
    fn length_m(&self, selection: &Selection, current: Twist2) -> f64 {
        if current.v_m_s.abs() < STEERED_M_S {
            return selection.length_m;
        }
        let curvature_1_m = current.omega_rad_s / current.v_m_s;
        if (curvature_1_m - selection.curvature_1_m).abs() < STEERED_AWAY_1_M {
            return selection.length_m;
        }
        self.selector()
            .free_length_m(curvature_1_m, current.v_m_s < 0.0)
            .map_or(selection.length_m, |free_m| free_m.min(selection.length_m))
    }

    /// The highest speed that lets the robot stand before something that moves arrives; `None` when it must stop.
    fn unmet_m_s(&self, speed_m_s: f64, delay_s: f64) -> Option<f64> {
        let decel = self.stop_deceleration_m_s2;
        let away_m = self.moving.nearest_m();
        let highest =
            |decel_m_s2| highest_speed_m_s(&self.policy.moving, away_m, delay_s, decel_m_s2);
        let hardly_m_s = highest(decel);
        let too_fast = speed_m_s > hardly_m_s.max(0.0) + OVERSPEED_M_S;
        if hardly_m_s <= 0.0 || too_fast {
            return None;
        }
        Some(highest(GENTLE_SHARE * decel).max(0.0))
    }
}
