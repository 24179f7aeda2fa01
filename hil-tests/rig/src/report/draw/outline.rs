//! A robot's outline.

use description::geometry::Footprint;
use sim::world::Pose;

use super::canvas::Curve;
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
        curve.along({ polygon.iter() }.map(|corner| frame.at(pose.transform(*corner))));
        curve.close();
    }
    curve
}

/// The upright rectangle about what the body covers.
pub(in crate::report) fn covered(body: &Footprint, pose: &Pose, frame: &Frame) -> Field {
    Field::over(&corners(body).map(|corner| frame.at(pose.transform(corner))))
}

fn corners(body: &Footprint) -> [[f64; 2]; 4] {
    [
        [body.front_m, body.left_m],
        [-body.rear_m, body.left_m],
        [-body.rear_m, -body.right_m],
        [body.front_m, -body.right_m],
    ]
}
