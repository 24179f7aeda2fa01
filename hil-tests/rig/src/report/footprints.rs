//! The robot's footprint along its way.

use config::Footprint;
use sim::world::Pose;

use super::canvas::{Canvas, Curve, Px2};
use super::frame::Frame;
use super::labels::Field;
use super::run::{Run, Sample};

/// Time between two faint footprints, if that does not make too many.
const PERIOD_S: f64 = 5.0;
const MOST: f64 = 60.0;
/// A robot that has moved less than this is not drawn again.
const STEP_M: f64 = 0.15;

/// Draws the robot faintly every few seconds.
pub(super) fn draw_faint(canvas: &mut Canvas, run: &Run<'_>, frame: &Frame) {
    let (first_s, last_s) = run.time_range_s();
    let period_s = ((last_s - first_s) / MOST / PERIOD_S).ceil().max(1.0) * PERIOD_S;
    let mut due_s = first_s + period_s;
    let mut last = run.samples.first();
    for sample in &run.samples {
        let moved = last.is_none_or(|last| distance_m(last, sample) > STEP_M);
        if sample.at_s < due_s || !moved {
            continue;
        }
        due_s = sample.at_s + period_s;
        last = Some(sample);
        canvas.curve(
            "class=\"ghost\"",
            &outline(&run.robot.footprint, &sample.pose, frame),
        );
    }
}

/// Draws the robot where it started and where it ended; returns what that covers, for each.
pub(super) fn draw_ends(
    canvas: &mut Canvas,
    run: &Run<'_>,
    frame: &Frame,
) -> Vec<(&'static str, Field)> {
    let (Some(start), Some(end)) = (run.samples.first(), run.samples.last()) else {
        return Vec::new();
    };
    let mut ends = vec![("start", "start", start), ("end", "end", end)];
    if distance_m(start, end) < STEP_M {
        ends = vec![("start", "start and end", end)];
    }
    ends.iter()
        .map(|(class, name, sample)| {
            canvas.curve(
                &format!("class=\"{class}\""),
                &outline(&run.robot.footprint, &sample.pose, frame),
            );
            (*name, covered(&run.robot.footprint, &sample.pose, frame))
        })
        .collect()
}

/// The body with a triangle that shows its front.
pub(super) fn outline(body: &Footprint, pose: &Pose, frame: &Frame) -> Curve {
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
pub(super) fn covered(body: &Footprint, pose: &Pose, frame: &Frame) -> Field {
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

fn distance_m(a: &Sample, b: &Sample) -> f64 {
    (a.pose.x_m - b.pose.x_m).hypot(a.pose.y_m - b.pose.y_m)
}
