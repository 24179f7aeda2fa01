//! Points of a scan and lines, in the coordinates of an expected wall: along it, across it.

use crate::direction::floor;
use crate::perception::RANGE_STD_SHARE;
use description::geometry::Point2;
use description::robot::Navigation;

/// Walls are not flat to better than this.
const FLATNESS_M: f64 = 0.015;
/// Coverage is counted in pieces of this length.
pub(super) const PIECE_M: f64 = 0.1;
pub(super) const PIECES: usize = 128;
/// A point within this many standard deviations lies on the line, even beyond the least distance.
pub(super) const INLIER_SIGMA: f64 = 2.5;
/// Standard deviation of a beam's direction.
const BEARING_STD_RAD: f64 = 0.002;

/// What a robot's file says of how points scatter, as each point asks for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise {
    /// Least variance of a range.
    range_variance_m2: f64,
    /// A point within this of the line lies on it, however little it scatters.
    inlier_m: f64,
    per_inlier_1_m: f64,
}

impl Noise {
    pub(super) fn of(gains: &Navigation) -> Self {
        Self {
            range_variance_m2: gains.range_std_m.powi(2),
            inlier_m: gains.wall_inlier_m,
            per_inlier_1_m: 1.0 / gains.wall_inlier_m,
        }
    }
}

/// A point in the coordinates of the expected wall.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WallPoint {
    pub(super) along_m: f64,
    pub(super) across_m: f64,
    /// One over the variance of the noise across the wall.
    pub(super) weight_1_m2: f64,
    /// This near to the line it lies on it.
    pub(super) reach_m: f64,
    /// One over that: it is asked for by every line that is tried.
    pub(super) per_reach_1_m: f64,
    /// One over how far from the line noise alone takes it.
    pub(super) per_noise_1_m: f64,
    /// The piece of wall that it lies on.
    pub(super) piece: usize,
    /// One over the number of points on the same piece, so that near, dense pieces weigh as much as far ones.
    pub(super) share: f64,
}

impl WallPoint {
    /// The point at `place`, seen from `eye`, both in the coordinates of the wall; its share is not known yet.
    pub(super) fn of(place: Point2, eye: Point2, noise: &Noise) -> Self {
        let sight = place - eye;
        let range_m2 = sight.dot(sight).max(1e-6);
        let range_variance_m2 = { noise.range_variance_m2 }.max(RANGE_STD_SHARE.powi(2) * range_m2);
        // The variance across the wall, times the square of the range: so that one division and one root serve the point.
        let variance_m4 =
            range_variance_m2 * sight.y_m.powi(2) + (BEARING_STD_RAD * range_m2).powi(2);
        let inverse = 1.0 / (variance_m4 * range_m2);
        let root = inverse.sqrt();
        let (std_m, per_std_1_m) = (variance_m4 * root, range_m2 * root);
        let per_sigmas_1_m = (1.0 / INLIER_SIGMA) * per_std_1_m;
        let per_reach_1_m = noise.per_inlier_1_m.min(per_sigmas_1_m);
        Self {
            along_m: place.x_m,
            across_m: place.y_m,
            weight_1_m2: per_std_1_m * per_std_1_m,
            reach_m: noise.inlier_m.max(INLIER_SIGMA * std_m),
            per_reach_1_m,
            per_noise_1_m: per_reach_1_m.max(per_sigmas_1_m.min(1.0 / FLATNESS_M)),
            piece: piece(place.x_m),
            share: 0.0,
        }
    }
}

/// Four points, side by side for the processor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Four {
    pub(super) along_m: [f64; 4],
    pub(super) across_m: [f64; 4],
    pub(super) per_reach_1_m: [f64; 4],
    pub(super) share: [f64; 4],
    /// The shares of all points behind these.
    pub(super) left: f64,
}

impl Four {
    pub(super) fn of(points: &[WallPoint; 4]) -> Self {
        Self {
            along_m: points.map(|point| point.along_m),
            across_m: points.map(|point| point.across_m),
            per_reach_1_m: points.map(|point| point.per_reach_1_m),
            share: points.map(|point| point.share),
            left: 0.0,
        }
    }
}

/// A line: across = offset + slope · (along − centre).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Line {
    pub(super) centre_m: f64,
    pub(super) offset_m: f64,
    pub(super) slope: f64,
}

impl Line {
    pub(super) fn residual_m(&self, along_m: f64, across_m: f64) -> f64 {
        across_m - self.offset_m - self.slope * (along_m - self.centre_m)
    }
}

/// The piece of wall that a point lies on; a very long wall counts round.
fn piece(along_m: f64) -> usize {
    floor(along_m * (1.0 / PIECE_M)).rem_euclid(PIECES as i64) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_scatters_as_the_noise_of_range_and_direction_across_the_wall() {
        let gains = Navigation::default();
        let eye = Point2::new(0.3, -1.2);
        for number in 0..200 {
            let along_m = f64::from(number) * 0.05;
            let place = Point2::new(along_m, 0.1 - 0.7 * f64::from(number % 3));
            let point = WallPoint::of(place, eye, &Noise::of(&gains));
            let range_m = place.distance_m(eye);
            let sine = (place.y_m - eye.y_m).abs() / range_m;
            let range_std_m = gains.range_std_m.max(RANGE_STD_SHARE * range_m);
            let std_m = Point2::new(range_std_m * sine, BEARING_STD_RAD * range_m).norm_m();
            let reach_m = gains.wall_inlier_m.max(INLIER_SIGMA * std_m);
            let noise_m = reach_m.min(FLATNESS_M.max(INLIER_SIGMA * std_m));
            for (found, expected) in [
                (point.weight_1_m2, 1.0 / (std_m * std_m)),
                (point.reach_m, reach_m),
                (point.per_reach_1_m, 1.0 / reach_m),
                (point.per_noise_1_m, 1.0 / noise_m),
            ] {
                assert!(
                    (found / expected - 1.0).abs() < 1e-12,
                    "{found} {expected} at {place:?}"
                );
            }
            assert_eq!(point.piece, number as usize / 2);
        }
    }
}
