//! What the signs on the map mean, how long a metre is, and the list of schedule changes.

use super::run::DrawnRun;
use super::schedule::Schedule;
use super::speeds::{SPEED_COLOURS, speed_colour};
use crate::report::draw::canvas::{Canvas, Px2, shortened};
use crate::report::draw::frame::Frame;
use crate::report::draw::labels::text_width_px;
use crate::report::draw::scale;
use crate::report::draw::scale_bar::draw_scale_bar;
use crate::report::draw::sheet::{PLOT_LEFT_PX, PLOT_RIGHT_PX};

/// Draws the legend under the map's axis; returns where it ends.
pub(super) fn draw(
    canvas: &mut Canvas,
    run: &DrawnRun<'_>,
    schedule: &Schedule<'_>,
    frame: &Frame,
) -> f64 {
    let y_px = frame.field.max[1] + 74.0;
    let after_speed_px = draw_speeds(canvas, run, [PLOT_LEFT_PX, y_px]);
    draw_signs(canvas, [after_speed_px + 36.0, y_px]);
    draw_scale_bar(canvas, frame, y_px);
    draw_schedule(canvas, schedule, y_px + 40.0)
}

fn draw_speeds(canvas: &mut Canvas, run: &DrawnRun<'_>, at: Px2) -> f64 {
    const WIDTH_PX: f64 = 264.0;
    const TITLE: &str = "true speed";
    let left = at[0] + text_width_px(TITLE, 13.0) + 8.0;
    canvas.text("", [at[0], at[1] + 4.5], TITLE);
    let part_px = WIDTH_PX / SPEED_COLOURS as f64;
    for index in 0..SPEED_COLOURS {
        let (x, colour) = (left + part_px * index as f64, speed_colour(index));
        let place = [x, at[1] - 6.0, part_px + 0.5, 11.0];
        canvas.rect(&format!("fill=\"{colour}\""), place);
    }
    let top_m_s = run.top_speed_m_s();
    let step_m_s = scale::step(top_m_s, 5.0);
    for speed_m_s in scale::ticks(0.0, top_m_s, step_m_s) {
        let x = left + WIDTH_PX * speed_m_s / top_m_s;
        canvas.line("mark", [x, at[1] + 5.0], [x, at[1] + 9.0]);
        canvas.text(
            "tick m",
            [x, at[1] + 21.0],
            &scale::label(speed_m_s, step_m_s),
        );
    }
    canvas.text("tick", [left + WIDTH_PX + 18.0, at[1] + 21.0], "m/s");
    left + WIDTH_PX + 44.0
}

fn draw_signs(canvas: &mut Canvas, at: Px2) {
    const SIGN_PX: f64 = 34.0;
    let [mut x, y] = at;
    for (sign, name) in [
        ("lane", "lane"),
        ("zone", "perception zone"),
        ("dot", "schedule changes"),
        ("later", "again later"),
        ("wrong", "out of limits"),
        ("hit", "violation"),
    ] {
        let middle = [x + SIGN_PX / 2.0, y];
        match sign {
            "dot" => canvas.circle(sign, middle, 4.5),
            "later" => canvas.circle(sign, middle, 3.0),
            "hit" => canvas.circle(sign, middle, 8.0),
            _ => canvas.line(sign, [x, y], [x + SIGN_PX - 4.0, y]),
        }
        let gap_px = if matches!(sign, "dot" | "later" | "hit") {
            -4.0
        } else {
            4.0
        };
        canvas.text("", [x + SIGN_PX + gap_px, y + 4.5], name);
        x += SIGN_PX + gap_px + text_width_px(name, 13.0) + 14.0;
    }
}

/// The numbers on the map in words; returns where the list ends.
fn draw_schedule(canvas: &mut Canvas, schedule: &Schedule<'_>, top_px: f64) -> f64 {
    const COLUMNS: usize = 4;
    const LINE_PX: f64 = 21.0;
    if schedule.entries.is_empty() {
        return top_px;
    }
    let mut y = top_px + 8.0;
    let unlisted = match schedule.unlisted {
        0 => String::new(),
        more => format!("; {more} changes to yet other states are not shown"),
    };
    let title = format!("Schedule changes{unlisted}");
    canvas.text("cap", [PLOT_LEFT_PX, y], &title);
    y += LINE_PX + 2.0;
    let width_px = (PLOT_RIGHT_PX - PLOT_LEFT_PX) / COLUMNS as f64;
    let rows = schedule.entries.len().div_ceil(COLUMNS);
    for (index, entry) in schedule.entries.iter().enumerate() {
        let at = [
            PLOT_LEFT_PX + width_px * (index / rows) as f64,
            y + LINE_PX * (index % rows) as f64,
        ];
        let first = entry.first;
        let area = if first.area.is_empty() {
            "none"
        } else {
            &first.area
        };
        let text = format!("{}: state {}, area {area}", first.skill, first.state);
        canvas.text("b e", [at[0] + 16.0, at[1]], &(index + 1).to_string());
        let text = format!("{}, {}×", shortened(&text, 38), entry.times);
        canvas.text("", [at[0] + 24.0, at[1]], &text);
    }
    y + LINE_PX * rows as f64
}
