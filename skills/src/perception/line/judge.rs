//! Judges a fitted line, and states it as the robot stands to it.

use super::points::{Line, PIECE_M, PIECES, WallPoint};
use crate::perception::wall_fit::WallFit;
use description::geometry::{Point2, Segment, wrap_angle};
use nalgebra::Matrix2;

/// Of the length where the gate holds points, this share must lie on the line.
const MIN_SHARE: f64 = 0.35;
/// With this many points the variance is doubled against what their noise says; with more it is closer to it.
const FEW_POINTS: f64 = 30.0;
/// Least standard deviations, however many points: mounting, calibration, a wall that is not straight.
const FLOOR_ACROSS_M: f64 = 0.004;
const FLOOR_ANGLE_RAD: f64 = 0.002;

/// What lies on one piece of a wall.
#[derive(Clone, Copy, Debug, Default)]
struct Piece {
    /// The gate holds points of it.
    any: bool,
    /// Of the points on the line.
    weight: f64,
    residual: f64,
    along: f64,
}

/// Judges the line and states it as seen from `base_link`.
pub(super) fn describe(
    points: &[WallPoint],
    line: &Line,
    expected: &Segment,
    min_points: usize,
    min_span_m: f64,
) -> Option<WallFit> {
    let (mut inliers, mut squares, mut misfit) = (0usize, 0.0, 0.0);
    let (mut weights, mut spread) = (0.0, 0.0);
    let mut pieces = [Piece::default(); PIECES];
    for point in points {
        let piece = &mut pieces[point.piece];
        piece.any = true;
        let residual_m = line.residual_m(point.along_m, point.across_m);
        if residual_m.abs() < point.reach_m {
            inliers += 1;
            let weight = point.weight_1_m2;
            squares += residual_m * residual_m;
            misfit += weight * residual_m * residual_m;
            weights += weight;
            spread += weight * (point.along_m - line.centre_m).powi(2);
            piece.weight += weight;
            piece.residual += weight * residual_m;
            piece.along += weight * (point.along_m - line.centre_m);
        }
    }
    let all = pieces.iter().filter(|piece| piece.any).count().max(1) as f64;
    let covered = pieces.iter().filter(|piece| piece.weight > 0.0).count() as f64;
    let (share, covered_m) = (covered / all, PIECE_M * covered);
    if inliers < min_points || share < MIN_SHARE || covered_m < min_span_m {
        return None;
    }
    // Points that scatter more than their noise explains make the line less certain,
    // and few points leave open which of them belong to it.
    let inflation = (misfit / inliers as f64).max(1.0) * (1.0 + FEW_POINTS / inliers as f64);
    let (uneven_m2, uneven_rad2) = unevenness(&pieces);
    let across_variance = (inflation / weights).max(uneven_m2) + FLOOR_ACROSS_M.powi(2);
    let angle_variance = (inflation / spread).max(uneven_rad2) + FLOOR_ANGLE_RAD.powi(2);

    let unit_expected = expected.unit();
    let turned_rad = line.slope.atan();
    let direction_rad = expected.direction_rad() + turned_rad;
    let (sin, cos) = direction_rad.sin_cos();
    let unit = Point2::new(cos, sin);
    let normal = Point2::new(-unit_expected.y_m, unit_expected.x_m);
    let centre = expected.a + unit_expected * line.centre_m + normal * line.offset_m;
    // Lever from the points' centre to `base_link`: a wall seen far ahead tells its offset here less well.
    let lever_m = -unit.dot(centre);
    Some(WallFit {
        lateral_m: -unit.cross(centre),
        heading_rad: wrap_angle(-direction_rad),
        covariance: Matrix2::new(
            across_variance + lever_m * lever_m * angle_variance,
            lever_m * angle_variance,
            lever_m * angle_variance,
            angle_variance,
        ),
        inliers: inliers as u32,
        share,
        covered_m,
        rms_m: (squares / inliers as f64).sqrt(),
    })
}

/// Variances across and of the angle, as the pieces scatter about the line: a box close to the wall shifts many points
/// together, which no number of points averages away.
fn unevenness(pieces: &[Piece; PIECES]) -> (f64, f64) {
    let (mut count, mut squares, mut spread) = (0.0, 0.0, 0.0);
    for piece in pieces.iter().filter(|piece| piece.weight > 0.0) {
        count += 1.0;
        squares += (piece.residual / piece.weight).powi(2);
        spread += (piece.along / piece.weight).powi(2);
    }
    let scatter = squares / f64::max(count - 2.0, 1.0);
    (
        scatter / f64::max(count, 1.0),
        scatter / f64::max(spread, 1e-6),
    )
}
