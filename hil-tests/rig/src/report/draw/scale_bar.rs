//! A bar that shows how long a metre is.

use super::canvas::{Canvas, Px2};
use super::frame::Frame;
use super::scale;
use super::sheet::PLOT_RIGHT_PX;

/// How long a metre, or another round length, is.
pub(in crate::report) fn draw_scale_bar(canvas: &mut Canvas, frame: &Frame, y: f64) {
    draw_scale_bar_at(canvas, frame, [PLOT_RIGHT_PX, y]);
}

/// The same with its right end at a place.
pub(in crate::report) fn draw_scale_bar_at(canvas: &mut Canvas, frame: &Frame, [right, y]: Px2) {
    // The longest round length under 180 px.
    let most_m = 180.0 / frame.px_per_m;
    let power = 10f64.powf(most_m.log10().floor());
    let digit = [5.0, 2.0, 1.0]
        .into_iter()
        .find(|digit| digit * power <= most_m);
    let length_m = digit.unwrap_or(1.0) * power;
    let left = right - length_m * frame.px_per_m;
    canvas.line("scale", [left, y], [right, y]);
    for x in [left, right] {
        canvas.line("scale", [x, y - 5.0], [x, y + 5.0]);
    }
    let text = format!("{} m", scale::label(length_m, length_m));
    canvas.text("tick m", [(left + right) / 2.0, y + 21.0], &text);
}
