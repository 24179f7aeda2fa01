//! The steering laws.

use super::steer::{PathError, Steer};
use description::robot::Navigation;

/// Steepest angle at which a path is approached from the side, rad.
const APPROACH_RAD: f64 = 0.7;
/// The robot keeps at least this share of the speed limit, however large the error.
const SLOWEST_SHARE: f64 = 0.3;

/// The curvature that leads back to a path of the given curvature, driving forward.
///
/// Near the path it is linear in both errors; far away the lateral error is limited to a bounded approach angle.
#[must_use]
pub fn path_curvature(error: PathError, path_curvature_1_m: f64, gains: &Navigation) -> f64 {
    let off_rad = error.heading_rad + wanted_rad(error, gains);
    let curvature = path_curvature_1_m - gains.heading_gain_1_m * off_rad;
    curvature.clamp(-gains.max_curvature_1_m, gains.max_curvature_1_m)
}

/// The same driving backward along the path's direction reversed; `error.heading_rad` is still that of the front.
///
/// With the way s driven backward, y' = −sin θ and θ' = −κ (forward: y' = sin θ, θ' = κ). For the same decay,
/// y'' + k_θ·y' + k_y·y = 0, forward needs κ = −k_θ·θ − k_y·y and backward κ = +k_θ·θ − k_y·y: the sign of the heading
/// gain changes, that of the lateral gain does not. With the gains of forward motion the heading error would grow.
#[must_use]
pub fn reverse_curvature(error: PathError, gains: &Navigation) -> f64 {
    let off_rad = error.heading_rad - wanted_rad(error, gains);
    (gains.heading_gain_1_m * off_rad).clamp(-gains.max_curvature_1_m, gains.max_curvature_1_m)
}

/// The angle to the path at which the lateral error is driven down.
fn wanted_rad(error: PathError, gains: &Navigation) -> f64 {
    let approach_rad = (error.lateral_m.abs() / gains.lookahead_m)
        .atan()
        .min(APPROACH_RAD);
    let wanted_rad = gains.lateral_gain_1_m2 / gains.heading_gain_1_m * error.lateral_m;
    // Not `clamp`, which panics for limits that are not numbers.
    wanted_rad.max(-approach_rad).min(approach_rad)
}

/// Share of the speed limit that is sensible this far off the path.
#[must_use]
pub fn speed_share(error: PathError) -> f64 {
    let turned = error.heading_rad.cos().max(0.0);
    let aside = 1.0 / (1.0 + (2.0 * error.lateral_m).powi(2));
    (turned * aside).max(SLOWEST_SHARE)
}

/// Keeps on a straight path: `error` relative to it.
#[must_use]
pub fn keep_lane(error: PathError, gains: &Navigation) -> Steer {
    Steer {
        error,
        curvature_1_m: path_curvature(error, 0.0, gains),
        path_curvature_1_m: 0.0,
        direction: 1.0,
        speed_share: speed_share(error),
    }
}
