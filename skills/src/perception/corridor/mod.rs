//! Tracks how the robot lies in its corridor: lateral offset from the lane and heading relative to it.
//!
//! Between scans the estimate moves with odometry. Each scan is searched for the walls that the map puts on both sides of
//! the lane, near where the estimate expects them; one wall is enough, none lets the uncertainty grow. A side may consist
//! of several pieces with openings between them: nothing is expected in an opening.

use super::line::{LineFitter, ScanPoints};
use crate::map::{LaneGeometry, LaneWall};
use crate::perception::wall_fit::WallFit;
use description::geometry::{Pose2, wrap_angle};
use description::robot::Navigation;
use nalgebra::{Matrix2, Vector2};

/// Least and largest distance from the expected wall within which points are taken.
const GATE_MIN_M: f64 = 0.12;
const GATE_MAX_M: f64 = 0.60;
/// At least this length of a wall must be seen to give a direction; of a short piece this share.
const MIN_SPAN_M: f64 = 0.4;
const MIN_SPAN_SHARE: f64 = 0.6;
/// Pieces of wall farther along the lane than this are left alone: they are seen too flat.
const REACH_M: f64 = 4.0;
/// Pieces of wall that one scan may show beside a lane.
pub const MAX_PIECES: usize = 8;
/// After this many scans in a row whose walls were all refused, the estimate counts as wrong.
const REFUSALS_TO_RESTART: u32 = 5;
/// Uncertainty that grows even at standstill, per second.
const IDLE_VARIANCE_M2_S: f64 = 1e-6;
/// Less certain than this, the estimate is not used.
const USABLE_STD_M: f64 = 0.15;
const USABLE_STD_RAD: f64 = 0.15;

/// The corridor as the robot lies in it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CorridorEstimate {
    /// Of `base_link` from the lane's centre line, positive to the left.
    pub lateral_m: f64,
    /// Of `base_link` relative to the lane's direction.
    pub heading_rad: f64,
    /// Standard deviation of the lateral offset.
    pub lateral_std_m: f64,
    /// Standard deviation of the heading.
    pub heading_std_rad: f64,
    /// The last scan showed the left wall.
    pub left_seen: bool,
    /// The last scan showed the right wall.
    pub right_seen: bool,
    /// 1: both walls clean and long; 0: nothing seen.
    pub quality: f64,
    /// Scans in a row that showed a wall where it was expected.
    pub consistent_scans: u32,
    /// Good enough to drive by.
    pub usable: bool,
}

/// What one scan showed of the walls beside the lane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CorridorWalls {
    /// The lane's nearest wall to the left.
    pub left: Option<WallFit>,
    /// The lane's nearest wall to the right.
    pub right: Option<WallFit>,
    pieces: [Option<(LaneWall, WallFit)>; MAX_PIECES],
}

impl CorridorWalls {
    /// Every piece of wall that was seen, on both sides, with its line in the map.
    pub fn fits(&self) -> impl Iterator<Item = (&LaneWall, &WallFit)> {
        self.pieces.iter().flatten().map(|(wall, fit)| (wall, fit))
    }

    fn add(&mut self, wall: &LaneWall, fit: WallFit) {
        if let Some(place) = self.pieces.iter_mut().find(|place| place.is_none()) {
            *place = Some((*wall, fit));
        }
    }
}

/// How well a side of the lane was seen.
#[derive(Clone, Copy, Debug, Default)]
struct Side {
    /// Length of wall on the lines.
    covered_m: f64,
    /// The same, weighed by how clean it was.
    clean_m: f64,
}

/// The tracker of one lane's corridor.
#[derive(Clone, Debug)]
pub struct CorridorTracker {
    gains: Navigation,
    state: Vector2<f64>,
    covariance: Matrix2<f64>,
    walls: CorridorWalls,
    left: Side,
    right: Side,
    consistent_scans: u32,
    refusals: u32,
    started: bool,
}

impl CorridorTracker {
    /// A tracker that has not started.
    #[must_use]
    pub fn new(gains: Navigation) -> Self {
        Self {
            gains,
            state: Vector2::zeros(),
            covariance: Matrix2::identity(),
            walls: CorridorWalls::default(),
            left: Side::default(),
            right: Side::default(),
            consistent_scans: 0,
            refusals: 0,
            started: false,
        }
    }

    /// Starts from where the pose in `map` puts the robot in the lane.
    pub fn start(&mut self, lane: &LaneGeometry, pose: Pose2, std_m: f64, std_rad: f64) {
        self.state = Vector2::new(
            lane.line.lateral_m(pose.position()),
            wrap_angle(pose.theta_rad - lane.direction_rad),
        );
        self.covariance = Matrix2::new(std_m * std_m, 0.0, 0.0, std_rad * std_rad);
        self.forget_scan();
        self.consistent_scans = 0;
        self.refusals = 0;
        self.started = true;
    }

    /// Forgets the estimate.
    pub fn clear(&mut self) {
        self.started = false;
        self.consistent_scans = 0;
        self.forget_scan();
    }

    fn forget_scan(&mut self) {
        self.walls = CorridorWalls::default();
        (self.left, self.right) = (Side::default(), Side::default());
    }

    /// Moves the estimate: `moved` is the new `base_link` in the old one.
    pub fn predict(&mut self, moved: Pose2, dt_s: f64) {
        if !self.started {
            return;
        }
        let (sin, cos) = self.state.y.sin_cos();
        let along_m = cos * moved.x_m - sin * moved.y_m;
        self.state.x += sin * moved.x_m + cos * moved.y_m;
        self.state.y = wrap_angle(self.state.y + moved.theta_rad);
        let motion = Matrix2::new(1.0, along_m, 0.0, 1.0);
        let way_m = moved.position().norm_m();
        let turned_rad = moved.theta_rad.abs();
        let lateral =
            (self.gains.odometry_std_m_per_m * sin).powi(2) * way_m + IDLE_VARIANCE_M2_S * dt_s;
        // A turn counts like the way of a point half a metre out.
        let heading = self.gains.odometry_std_rad_per_m.powi(2) * (way_m + 0.5 * turned_rad)
            + IDLE_VARIANCE_M2_S * dt_s;
        self.covariance = motion * self.covariance * motion.transpose()
            + Matrix2::new(lateral, 0.0, 0.0, heading);
    }

    /// Looks for the walls in a scan. `along_m` is where along the lane the robot is.
    ///
    /// Returns what was seen and accepted.
    pub fn observe(
        &mut self,
        fitter: &mut LineFitter,
        points: ScanPoints<'_>,
        lane: &LaneGeometry,
        along_m: f64,
    ) -> CorridorWalls {
        self.forget_scan();
        if !self.started || !along_m.is_finite() {
            return self.walls;
        }
        let mut refused = false;
        for (pieces, main) in [
            (&lane.left_walls, &lane.left),
            (&lane.right_walls, &lane.right),
        ] {
            for piece in pieces {
                let (from_m, to_m) = (
                    lane.line.along_m(piece.line.a),
                    lane.line.along_m(piece.line.b),
                );
                if from_m > along_m + REACH_M || to_m < along_m - REACH_M {
                    continue;
                }
                let Some(fit) = self.wall(fitter, points, lane, piece, along_m, &mut refused)
                else {
                    continue;
                };
                self.walls.add(piece, fit);
                let is_main = main.is_some_and(|main| main.index == piece.index);
                let left = std::ptr::eq(pieces, &lane.left_walls);
                let (wall, side) = if left {
                    (&mut self.walls.left, &mut self.left)
                } else {
                    (&mut self.walls.right, &mut self.right)
                };
                side.covered_m += fit.covered_m;
                side.clean_m += fit.share * fit.covered_m;
                let longest = wall.is_none_or(|seen| seen.covered_m < fit.covered_m);
                if is_main && longest {
                    *wall = Some(fit);
                }
            }
        }
        if self.left.covered_m + self.right.covered_m > 0.0 {
            self.consistent_scans = self.consistent_scans.saturating_add(1);
            self.refusals = 0;
        } else {
            self.consistent_scans = 0;
            if refused {
                self.refusals += 1;
            }
        }
        self.walls
    }

    /// The last scans showed walls, but none where the estimate expects them: the search should restart.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.refusals >= REFUSALS_TO_RESTART
    }

    /// The estimate, when the tracker has started.
    #[must_use]
    pub fn estimate(&self) -> Option<CorridorEstimate> {
        if !self.started {
            return None;
        }
        let lateral_std_m = self.covariance[(0, 0)].max(0.0).sqrt();
        let heading_std_rad = self.covariance[(1, 1)].max(0.0).sqrt();
        let quality = [self.left, self.right]
            .iter()
            .map(|side| {
                let share = side.clean_m / side.covered_m.max(1e-9);
                0.5 * share * (side.covered_m / 2.0).min(1.0)
            })
            .sum();
        Some(CorridorEstimate {
            lateral_m: self.state.x,
            heading_rad: self.state.y,
            lateral_std_m,
            heading_std_rad,
            left_seen: self.left.covered_m > 0.0,
            right_seen: self.right.covered_m > 0.0,
            quality,
            consistent_scans: self.consistent_scans,
            usable: lateral_std_m < USABLE_STD_M && heading_std_rad < USABLE_STD_RAD,
        })
    }

    fn wall(
        &mut self,
        fitter: &mut LineFitter,
        points: ScanPoints<'_>,
        lane: &LaneGeometry,
        wall: &LaneWall,
        along_m: f64,
        refused: &mut bool,
    ) -> Option<WallFit> {
        let believed = lane.pose_at(along_m, self.state.x, self.state.y);
        let std_m = self.covariance[(0, 0)].max(0.0).sqrt();
        let std_rad = self.covariance[(1, 1)].max(0.0).sqrt();
        // Points lie up to 2 m along the wall, where a wrong heading shows most.
        let gate_m = (GATE_MIN_M + 3.0 * (std_m + 2.0 * std_rad)).min(GATE_MAX_M);
        let span_m = MIN_SPAN_M.min(MIN_SPAN_SHARE * wall.line.length_m());
        let fit = fitter.fit(points, &wall.line.seen_from(believed), gate_m, span_m)?;
        let lane_point = lane.line.a + lane.line.unit() * along_m;
        let seen = Vector2::new(
            fit.lateral_m - wall.line.lateral_m(lane_point),
            wrap_angle(fit.heading_rad + wall.direction_rad - lane.direction_rad),
        );
        let mut innovation = seen - self.state;
        innovation.y = wrap_angle(innovation.y);
        let Some(inverse) = (self.covariance + fit.covariance).try_inverse() else {
            *refused = true;
            return None;
        };
        if (innovation.transpose() * inverse * innovation).x > self.gains.gate_sigma.powi(2) {
            *refused = true;
            return None;
        }
        let gain = self.covariance * inverse;
        self.state += gain * innovation;
        self.state.y = wrap_angle(self.state.y);
        let rest = Matrix2::identity() - gain;
        self.covariance =
            rest * self.covariance * rest.transpose() + gain * fit.covariance * gain.transpose();
        Some(fit)
    }
}

#[cfg(test)]
mod tests;
