//! The rows of areas in the diagram of areas over time, and the window of time that a panel shows.

use crate::report::draw::canvas::{Canvas, shortened};
use crate::report::draw::labels::text_width_px;

use super::lanes::{AreaRow, Bar};
use super::style::WIDTH_PX;

pub(super) const LEFT_PX: f64 = 104.0;
pub(super) const RIGHT_PX: f64 = WIDTH_PX - 16.0;
pub(super) const SLOT_PX: f64 = 17.0;
pub(super) const ASK_PX: f64 = 8.0;
pub(super) const TEXT_PX: f64 = 11.0;
/// Bars and states narrower than this are drawn together with what is before them.
pub(super) const LEAST_PX: f64 = 0.4;

/// The time that a panel shows.
#[derive(Clone, Copy)]
pub(super) struct Window {
    pub(super) from_s: f64,
    pub(super) to_s: f64,
}

impl Window {
    pub(super) fn x(&self, at_s: f64) -> f64 {
        LEFT_PX + (RIGHT_PX - LEFT_PX) * (at_s - self.from_s) / (self.to_s - self.from_s)
    }

    /// Left end and width of what can be seen of a span.
    pub(super) fn cut(&self, (from_s, to_s): (f64, f64)) -> Option<(f64, f64)> {
        let (from_s, to_s) = (from_s.max(self.from_s), to_s.min(self.to_s));
        let left = self.x(from_s);
        (from_s <= to_s).then(|| (left, self.x(to_s) - left))
    }

    pub(super) fn holds(&self, at_s: f64) -> bool {
        (self.from_s..=self.to_s).contains(&at_s)
    }
}

pub(super) fn row_height_px(row: &AreaRow<'_>) -> f64 {
    row.slots as f64 * SLOT_PX + row.ask_lanes as f64 * ASK_PX + 2.0
}

pub(super) fn draw_row_ground(canvas: &mut Canvas, row: &AreaRow<'_>, top_px: f64, height_px: f64) {
    rect(
        canvas,
        "row",
        [LEFT_PX, top_px, RIGHT_PX - LEFT_PX, height_px],
        "",
    );
    let middle_px = top_px + row.slots as f64 * SLOT_PX / 2.0;
    let many = if row.area.capacity > 1 {
        format!(" ({})", row.area.capacity)
    } else {
        String::new()
    };
    let name = format!("{}{many}", shortened(&row.area.id, 14));
    canvas.text("b e", [LEFT_PX - 8.0, middle_px + 5.5], &name);
}

pub(super) fn draw_row(canvas: &mut Canvas, window: Window, row: &AreaRow<'_>, top_px: f64) {
    for (lanes, step_px, base_px) in [
        (&row.holds, SLOT_PX, 1.0),
        (&row.asks, ASK_PX, row.slots as f64 * SLOT_PX + 1.0),
    ] {
        let mut drawn: Vec<f64> = Vec::new();
        for (lane, bar) in lanes {
            drawn.resize(drawn.len().max(lane + 1), f64::NEG_INFINITY);
            let Some((x, width)) = window.cut(bar.span) else {
                continue;
            };
            if x + width < drawn[*lane] + LEAST_PX {
                continue;
            }
            drawn[*lane] = x + width;
            let y = top_px + base_px + *lane as f64 * step_px;
            draw_bar(canvas, window, bar, [x, y, width, step_px - 2.0]);
            if !bar.asks && *lane >= row.area.capacity as usize {
                rect(
                    canvas,
                    "hit",
                    [x, y, width, step_px - 2.0],
                    "more than the area holds",
                );
            }
        }
    }
}

pub(super) fn draw_bar(canvas: &mut Canvas, window: Window, bar: &Bar<'_>, at: [f64; 4]) {
    let [x, y, width, height] = at;
    canvas.open("g", format_args!("class=\"{}\"", bar.class));
    if bar.asks {
        rect(canvas, "ask", at, &bar.hint);
        rect(canvas, "edge", at, "");
    } else {
        rect(canvas, "hold", at, &bar.hint);
        let inside = bar.inside.and_then(|inside| window.cut(inside));
        if let Some((x, width)) = inside {
            rect(canvas, "own", [x, y, width.max(0.6), height], &bar.hint);
        }
        rect(canvas, "edge", at, "");
        // In the entered part if there is room.
        let words = bar.robot;
        let place = inside.filter(|(_, width)| fits(words, *width));
        if let Some((x, width)) = place {
            canvas.text("onbar m", [x + width / 2.0, y + height - 3.8], words);
        } else if inside.is_none() && fits(words, width) {
            canvas.text("inbar m", [x + width / 2.0, y + height - 3.8], words);
        }
    }
    canvas.close("g");
}

pub(super) fn fits(text: &str, width_px: f64) -> bool {
    text_width_px(text, TEXT_PX) + 3.0 < width_px
}

pub(super) fn rect(canvas: &mut Canvas, class: &str, place: [f64; 4], hint: &str) {
    let class = format!("class=\"{class}\"");
    if hint.is_empty() {
        canvas.rect(&class, place);
    } else {
        canvas.rect_with_hint(&class, place, &shortened(hint, 160));
    }
}
