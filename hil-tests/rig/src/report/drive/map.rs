//! The upper panel: the map to scale, and what was driven on it.

use super::run::{DrawnRun, Sample};
use super::schedule::Schedule;
use super::speeds::{SPEED_COLOURS, speed_colour, speed_index};
use super::{footprints, legend, marks};
use crate::report::draw::canvas::{Canvas, Curve, Px2};
use crate::report::draw::floor;
use crate::report::draw::frame::Frame;
use crate::report::draw::labels::Labels;
use crate::report::draw::thin::apart;

/// Points of the path that are drawn, and how near they may be.
const MOST_POINTS: usize = 4500;
const SPACING_PX: f64 = 2.0;

/// Draws the panel with its legend; returns where it ends.
pub(super) fn draw(
    canvas: &mut Canvas,
    run: &DrawnRun<'_>,
    schedule: &Schedule<'_>,
    top_px: f64,
) -> f64 {
    let path = run.samples.iter().map(Sample::at_m);
    let frame = Frame::new(run.site, path, top_px);
    let mut labels = Labels::new(frame.field);
    canvas.open_clipped("floor", &[frame.field.rectangle()]);
    floor::draw_areas(canvas, run.site, &frame, &mut labels);
    floor::draw_zones(canvas, run.site, &frame, &mut labels);
    floor::draw_lanes(canvas, run.site, &frame);
    footprints::draw_faint(canvas, run, &frame);
    floor::draw_walls(canvas, run.site, &frame, &mut labels);
    floor::draw_obstacles(canvas, run.obstacles, &frame);
    draw_path(canvas, run, &frame, &mut labels);
    let ends = footprints::draw_ends(canvas, run, &frame);
    marks::draw_violations(canvas, run, &frame, &mut labels);
    marks::draw_changes(canvas, schedule, &ends, &frame, &mut labels);
    canvas.close("g");
    frame.draw_axes(canvas);
    legend::draw(canvas, run, schedule, &frame)
}

/// The path, one curve for each colour, and red over it where it was wrong.
fn draw_path(canvas: &mut Canvas, run: &DrawnRun<'_>, frame: &Frame, labels: &mut Labels) {
    let points: Vec<Px2> = run
        .samples
        .iter()
        .map(|sample| frame.at(sample.at_m()))
        .collect();
    let kept = apart(&points, SPACING_PX, MOST_POINTS);
    let top_m_s = run.top_speed_m_s();
    let mut curves: Vec<Curve> = (0..SPEED_COLOURS).map(|_| Curve::default()).collect();
    let mut wrong = Curve::default();
    let (mut colour_before, mut wrong_before) = (None, false);
    for pair in kept.windows(2) {
        let passed: &[Sample] = &run.samples[pair[0]..=pair[1]];
        let (from, to) = (points[pair[0]], points[pair[1]]);
        // Standing still at one place must not decide the colour of the way on from there.
        let fastest_m_s = passed
            .iter()
            .map(|sample| sample.speed_m_s.abs())
            .fold(0.0, f64::max);
        let colour = speed_index(fastest_m_s / top_m_s);
        if colour_before != Some(colour) {
            curves[colour].move_to(from);
        }
        curves[colour].line_to(to);
        let is_wrong = passed.iter().any(|sample| sample.is_wrong(&run.limits));
        if is_wrong {
            if !wrong_before {
                wrong.move_to(from);
            }
            wrong.line_to(to);
        }
        (colour_before, wrong_before) = (Some(colour), is_wrong);
    }
    for (index, curve) in curves.iter().enumerate() {
        let colour = speed_colour(index);
        canvas.curve(&format!("class=\"path\" stroke=\"{colour}\""), curve);
    }
    canvas.curve("class=\"wrong\"", &wrong);
    labels.avoid(
        apart(&points, 10.0, 2000)
            .into_iter()
            .map(|index| points[index]),
    );
}
