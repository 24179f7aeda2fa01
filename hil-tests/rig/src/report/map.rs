//! The upper panel: the map to scale, and what was driven on it.

use super::canvas::{Canvas, Curve, Px2, shortened};
use super::frame::Frame;
use super::labels::{Field, Labels, text_width_px};
use super::run::{Run, Sample};
use super::schedule::Schedule;
use super::thin::apart;
use super::{footprints, legend, marks, scale};

/// Points of the path that are drawn, and how near they may be.
const MOST_POINTS: usize = 4500;
const SPACING_PX: f64 = 2.0;
/// Different colours of the path.
pub(super) const SPEED_COLOURS: usize = 12;
/// Draws the panel with its legend; returns where it ends.
pub(super) fn draw(
    canvas: &mut Canvas,
    run: &Run<'_>,
    schedule: &Schedule<'_>,
    top_px: f64,
) -> f64 {
    let frame = Frame::new(run, top_px);
    let mut labels = Labels::new(frame.field);
    let [left, top, width, height] = frame.field.rectangle();
    canvas.open("clipPath", format_args!("id=\"floor\""));
    canvas.element(
        "rect",
        format_args!("x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\""),
    );
    canvas.close("clipPath");
    canvas.open("g", format_args!("clip-path=\"url(#floor)\""));
    draw_areas(canvas, run, &frame, &mut labels);
    draw_zones(canvas, run, &frame, &mut labels);
    draw_lanes(canvas, run, &frame);
    footprints::draw_faint(canvas, run, &frame);
    draw_walls(canvas, run, &frame, &mut labels);
    draw_path(canvas, run, &frame, &mut labels);
    let ends = footprints::draw_ends(canvas, run, &frame);
    marks::draw_violations(canvas, run, &frame, &mut labels);
    marks::draw_changes(canvas, schedule, &ends, &frame, &mut labels);
    canvas.close("g");
    frame.draw_axes(canvas);
    legend::draw(canvas, run, schedule, &frame)
}

fn draw_areas(canvas: &mut Canvas, run: &Run<'_>, frame: &Frame, labels: &mut Labels) {
    for (index, area) in run.site.areas.iter().enumerate() {
        let field = frame.region(&area.region);
        let [x, y, width, height] = field.rectangle();
        let colour = scale::area_colour(index);
        let control = &area.control;
        let about = format!(
            "{}, {} m/s",
            control.manoeuvre.name(),
            control.speed_limit_m_s
        );
        canvas.element_with_hint(
            "rect",
            format_args!(
                "class=\"area\" fill=\"{colour}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\""
            ),
            &format!("area {}: {about}", area.id),
        );
        canvas.text("id", [x + 8.0, y + 23.0], &area.id);
        let id_px = text_width_px(&area.id, 20.0) + 18.0;
        let about_px = text_width_px(&about, 12.0);
        let beside = id_px + about_px + 6.0 < width;
        let mut covered = Field {
            min: [x, y],
            max: [x + id_px, y + 28.0],
        };
        if beside {
            canvas.text("note", [x + id_px, y + 22.0], &about);
            covered.max[0] += about_px;
        }
        labels.take(covered);
    }
}

fn draw_zones(canvas: &mut Canvas, run: &Run<'_>, frame: &Frame, labels: &mut Labels) {
    // A little inside, since zones often share their borders with areas.
    const INSET_PX: f64 = 4.0;
    for zone in &run.site.perception {
        let field = frame.region(&zone.region);
        let [x, y, width, height] = field.rectangle();
        canvas.element_with_hint(
            "rect",
            format_args!(
                "class=\"zone\" x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"",
                x + INSET_PX,
                y + INSET_PX,
                (width - 2.0 * INSET_PX).max(0.0),
                (height - 2.0 * INSET_PX).max(0.0)
            ),
            &format!("perception zone {}, kind {}", zone.id, zone.kind),
        );
        let name = shortened(&format!("zone {}", zone.kind), 24);
        let name_px = text_width_px(&name, 12.0);
        let end = [field.max[0] - INSET_PX - 6.0, field.max[1] - INSET_PX - 7.0];
        if name_px + 4.0 * INSET_PX < width {
            canvas.text("note e", end, &name);
            labels.take(Field {
                min: [end[0] - name_px, end[1] - 13.0],
                max: [end[0] + 4.0, end[1] + 5.0],
            });
        }
    }
}

fn draw_lanes(canvas: &mut Canvas, run: &Run<'_>, frame: &Frame) {
    const ARROW_PX: f64 = 7.0;
    const ARROWS_EVERY_M: f64 = 1.0;
    let mut arrows = Curve::default();
    for lane in &run.site.lanes {
        let (from, to) = (frame.at(lane.from_m), frame.at(lane.to_m));
        canvas.line("lane", from, to);
        let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
        let length_px = dx.hypot(dy);
        if length_px < 1.0 {
            continue;
        }
        let (along, across) = (
            [dx / length_px, dy / length_px],
            [-dy / length_px, dx / length_px],
        );
        let count = (length_px / frame.px_per_m / ARROWS_EVERY_M)
            .floor()
            .clamp(1.0, 200.0) as u32;
        for index in 0..count {
            let share = (f64::from(index) + 0.5) / f64::from(count);
            let tip = [from[0] + dx * share, from[1] + dy * share];
            let wing = |side: f64| {
                [0, 1]
                    .map(|axis| tip[axis] - ARROW_PX * along[axis] + side * ARROW_PX * across[axis])
            };
            arrows.move_to(wing(1.0));
            arrows.line_to(tip);
            arrows.line_to(wing(-1.0));
        }
    }
    canvas.curve("class=\"arrow\"", &arrows);
}

fn draw_walls(canvas: &mut Canvas, run: &Run<'_>, frame: &Frame, labels: &mut Labels) {
    for wall in &run.site.walls {
        let (from, to) = (frame.at(wall.from_m), frame.at(wall.to_m));
        canvas.line("wall", from, to);
        labels.avoid_line(from, to);
    }
}

/// The path, one curve for each colour, and red over it where it was wrong.
fn draw_path(canvas: &mut Canvas, run: &Run<'_>, frame: &Frame, labels: &mut Labels) {
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
        let is_wrong = passed.iter().any(Sample::is_wrong);
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

fn speed_index(share: f64) -> usize {
    ((share * SPEED_COLOURS as f64) as usize).min(SPEED_COLOURS - 1)
}

/// Colour of one of the path's curves.
pub(super) fn speed_colour(index: usize) -> String {
    scale::speed_colour((index as f64 + 0.5) / SPEED_COLOURS as f64)
}
