//! The robot's footprint along its way.

use super::run::{DrawnRun, Sample};
use crate::report::draw::canvas::Canvas;
use crate::report::draw::frame::Frame;
use crate::report::draw::labels::Field;
use crate::report::draw::outline::{covered, outline};

/// Time between two faint footprints, if that does not make too many.
const PERIOD_S: f64 = 5.0;
const MOST: f64 = 60.0;
/// A robot that has moved less than this is not drawn again.
const STEP_M: f64 = 0.15;

/// Draws the robot faintly every few seconds.
pub(super) fn draw_faint(canvas: &mut Canvas, run: &DrawnRun<'_>, frame: &Frame) {
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
    run: &DrawnRun<'_>,
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

fn distance_m(a: &Sample, b: &Sample) -> f64 {
    (a.pose.x_m - b.pose.x_m).hypot(a.pose.y_m - b.pose.y_m)
}
