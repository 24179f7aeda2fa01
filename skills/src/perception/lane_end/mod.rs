//! Tracks the wall at the end of the lane: how far it is, and for how many scans that has been consistent.
//!
//! The wall is searched for where the map has it, with a gate as wide as the pose is uncertain; once found, the tracker
//! follows its own estimate. Only several consistent scans in a row make the estimate stable.

use super::line::{LineFitter, ScanPoints};
use crate::perception::wall_fit::WallFit;
use description::geometry::{Point2, Pose2, Segment, wrap_angle};
use description::robot::Navigation;

/// Gate around the expected wall.
const GATE_MIN_M: f64 = 0.12;
const GATE_SEARCH_MIN_M: f64 = 0.30;
const GATE_MAX_M: f64 = 0.80;
/// A shorter line may be another robot's side.
const MIN_SPAN_M: f64 = 0.8;
/// This many scans without the wall reset the count of consistent ones.
const MISSES_ALLOWED: u32 = 3;
/// After this many scans without it, what was found is forgotten: it may have been something else.
const MISSES_TO_SEARCH: u32 = 10;
/// A line turned farther than this against the map is not the wall.
const TURNED_RAD: f64 = 0.15;
/// This many scans with the wall elsewhere start a new search.
const CONTRADICTIONS_ALLOWED: u32 = 3;
/// A smaller deviation from the prediction never counts as a contradiction, m.
const AGREES_M: f64 = 0.03;
/// Uncertainty that grows even at standstill, per second.
const IDLE_VARIANCE_M2_S: f64 = 1e-6;

/// The end of the lane as the robot sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LaneEndEstimate {
    /// From `base_link` to the wall, perpendicular to it.
    pub distance_m: f64,
    /// Standard deviation of the distance.
    pub std_m: f64,
    /// Scans in a row that showed the wall where it was expected.
    pub consistent_scans: u32,
    /// The last scan showed it.
    pub seen: bool,
}

/// The tracker of one lane's end.
#[derive(Clone, Debug)]
pub struct LaneEndTracker {
    gains: Navigation,
    found: Option<Found>,
    consistent_scans: u32,
    misses: u32,
    contradictions: u32,
    seen: bool,
}

#[derive(Clone, Copy, Debug)]
struct Found {
    distance_m: f64,
    variance_m2: f64,
}

impl LaneEndTracker {
    /// A tracker that has found nothing.
    #[must_use]
    pub fn new(gains: Navigation) -> Self {
        Self {
            gains,
            found: None,
            consistent_scans: 0,
            misses: 0,
            contradictions: 0,
            seen: false,
        }
    }

    /// Forgets what was found.
    pub fn clear(&mut self) {
        self.found = None;
        self.consistent_scans = 0;
        self.misses = 0;
        self.contradictions = 0;
        self.seen = false;
    }

    /// Moves the estimate: `moved` is the new `base_link` in the old one, which stood at `pose` in `map`.
    pub fn predict(&mut self, moved: Pose2, pose: Pose2, wall: &Segment, dt_s: f64) {
        if let Some(found) = &mut self.found {
            let displacement = pose.rotate(moved.position());
            let side = side_of(wall, pose);
            found.distance_m += side * wall.unit().cross(displacement);
            found.variance_m2 += self.gains.odometry_std_m_per_m.powi(2)
                * moved.position().norm_m()
                + IDLE_VARIANCE_M2_S * dt_s;
        }
    }

    /// Looks for the wall in a scan; `pose` is `base_link` in `map`, `std_m` its standard deviation across the wall.
    ///
    /// Returns the wall when it was seen and agreed with.
    pub fn observe(
        &mut self,
        fitter: &mut LineFitter,
        points: ScanPoints<'_>,
        wall: &Segment,
        pose: Pose2,
        std_m: f64,
    ) -> Option<WallFit> {
        self.seen = false;
        let side = side_of(wall, pose);
        let mapped_m = wall.lateral_m(pose.position()) * side;
        let (expected_m, gate_m) = match &self.found {
            Some(found) => (
                found.distance_m,
                (GATE_MIN_M + 3.0 * found.variance_m2.sqrt()).min(GATE_MAX_M),
            ),
            None => (mapped_m, (GATE_SEARCH_MIN_M + 3.0 * std_m).min(GATE_MAX_M)),
        };
        // The wall as seen from where the tracker, not the pose, has the robot.
        let normal = Point2::new(-wall.unit().y_m, wall.unit().x_m) * side;
        let position = pose.position() + normal * (expected_m - mapped_m);
        let believed = Pose2::new(position.x_m, position.y_m, pose.theta_rad);
        let heading_rad = wrap_angle(pose.theta_rad - wall.direction_rad());
        let Some(fit) = fitter
            .fit(points, &wall.seen_from(believed), gate_m, MIN_SPAN_M)
            .filter(|fit| wrap_angle(fit.heading_rad - heading_rad).abs() < TURNED_RAD)
        else {
            self.miss();
            return None;
        };
        let seen_m = fit.lateral_m * side;
        let variance_m2 = fit.covariance[(0, 0)];
        match self.found {
            None => {
                self.found = Some(Found {
                    distance_m: seen_m,
                    variance_m2,
                });
                self.consistent_scans = 1;
            }
            Some(found) => {
                let innovation_m = seen_m - found.distance_m;
                let total_m2 = found.variance_m2 + variance_m2;
                let allowed_m = AGREES_M.max(self.gains.gate_sigma * total_m2.sqrt());
                if innovation_m.abs() > allowed_m {
                    self.contradict();
                    return None;
                }
                let gain = found.variance_m2 / total_m2;
                self.found = Some(Found {
                    distance_m: found.distance_m + gain * innovation_m,
                    variance_m2: (1.0 - gain) * found.variance_m2,
                });
                self.consistent_scans = self.consistent_scans.saturating_add(1);
            }
        }
        self.seen = true;
        self.misses = 0;
        self.contradictions = 0;
        Some(fit)
    }

    /// The estimate, once the wall was found.
    #[must_use]
    pub fn estimate(&self) -> Option<LaneEndEstimate> {
        self.found.map(|found| LaneEndEstimate {
            distance_m: found.distance_m,
            std_m: found.variance_m2.max(0.0).sqrt(),
            consistent_scans: self.consistent_scans,
            seen: self.seen,
        })
    }

    fn miss(&mut self) {
        self.misses = self.misses.saturating_add(1);
        if self.misses >= MISSES_ALLOWED {
            self.consistent_scans = 0;
        }
        if self.misses >= MISSES_TO_SEARCH {
            self.clear();
        }
    }

    fn contradict(&mut self) {
        self.consistent_scans = 0;
        self.contradictions += 1;
        if self.contradictions >= CONTRADICTIONS_ALLOWED {
            self.clear();
        }
    }
}

/// +1 when the robot is to the left of the wall's direction, −1 to the right.
fn side_of(wall: &Segment, pose: Pose2) -> f64 {
    if wall.lateral_m(pose.position()) < 0.0 {
        -1.0
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests;
