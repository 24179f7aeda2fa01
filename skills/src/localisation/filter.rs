//! The extended Kalman filter over x, y, θ.

use std::f64::consts::PI;

use super::doubt::{Doubt, ScanVerdict};
use crate::odometry::Odometry;
use crate::perception::WallFit;
use description::geometry::{Pose2, Segment, wrap_angle};
use description::robot::Navigation;
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector2, Vector3};

/// Uncertainty that grows even at standstill: (1 mm)² and (1 mrad)² per second.
const IDLE_VARIANCE_1_S: f64 = 1e-6;
/// Turning adds uncertainty as this way per radian would.
const TURN_WAY_M_PER_RAD: f64 = 0.5;
/// No standard deviation grows beyond this, so that the filter stays well conditioned.
pub(super) const LARGEST_STD: f64 = 10.0;
/// An odometry step is rejected as a leap beyond this, whatever time it took: more than a drive rolls without being told to,
const LEAP_M: f64 = 2.5;
/// or beyond these speeds plus a slack for the error of the stamps.
const FASTEST_M_S: f64 = 3.0;
const FASTEST_RAD_S: f64 = 6.0;
const LEAP_SLACK_M: f64 = 0.05;
const LEAP_SLACK_RAD: f64 = 0.10;
/// Uncertainty that a rejected leap adds, or way that was not measured.
const LEAP_STD_M: f64 = 0.10;
const LEAP_STD_RAD: f64 = 0.10;

/// Factor on the covariance for each scan that keeps contradicting the pose.
const INSISTENCE: f64 = 1.5;

/// Corrections since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PoseCounters {
    /// Walls that corrected the pose.
    pub corrections: u64,
    /// Walls that were too improbable.
    pub refused: u64,
    /// Odometry steps that were not finite or leapt.
    pub odometry_leaps: u64,
}

/// The filter.
#[derive(Clone, Debug)]
pub struct PoseFilter {
    pub(super) gains: Navigation,
    pub(super) pose: Pose2,
    pub(super) covariance: Matrix3<f64>,
    pub(super) last: Option<Odometry>,
    pub(super) doubt: Doubt,
    pub(super) counters: PoseCounters,
}

impl PoseFilter {
    /// Starts at a pose known to the given standard deviations.
    #[must_use]
    pub fn new(gains: Navigation, start: Pose2, std_m: f64, std_rad: f64) -> Self {
        let mut filter = Self {
            gains,
            pose: start,
            covariance: Matrix3::identity(),
            last: None,
            doubt: Doubt::default(),
            counters: PoseCounters::default(),
        };
        filter.relocate(start, std_m, std_rad);
        filter
    }

    /// Puts the pose somewhere else, as an operator does.
    pub fn relocate(&mut self, pose: Pose2, std_m: f64, std_rad: f64) {
        self.pose = pose;
        let (position, heading) = (std_m * std_m, std_rad * std_rad);
        self.covariance = Matrix3::from_diagonal(&Vector3::new(position, position, heading));
        self.doubt = Doubt::default();
        self.judge();
    }

    /// Goes on from a pose that was known when odometry was this.
    pub fn resume(&mut self, pose: Pose2, covariance: Matrix3<f64>, odometry: &Odometry) {
        (self.pose, self.covariance) = (pose, covariance);
        self.last = Some(*odometry);
        self.doubt = Doubt::default();
        self.judge();
    }

    /// Takes over what another filter knows, and keeps its own gains.
    pub fn adopt(&mut self, other: &Self) {
        let gains = self.gains;
        *self = other.clone();
        self.gains = gains;
        self.judge();
    }

    /// Moves the pose by what odometry moved since the last call, and returns that: the new `base_link` in the old one.
    pub fn predict(&mut self, odometry: &Odometry) -> Pose2 {
        let Some(last) = self.last.replace(*odometry) else {
            return Pose2::IDENTITY;
        };
        let moved = last.pose.between(odometry.pose);
        let dt_s = odometry.stamp_ns.saturating_sub(last.stamp_ns) as f64 * 1e-9;
        if !moved.is_finite() {
            self.counters.odometry_leaps += 1;
            self.last = Some(last);
            return Pose2::IDENTITY;
        }
        let furthest_m = (LEAP_SLACK_M + FASTEST_M_S * dt_s).min(LEAP_M);
        let widest_rad = LEAP_SLACK_RAD + FASTEST_RAD_S * dt_s;
        if moved.position().norm_m() > furthest_m || moved.theta_rad.abs() > widest_rad {
            // The pose stays; how far the robot really moved is unknown.
            self.counters.odometry_leaps += 1;
            self.doubt_way();
            self.doubt_unmeasured(moved.position().norm_m());
            return Pose2::IDENTITY;
        }
        if last.breaks != odometry.breaks {
            self.doubt_way();
        }
        self.doubt_unmeasured(odometry.unmeasured_m - last.unmeasured_m);
        let displacement = self.pose.rotate(moved.position());
        let motion = Matrix3::new(
            1.0,
            0.0,
            -displacement.y_m,
            0.0,
            1.0,
            displacement.x_m,
            0.0,
            0.0,
            1.0,
        );
        let way_m = growth(last.distance_m, odometry.distance_m);
        let turned_rad = growth(last.turned_rad, odometry.turned_rad);
        let effective_m = way_m + TURN_WAY_M_PER_RAD * turned_rad;
        let idle = IDLE_VARIANCE_1_S * dt_s.min(10.0);
        let position = self.gains.odometry_std_m_per_m.powi(2) * effective_m + idle;
        let heading = self.gains.odometry_std_rad_per_m.powi(2) * effective_m + idle;
        let noise = Matrix3::from_diagonal(&Vector3::new(position, position, heading));
        self.covariance = motion * self.covariance * motion.transpose() + noise;
        self.doubt_slip(growth(last.slipped_m, odometry.slipped_m));
        self.pose = self.pose.compose(moved);
        self.bound();
        self.judge();
        moved
    }

    /// Part of the way may not have been driven: all of it in one direction, so the deviation grows by it, not the variance.
    fn doubt_slip(&mut self, slipped_m: f64) {
        let added = slipped_m * (2.0 * self.position_std_m() + slipped_m);
        self.covariance += Matrix3::from_diagonal(&Vector3::new(added, added, 0.0));
    }

    /// The robot may have moved by this way, whereto is not known, and have turned by as many radians.
    fn doubt_unmeasured(&mut self, way_m: f64) {
        if way_m > 0.0 {
            let variance = way_m.min(LARGEST_STD).powi(2);
            let turned = way_m.min(PI).powi(2);
            self.covariance += Matrix3::from_diagonal(&Vector3::new(variance, variance, turned));
            self.bound();
            self.judge();
        }
    }

    /// How far the robot has moved is not known.
    fn doubt_way(&mut self) {
        let (position, heading) = (LEAP_STD_M * LEAP_STD_M, LEAP_STD_RAD * LEAP_STD_RAD);
        self.covariance += Matrix3::from_diagonal(&Vector3::new(position, position, heading));
        self.bound();
        self.judge();
    }

    /// Corrects the pose by a wall: `line` is the wall in `map`, directed as in the fit. `false`: refused.
    pub fn correct(&mut self, line: &Segment, fit: &WallFit) -> bool {
        let direction_rad = line.direction_rad();
        let (sin, cos) = direction_rad.sin_cos();
        let innovation = Vector2::new(
            fit.lateral_m - line.lateral_m(self.pose.position()),
            wrap_angle(fit.heading_rad - wrap_angle(self.pose.theta_rad - direction_rad)),
        );
        let model = Matrix2x3::new(-sin, cos, 0.0, 0.0, 0.0, 1.0);
        let total: Matrix2<f64> = model * self.covariance * model.transpose() + fit.covariance;
        let Some(inverse) = total.try_inverse() else {
            self.counters.refused += 1;
            return false;
        };
        let distance = (innovation.transpose() * inverse * innovation).x;
        // Also refuses what is not a number.
        if distance.is_nan() || distance > self.gains.gate_sigma.powi(2) {
            self.counters.refused += 1;
            return false;
        }
        let gain = self.covariance * model.transpose() * inverse;
        let step: Vector3<f64> = gain * innovation;
        self.pose = Pose2::new(
            self.pose.x_m + step.x,
            self.pose.y_m + step.y,
            wrap_angle(self.pose.theta_rad + step.z),
        );
        let rest = Matrix3::identity() - gain * model;
        self.covariance =
            rest * self.covariance * rest.transpose() + gain * fit.covariance * gain.transpose();
        self.covariance = (self.covariance + self.covariance.transpose()) * 0.5;
        self.counters.corrections += 1;
        true
    }

    /// Told once for each scan in which walls were looked for.
    pub fn scan_done(&mut self, verdict: ScanVerdict) {
        if self.doubt.scan(verdict) {
            // The pose may be wrong: widen the gate until walls agree again.
            self.covariance *= INSISTENCE;
            self.bound();
        }
        self.judge();
    }

    /// `base_link` in `map`.
    #[must_use]
    pub fn pose(&self) -> Pose2 {
        self.pose
    }

    /// Of (x, y, θ).
    #[must_use]
    pub fn covariance(&self) -> &Matrix3<f64> {
        &self.covariance
    }

    /// Standard deviation of the position in its worst direction.
    #[must_use]
    pub fn position_std_m(&self) -> f64 {
        let (xx, xy, yy) = (
            self.covariance[(0, 0)],
            self.covariance[(0, 1)],
            self.covariance[(1, 1)],
        );
        let middle = (xx + yy) / 2.0;
        let half = ((xx - yy) / 2.0).hypot(xy);
        (middle + half).max(0.0).sqrt()
    }

    /// Standard deviation of the position along a direction of `map`.
    #[must_use]
    pub fn std_along_m(&self, direction_rad: f64) -> f64 {
        let (sin, cos) = direction_rad.sin_cos();
        let variance = self.covariance[(0, 0)] * cos * cos
            + 2.0 * self.covariance[(0, 1)] * sin * cos
            + self.covariance[(1, 1)] * sin * sin;
        variance.max(0.0).sqrt()
    }

    /// Standard deviation of the heading.
    #[must_use]
    pub fn heading_std_rad(&self) -> f64 {
        self.covariance[(2, 2)].max(0.0).sqrt()
    }

    /// The pose is not good enough to drive by.
    #[must_use]
    pub fn is_uncertain(&self) -> bool {
        self.doubt.is_uncertain()
    }

    /// Dead reckoning that it was moved by last.
    #[must_use]
    pub fn odometry(&self) -> Odometry {
        self.last.unwrap_or_default()
    }

    /// Corrections since the start.
    #[must_use]
    pub fn counters(&self) -> PoseCounters {
        self.counters
    }

    pub(super) fn judge(&mut self) {
        let worst = (self.position_std_m() / self.gains.max_std_m)
            .max(self.heading_std_rad() / self.gains.max_std_rad);
        self.doubt.judge(worst);
    }

    fn bound(&mut self) {
        let largest = (0..3)
            .map(|axis| self.covariance[(axis, axis)])
            .fold(0.0, f64::max);
        if largest > LARGEST_STD * LARGEST_STD {
            self.covariance *= LARGEST_STD * LARGEST_STD / largest;
        }
    }
}

/// The increase of a sum that never falls; 0 when it fell or is NaN.
fn growth(before: f64, now: f64) -> f64 {
    let grown = now - before;
    if grown > 0.0 { grown.min(LEAP_M) } else { 0.0 }
}
