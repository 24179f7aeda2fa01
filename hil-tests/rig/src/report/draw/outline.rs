//! A robot's outline.

use description::geometry::Footprint;
use sim::world::Pose;

use super::canvas::{Curve, Px2};
use super::frame::Frame;
use super::labels::Field;

/// The body with a triangle that shows its front.
pub(in crate::report) fn outline(body: &Footprint, pose: &Pose, frame: &Frame) -> Curve {
    let nose_m = 0.3 * body.left_m.min(body.right_m);
    let mut curve = Curve::default();
    for polygon in [
        &corners(body)[..],
        &[
            [body.front_m - nose_m, nose_m],
            [body.front_m, 0.0],
            [body.front_m - nose_m, -nose_m],
        ],
    ] {
        for (index, corner) in polygon.iter().enumerate() {
            let at = frame.at(pose.transform(*corner));
            if index == 0 {
                curve.move_to(at);
            } else {
                curve.line_to(at);
            }
        }
        curve.close();
    }
    curve
}

/// The upright rectangle about what the body covers.
pub(in crate::report) fn covered(body: &Footprint, pose: &Pose, frame: &Frame) -> Field {
    let at: [Px2; 4] = corners(body).map(|corner| frame.at(pose.transform(corner)));
    let least = |axis: usize| at.iter().map(|at| at[axis]).fold(f64::INFINITY, f64::min);
    let most = |axis: usize| {
        at.iter()
            .map(|at| at[axis])
            .fold(f64::NEG_INFINITY, f64::max)
    };
    Field {
        min: [least(0), least(1)],
        max: [most(0), most(1)],
    }
}

fn corners(body: &Footprint) -> [[f64; 2]; 4] {
    [
        [body.front_m, body.left_m],
        [-body.rear_m, body.left_m],
        [-body.rear_m, -body.right_m],
        [body.front_m, -body.right_m],
    ]
}
