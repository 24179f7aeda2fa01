//! Corrections by every mapped wall in view.

use super::doubt::ScanVerdict;
use super::filter::{LARGEST_STD, PoseFilter};
use crate::perception::WallFit;
use crate::perception::walls::{BeamCounts, SeenWall, WallMatcher};
use crate::scan::AlignedScan;
use description::geometry::{Pose2, Twist2, wrap_angle};
use nalgebra::{Matrix2, Matrix3, Vector3};

/// A scan is matched again from the corrected pose, in this many passes at most,
const PASSES: usize = 3;
/// when the correction was larger than this.
const AGAIN_M: f64 = 0.05;
const AGAIN_RAD: f64 = 0.03;

/// Standard deviation of the time between beams, encoders and clock.
const TIMING_STD_S: f64 = 0.003;
/// Least standard deviations, however many scans: errors of the map and the mounting.
const FLOOR_STD_M: f64 = 0.003;
const FLOOR_STD_RAD: f64 = 0.001;

/// After a long contradiction a wall counts only with this length seen, and this share of what lies in its gate.
const SUBSTANTIAL_M: f64 = 1.0;
const SUBSTANTIAL_SHARE: f64 = 0.6;

/// What a scan did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallsOutcome {
    /// For the pose.
    pub verdict: ScanVerdict,
    /// Walls that corrected it.
    pub corrected: u32,
    /// Walls that were recognised, but too improbable.
    pub refused: u32,
    /// How the beams agree with the map.
    pub beams: BeamCounts,
}

impl PoseFilter {
    /// Corrects the pose by every mapped wall that the scan shows, and counts the scan: [`scan_done`](Self::scan_done)
    /// is not to be called for it. `since` is where the scan has `base_link`, seen from `base_link` now.
    pub fn see_walls(
        &mut self,
        matcher: &mut WallMatcher,
        scan: &AlignedScan,
        since: Pose2,
    ) -> WallsOutcome {
        let mut view = self.clone();
        let mut pass = 0;
        loop {
            pass += 1;
            // Matched from the best pose found, but the correction always starts from the pose before the scan, so
            // that no point counts twice.
            let seen = matcher.observe(scan, since, view.pose, &view.covariance);
            let (beams, expected) = (seen.beams, seen.expected);
            let mut trial = self.clone();
            let (corrected, refused) = trial.correct_by(seen.seen);
            let moved = view.pose.between(trial.pose);
            let far = moved.position().norm_m() > AGAIN_M
                || wrap_angle(moved.theta_rad).abs() > AGAIN_RAD;
            if far && corrected > 0 && pass < PASSES {
                view = trial;
                continue;
            }
            let verdict = if beams.walls_through > 0 {
                ScanVerdict::Contradicted
            } else if corrected > 0 {
                ScanVerdict::Corrected
            } else if refused > 0 {
                ScanVerdict::Refused
            } else if expected {
                ScanVerdict::Blind
            } else {
                ScanVerdict::Nothing
            };
            *self = trial;
            self.scan_done(verdict);
            return WallsOutcome {
                verdict,
                corrected,
                refused,
                beams,
            };
        }
    }

    fn correct_by(&mut self, seen: &[SeenWall]) -> (u32, u32) {
        let (mut corrected, mut refused) = (0, 0);
        // After a long contradiction the gates are wide: a robot's side must not count as a wall.
        let insisted = self.doubt.insisted();
        let twist = self.last.map_or(Twist2::default(), |last| last.twist);
        let [late_m2, late_rad2] = [twist.v_m_s, twist.omega_rad_s]
            .map(|speed| (TIMING_STD_S * speed).abs().min(LARGEST_STD).powi(2));
        let timing = Matrix2::new(late_m2, 0.0, 0.0, late_rad2);
        for wall in seen {
            let substantial =
                wall.fit.covered_m >= SUBSTANTIAL_M && wall.fit.share >= SUBSTANTIAL_SHARE;
            let fit = WallFit {
                covariance: wall.fit.covariance + timing,
                ..wall.fit
            };
            if (substantial || !insisted) && self.correct(&wall.line, &fit) {
                corrected += 1;
            } else {
                refused += 1;
            }
        }
        if corrected > 0 {
            let position = FLOOR_STD_M.powi(2) + late_m2;
            let least = Vector3::new(position, position, FLOOR_STD_RAD.powi(2) + late_rad2);
            let lacking = (least - self.covariance.diagonal()).map(|lack| lack.max(0.0));
            self.covariance += Matrix3::from_diagonal(&lacking);
        }
        (corrected, refused)
    }
}
