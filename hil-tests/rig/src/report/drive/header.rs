//! The figures over the drawing, and violations and machine under it.

use super::run::DrawnRun;
use crate::report::draw::canvas::{Canvas, shortened};
use crate::report::draw::labels::text_width_px;
use crate::report::draw::sheet::{MARGIN_PX, PLOT_RIGHT_PX, WIDTH_PX};

/// Violations that are written out.
const MOST_VIOLATIONS: usize = 12;
const LINE_PX: f64 = 21.0;

/// The page's title, also shown by browsers.
pub(super) fn title(run: &DrawnRun<'_>) -> String {
    format!(
        "{} in {}: {}",
        run.summary.scenario, run.site.name, run.robot.id
    )
}

/// Draws the header; returns where it ends.
pub(super) fn draw(canvas: &mut Canvas, run: &DrawnRun<'_>) -> f64 {
    canvas.text("h", [MARGIN_PX, 56.0], &shortened(&title(run), 56));
    let model = &run.robot.model;
    canvas.text("sub", [MARGIN_PX, 82.0], &shortened(model, 100));
    draw_outcome(canvas, run);
    draw_figures(canvas, run);
    176.0
}

fn draw_outcome(canvas: &mut Canvas, run: &DrawnRun<'_>) {
    let text = shortened(&run.summary.outcome, 56) + &run.summary.with_violations();
    let width_px = text_width_px(&text, 16.0) + 32.0;
    let left_px = PLOT_RIGHT_PX - width_px;
    let class = if run.summary.passed() { "good" } else { "bad" };
    canvas.rect(
        &format!("class=\"{class}\" rx=\"18\""),
        [left_px, 30.0, width_px, 36.0],
    );
    canvas.text("badge m", [left_px + width_px / 2.0, 54.0], &text);
}

fn draw_figures(canvas: &mut Canvas, run: &DrawnRun<'_>) {
    let figures = run.figures();
    let metres = |value: Option<f64>, digits: usize| match value {
        Some(value) if value.is_finite() => format!("{value:.digits$} m"),
        _ => "–".to_owned(),
    };
    let clearance_m = figures.map(|robot| robot.min_clearance_m);
    let lateral_m = figures.map(|robot| robot.max_lateral_error_m);
    let count =
        |value: Option<u64>| value.map_or_else(|| "–".to_owned(), |value| value.to_string());
    let fields = [
        (
            "duration",
            format!("{:.1} s", run.summary.duration_s),
            false,
        ),
        ("laps", count(figures.map(|robot| robot.laps.into())), false),
        (
            "distance",
            metres(figures.map(|robot| robot.distance_m), 2),
            false,
        ),
        (
            "fastest",
            figures.map_or_else(
                || "–".to_owned(),
                |robot| format!("{:.2} m/s", robot.max_speed_m_s),
            ),
            false,
        ),
        (
            "collisions",
            count(figures.map(|robot| robot.collisions)),
            figures.is_some_and(|robot| robot.collisions > 0),
        ),
        (
            "min clearance",
            metres(clearance_m, 3),
            clearance_m.is_some_and(|value| value < run.limits.clearance_m),
        ),
        (
            "max lateral error",
            metres(lateral_m, 3),
            lateral_m
                .zip(run.limits.lateral_error_m)
                .is_some_and(|(value, most)| value > most),
        ),
        ("seed", run.summary.seed.to_string(), false),
    ];
    let step_px = (WIDTH_PX - 2.0 * MARGIN_PX) / fields.len() as f64;
    canvas.line("grid", [MARGIN_PX, 102.0], [PLOT_RIGHT_PX, 102.0]);
    for (index, (name, value, wrong)) in fields.iter().enumerate() {
        let x_px = MARGIN_PX + step_px * index as f64;
        canvas.text("k", [x_px, 126.0], name);
        let class = if *wrong { "v bad" } else { "v" };
        // A seed may have twenty digits; it is wanted whole.
        let long = text_width_px(value, 23.0) > step_px - 12.0;
        canvas.text(if long { "b" } else { class }, [x_px, 153.0], value);
    }
}

/// Draws what stands under the charts; returns where the page ends.
pub(super) fn draw_end(canvas: &mut Canvas, run: &DrawnRun<'_>, top_px: f64) -> f64 {
    let mut y_px = top_px + 12.0;
    let violations: Vec<_> = run.violations().collect();
    if !violations.is_empty() {
        canvas.text("cap bad", [MARGIN_PX, y_px], "Violations");
        y_px += LINE_PX;
    }
    for violation in violations.iter().take(MOST_VIOLATIONS) {
        let at = format!("{:.1} s", violation.at_s);
        canvas.text("bad e", [MARGIN_PX + 62.0, y_px], &shortened(&at, 10));
        canvas.text(
            "bad b",
            [MARGIN_PX + 78.0, y_px],
            &shortened(violation.kind.name(), 22),
        );
        canvas.text(
            "bad",
            [MARGIN_PX + 260.0, y_px],
            &shortened(&violation.detail, 150),
        );
        y_px += LINE_PX;
    }
    if let Some(more) = violations
        .len()
        .checked_sub(MOST_VIOLATIONS)
        .filter(|&more| more > 0)
    {
        let text = format!("and {more} more: see summary.json");
        canvas.text("bad", [MARGIN_PX + 78.0, y_px], &text);
        y_px += LINE_PX;
    }
    if !violations.is_empty() {
        y_px += 8.0;
    }
    let machine = &run.summary.machine;
    let text = format!(
        "On {}, {} cores, kernel {}. All curves are the world's truth; schedule changes stand where the robot believed to be.",
        shortened(&machine.processor, 60),
        machine.cores,
        shortened(&machine.kernel, 50)
    );
    canvas.text("note", [MARGIN_PX, y_px], &text);
    y_px + 24.0
}
