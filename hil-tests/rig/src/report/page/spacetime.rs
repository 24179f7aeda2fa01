//! Who had which area when: areas as rows, time to the right, coordinations across; then each robot's speed and state.
//!
//! Long runs are broken into several panels, one under the other.

use crate::record::{RobotRecord, Span};
use crate::summary::CoordinationSummary;

use super::lanes::{AreaRow, area_rows, stacked};
use super::rows::{
    LEAST_PX, LEFT_PX, RIGHT_PX, Window, draw_row, draw_row_ground, fits, rect, row_height_px,
};
use super::style::WIDTH_PX;
use super::view::{View, cast};
use crate::report::draw::canvas::{Canvas, Curve, Px, shortened};
use crate::report::draw::scale;
use crate::report::draw::thin::{Column, columns};

/// A panel shows no more than this, unless that makes too many.
const PANEL_S: f64 = 240.0;
const MOST_PANELS: f64 = 6.0;
const ROW_GAP_PX: f64 = 5.0;
/// A coordination's bar, and under it the marks of its firings.
const BAND_PX: f64 = 15.0;
const FIRINGS_PX: f64 = 6.0;
const SPEED_PX: f64 = 42.0;
const STATE_PX: f64 = 16.0;
/// A longer time without a value leaves a gap in a curve.
const GAP_S: f64 = 0.5;
/// Moments nearer to each other than this share a line.
const MOMENT_PX: f64 = 1.5;

/// Draws the diagram.
pub(super) fn draw(view: &View<'_>) -> String {
    let panels = (view.end_s / PANEL_S).ceil().clamp(1.0, MOST_PANELS);
    let diagram = Diagram {
        view,
        areas: area_rows(view),
        bands: bands(view),
        top_m_s: top_speed_m_s(view),
    };
    let mut canvas = Canvas::default();
    let mut y_px = 6.0;
    for panel in 0..panels as usize {
        let share = |index: usize| view.end_s * index as f64 / panels;
        let window = Window {
            from_s: share(panel),
            to_s: share(panel + 1),
        };
        y_px = diagram.draw(&mut canvas, window, y_px, panel + 1 == panels as usize);
    }
    let label = "areas and their owners over time";
    canvas.finish_inline("spacetime", [WIDTH_PX, y_px], label)
}

fn top_speed_m_s(view: &View<'_>) -> f64 {
    let points = view.record.robots.iter().flat_map(|robot| &robot.path);
    points
        .map(|point| point.speed_m_s.abs())
        .filter(|speed_m_s| speed_m_s.is_finite())
        .fold(0.1, f64::max)
}

/// Coordinations in lanes, so that none covers another.
fn bands<'a>(view: &View<'a>) -> Vec<(usize, &'a CoordinationSummary, (f64, f64))> {
    let runs: Vec<_> = view
        .record
        .summary
        .coordinations
        .iter()
        .filter_map(|run| Some((run, view.shown(run.from_s, run.to_s())?)))
        .collect();
    let lanes = stacked(runs.iter().map(|run| run.1));
    lanes
        .into_iter()
        .zip(runs)
        .map(|(lane, (run, span))| (lane, run, span))
        .collect()
}

struct Diagram<'a> {
    view: &'a View<'a>,
    areas: Vec<AreaRow<'a>>,
    /// With its lane and what is shown of it.
    bands: Vec<(usize, &'a CoordinationSummary, (f64, f64))>,
    top_m_s: f64,
}

impl Diagram<'_> {
    /// Draws one panel; returns where it ends.
    fn draw(&self, canvas: &mut Canvas, window: Window, top_px: f64, last: bool) -> f64 {
        let lanes = self.bands.iter().map(|band| band.0 + 1).max().unwrap_or(0);
        let bands_px = if lanes == 0 {
            0.0
        } else {
            lanes as f64 * (BAND_PX + FIRINGS_PX) + 4.0
        };
        let areas_top_px = top_px + bands_px + 12.0;
        let heights_px: Vec<f64> = self.areas.iter().map(row_height_px).collect();
        let areas_px: f64 = heights_px.iter().map(|height| height + ROW_GAP_PX).sum();
        let robots_top_px = areas_top_px + areas_px + 14.0;
        let robot_px = SPEED_PX + STATE_PX + 14.0;
        let bottom_px = robots_top_px + robot_px * self.view.record.robots.len() as f64;
        self.draw_grounds(canvas, window, [areas_top_px, bottom_px]);
        let mut y_px = areas_top_px;
        for (row, height_px) in self.areas.iter().zip(&heights_px) {
            draw_row_ground(canvas, row, y_px, *height_px);
            y_px += height_px + ROW_GAP_PX;
        }
        self.draw_grid(canvas, window, [areas_top_px, bottom_px]);
        self.draw_bands(canvas, window, [top_px, bottom_px], lanes);
        let mut y_px = areas_top_px;
        for (row, height_px) in self.areas.iter().zip(&heights_px) {
            draw_row(canvas, window, row, y_px);
            y_px += height_px + ROW_GAP_PX;
        }
        for (index, robot) in self.view.record.robots.iter().enumerate() {
            self.draw_robot(
                canvas,
                window,
                robot,
                robots_top_px + robot_px * index as f64,
            );
        }
        self.draw_moments(canvas, window, [areas_top_px, bottom_px]);
        if last {
            let middle = [(LEFT_PX + RIGHT_PX) / 2.0, bottom_px + 38.0];
            canvas.text("axis m", middle, "time since the first robot's start, s");
        }
        bottom_px + if last { 50.0 } else { 44.0 }
    }

    /// Where no mediator ran, although one did before.
    fn draw_grounds(&self, canvas: &mut Canvas, window: Window, [top, bottom]: [f64; 2]) {
        let spans: &[Span] = &self.view.record.mediator;
        for pair in spans.windows(2) {
            if let Some((x, width)) = window.cut((pair[0].to_s, pair[1].from_s)) {
                rect(
                    canvas,
                    "off",
                    [x, top, width, bottom - top],
                    "no mediator ran",
                );
            }
        }
    }

    fn draw_grid(&self, canvas: &mut Canvas, window: Window, [top, bottom]: [f64; 2]) {
        let step_s = scale::step(window.to_s - window.from_s, 20.0);
        for at_s in scale::ticks(window.from_s, window.to_s, step_s) {
            let x = window.x(at_s);
            canvas.line("grid", [x, top - 4.0], [x, bottom]);
            canvas.line("mark", [x, bottom], [x, bottom + 4.0]);
            canvas.text("tick m", [x, bottom + 18.0], &scale::label(at_s, step_s));
        }
    }

    fn draw_bands(
        &self,
        canvas: &mut Canvas,
        window: Window,
        [bars_px, bottom]: [f64; 2],
        lanes: usize,
    ) {
        if lanes > 0 {
            canvas.text("small e", [LEFT_PX - 8.0, bars_px + 12.0], "coordination");
        }
        for (lane, run, span) in &self.bands {
            let Some((x, width)) = window.cut(*span) else {
                continue;
            };
            let y = bars_px + *lane as f64 * (BAND_PX + FIRINGS_PX);
            rect(canvas, "band", [x, y, width, bottom - y], "");
            for (at_s, edge) in [(span.0, x), (span.1, x + width)] {
                if window.holds(at_s) {
                    canvas.line("bandedge", [edge, y], [edge, bottom]);
                }
            }
            let hint = format!("coordination {} ({}), {}", run.number, run.id, cast(run));
            rect(canvas, "bandbar", [x, y, width.max(1.0), BAND_PX], &hint);
            let mut marks = Curve::default();
            let times = { run.firings.iter() }.map(|firing| firing.at_s);
            for at_s in times.filter(|at_s| window.holds(*at_s)) {
                marks.move_to([window.x(at_s), y + BAND_PX]);
                marks.vertical_to(y + BAND_PX + FIRINGS_PX - 1.0);
            }
            canvas.curve("class=\"fire\"", &marks);
            let words = [
                format!("{} {}: {}", run.id, run.number, cast(run)),
                format!("{} {}", run.id, run.number),
                run.number.to_string(),
            ];
            if let Some(words) = words.iter().find(|words| fits(words, width)) {
                canvas.text("onbar m", [x + width / 2.0, y + 11.2], words);
            }
        }
    }

    fn draw_robot(&self, canvas: &mut Canvas, window: Window, robot: &RobotRecord, top_px: f64) {
        canvas.open(
            "g",
            format_args!("class=\"{}\"", self.view.class(&robot.id)),
        );
        let id = shortened(&robot.id, 12);
        canvas.text(
            "name e",
            [LEFT_PX - 34.0, top_px + SPEED_PX / 2.0 + 4.0],
            &id,
        );
        let bottom_px = top_px + SPEED_PX;
        canvas.text(
            "small e",
            [LEFT_PX - 5.0, top_px + 9.0],
            &format!("{:.1}", self.top_m_s),
        );
        canvas.text("small e", [LEFT_PX - 5.0, bottom_px], "0");
        canvas.text(
            "small e",
            [LEFT_PX - 5.0, top_px + SPEED_PX / 2.0 + 4.0],
            "m/s",
        );
        canvas.text(
            "small e",
            [LEFT_PX - 5.0, bottom_px + STATE_PX - 3.0],
            "state",
        );
        canvas.line("rule", [LEFT_PX, bottom_px], [RIGHT_PX, bottom_px]);
        let count = (RIGHT_PX - LEFT_PX) as usize;
        let points = robot.path.iter().map(|point| {
            let share = (point.at_s - window.from_s) / (window.to_s - window.from_s);
            (share, point.speed_m_s.abs())
        });
        let columns = columns(points, count);
        let gap = (count as f64 * GAP_S / (window.to_s - window.from_s))
            .ceil()
            .max(2.0) as usize;
        let y = |speed_m_s: f64| bottom_px - SPEED_PX * (speed_m_s / self.top_m_s).clamp(0.0, 1.0);
        let [line, under] = speed_curves(&columns, gap, y, bottom_px);
        canvas.curve("class=\"under\"", &under);
        canvas.curve("class=\"speed\"", &line);
        self.draw_states(canvas, window, robot, bottom_px + 2.0);
        canvas.close("g");
    }

    fn draw_states(&self, canvas: &mut Canvas, window: Window, robot: &RobotRecord, top_px: f64) {
        let mut drawn_px = f64::NEG_INFINITY;
        for (index, change) in robot.states.iter().enumerate() {
            let until_s = robot.states.get(index + 1).map(|next| next.at_s);
            let span = self.view.shown(change.at_s, until_s);
            let Some((x, width)) = span.and_then(|span| window.cut(span)) else {
                continue;
            };
            if x + width < drawn_px + LEAST_PX {
                continue;
            }
            drawn_px = x + width;
            let hint = format!(
                "state {}, area {}, skill {}",
                change.state, change.area, change.skill
            );
            rect(canvas, "state", [x, top_px, width, STATE_PX - 2.0], &hint);
            if fits(&change.state, width) {
                canvas.text("small m", [x + width / 2.0, top_px + 11.0], &change.state);
            }
        }
    }

    /// Violations and what was done to the run.
    fn draw_moments(&self, canvas: &mut Canvas, window: Window, [top, bottom]: [f64; 2]) {
        let record = self.view.record;
        let wrong = record.summary.violations.iter().map(|violation| {
            (
                violation.at_s,
                "when",
                format!("{}: {}", violation.kind, violation.detail),
            )
        });
        let done = record
            .incidents
            .iter()
            .map(|incident| (incident.at_s, "mark", incident.what.clone()));
        let mut moments: Vec<(f64, &str, String)> = done
            .chain(wrong)
            .filter(|moment| window.holds(moment.0))
            .collect();
        moments.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut last_px = f64::NEG_INFINITY;
        for (at_s, class, what) in moments {
            let x = window.x(at_s);
            if x - last_px < MOMENT_PX {
                continue;
            }
            last_px = x;
            let (from, to, x) = (Px(top - 8.0), Px(bottom), Px(x));
            canvas.element_with_hint(
                "line",
                format_args!("class=\"{class}\" x1=\"{x}\" x2=\"{x}\" y1=\"{from}\" y2=\"{to}\""),
                &shortened(&what, 100),
            );
        }
    }
}

/// The curve, and the surface under it; peaks survive.
fn speed_curves(
    columns: &[Column],
    gap: usize,
    y: impl Fn(f64) -> f64,
    zero_px: f64,
) -> [Curve; 2] {
    let (mut line, mut under) = (Curve::default(), Curve::default());
    let mut before: Option<&Column> = None;
    for column in columns {
        let x = LEFT_PX + column.index as f64 + 0.5;
        let (first, second) = if column.rises {
            (y(column.low), y(column.high))
        } else {
            (y(column.high), y(column.low))
        };
        match before.filter(|before| before.index + gap >= column.index) {
            Some(_) => line.line_to([x, first]),
            None => {
                if let Some(before) = before {
                    under.line_to([LEFT_PX + before.index as f64 + 0.5, zero_px]);
                    under.close();
                }
                under.move_to([x, zero_px]);
                line.move_to([x, first]);
            }
        }
        under.line_to([x, first]);
        if (first - second).abs() > 0.1 {
            line.vertical_to(second);
            under.vertical_to(second);
        }
        before = Some(column);
    }
    if let Some(before) = before {
        under.line_to([LEFT_PX + before.index as f64 + 0.5, zero_px]);
        under.close();
    }
    [line, under]
}
