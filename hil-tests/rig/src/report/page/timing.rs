//! Latencies as histograms, and the quantiles of each thread as strips, on logarithmic axes.

use super::html::short_time;
use super::style::WIDTH_PX;
use super::tables::{WANTED_P99_MS, micros};
use super::view::View;
use crate::report::draw::canvas::{Canvas, Curve, shortened};
use crate::report::draw::labels::text_width_px;
use crate::summary::Latency;

const HISTOGRAM_PX: f64 = 150.0;
const BINS: usize = 56;
const TEXT_PX: f64 = 12.0;
const STRIP_PX: f64 = 11.0;
const STRIP_STEP_PX: f64 = 15.0;
const GROUP_GAP_PX: f64 = 9.0;

/// A logarithmic axis of times in milliseconds.
#[derive(Clone, Copy, Debug)]
struct LogAxis {
    low: f64,
    high: f64,
    left_px: f64,
    right_px: f64,
}

impl LogAxis {
    /// From the power of ten under the least value to the one over the largest.
    fn over(values_ms: impl Iterator<Item = f64>, left_px: f64, right_px: f64) -> Self {
        const FINEST_MS: f64 = 1e-3;
        let (least, most) = values_ms
            .filter(|value| value.is_finite() && *value > 0.0)
            .fold((f64::INFINITY, FINEST_MS), |(least, most), value| {
                (least.min(value), most.max(value))
            });
        let low = least.min(most).clamp(FINEST_MS, 1e8).log10().floor();
        let high = most.min(1e9).log10().ceil().max(low + 1.0);
        Self {
            low,
            high,
            left_px,
            right_px,
        }
    }

    fn share(&self, value_ms: f64) -> f64 {
        ((value_ms.max(1e-12).log10() - self.low) / (self.high - self.low)).clamp(0.0, 1.0)
    }

    fn x(&self, value_ms: f64) -> f64 {
        self.left_px + (self.right_px - self.left_px) * self.share(value_ms)
    }

    /// Lines at the powers of ten, smaller marks at 2 and 5.
    fn draw(&self, canvas: &mut Canvas, top_px: f64, bottom_px: f64) {
        for power in self.low as i32..=self.high as i32 {
            let decade_ms = 10f64.powi(power);
            for digit in [1.0, 2.0, 5.0] {
                let value_ms = digit * decade_ms;
                if value_ms > 10f64.powf(self.high) * 1.001 {
                    continue;
                }
                let x = self.x(value_ms);
                let length_px = if digit == 1.0 { 5.0 } else { 3.0 };
                canvas.line("mark", [x, bottom_px], [x, bottom_px + length_px]);
                if digit == 1.0 {
                    canvas.line("grid", [x, top_px], [x, bottom_px]);
                    canvas.text("tick m", [x, bottom_px + 18.0], &decade(power));
                }
            }
        }
    }
}

/// A power of ten of milliseconds in its own unit.
fn decade(power: i32) -> String {
    let (value, unit) = match power {
        ..0 => (10f64.powi(power + 3), "µs"),
        0..3 => (10f64.powi(power), "ms"),
        3.. => (10f64.powi(power - 3), "s"),
    };
    format!("{value} {unit}")
}

/// Both latencies, side by side.
pub(super) fn histograms(view: &View<'_>) -> String {
    const GAP_PX: f64 = 60.0;
    let record = view.record;
    let half_px = (WIDTH_PX - GAP_PX) / 2.0;
    let mut canvas = Canvas::default();
    let charts = [
        (
            "request to grant, area free",
            &record.grant_latency_ms,
            &record.summary.grants,
        ),
        (
            "robot's flag to the mediator's command",
            &record.command_latency_ms,
            &record.summary.commands,
        ),
    ];
    for (index, (title, values_ms, latency)) in charts.into_iter().enumerate() {
        let left_px = 44.0 + index as f64 * (half_px + GAP_PX);
        let right_px = left_px - 44.0 + half_px - 26.0;
        histogram(&mut canvas, [left_px, right_px], title, values_ms, latency);
    }
    canvas.finish_inline(
        "latencies",
        [WIDTH_PX, HISTOGRAM_PX + 108.0],
        "histograms of latencies",
    )
}

fn histogram(
    canvas: &mut Canvas,
    [left_px, right_px]: [f64; 2],
    title: &str,
    values_ms: &[f64],
    latency: &Latency,
) {
    const TOP_PX: f64 = 66.0;
    let bottom_px = TOP_PX + HISTOGRAM_PX;
    let shown = values_ms.iter().copied().chain([WANTED_P99_MS]);
    let axis = LogAxis::over(shown, left_px, right_px);
    let heading = format!("{title} ({} measured)", latency.count);
    canvas.text("cap", [left_px, 16.0], &heading);
    axis.draw(canvas, TOP_PX, bottom_px);
    let mut counts = [0_usize; BINS];
    for value_ms in values_ms.iter().filter(|value| value.is_finite()) {
        counts[((axis.share(*value_ms) * BINS as f64) as usize).min(BINS - 1)] += 1;
    }
    let most = counts.iter().copied().max().unwrap_or(0).max(1);
    let bin_px = (right_px - left_px) / BINS as f64;
    canvas.open("g", format_args!("class=\"neutral\""));
    for (bin, count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let height_px = ((HISTOGRAM_PX - 6.0) * *count as f64 / most as f64).max(1.0);
        let (x, y) = (left_px + bin_px * bin as f64 + 0.5, bottom_px - height_px);
        let place = [x, y, bin_px - 1.0, height_px];
        canvas.rect_with_hint("class=\"bar\"", place, &count.to_string());
    }
    canvas.close("g");
    canvas.line("rule", [left_px, bottom_px], [right_px, bottom_px]);
    canvas.text("tick e", [left_px - 6.0, TOP_PX + 10.0], &most.to_string());
    canvas.text("tick e", [left_px - 6.0, bottom_px], "0");
    canvas.text(
        "axis m",
        [(left_px + right_px) / 2.0, bottom_px + 38.0],
        "latency",
    );
    if values_ms.is_empty() {
        let middle = [(left_px + right_px) / 2.0, TOP_PX + HISTOGRAM_PX / 2.0];
        canvas.text("axis m", middle, "none was measured");
    }
    // Each label on a line of its own, so that none covers another.
    let marks = [
        (
            Some(WANTED_P99_MS),
            "limit",
            "tick bad",
            "wanted: p99 under",
        ),
        (latency.p99_ms, "mark", "tick", "p99"),
        (latency.p50_ms, "mark", "tick", "p50"),
    ];
    let marks = marks.map(|(value_ms, class, text_class, name)| {
        let value_ms = value_ms.filter(|value| value.is_finite());
        (
            value_ms.map(|value_ms| (value_ms, axis.x(value_ms))),
            class,
            text_class,
            name,
        )
    });
    let y = |line: usize| 34.0 + 13.0 * line as f64;
    for (line, (place, class, _, _)) in marks.iter().enumerate() {
        if let Some((_, x)) = place {
            canvas.line(class, [*x, y(line) - 8.0], [*x, bottom_px]);
        }
    }
    for (line, (place, _, text_class, name)) in marks.iter().enumerate() {
        let Some((value_ms, x)) = place else {
            continue;
        };
        let text = format!("{name} {}", short_time(*value_ms));
        if x + 4.0 + text_width_px(&text, TEXT_PX) < right_px + 30.0 {
            canvas.text(&format!("{text_class} halo"), [x + 5.0, y(line)], &text);
        } else {
            canvas.text(&format!("{text_class} halo e"), [x - 5.0, y(line)], &text);
        }
    }
}

/// Wake-up latency and execution time of every thread of every robot; `None` if nothing is known of any.
pub(super) fn threads(view: &View<'_>) -> Option<String> {
    const LEFT_PX: f64 = 176.0;
    const GAP_PX: f64 = 56.0;
    const TOP_PX: f64 = 28.0;
    let members = &view.record.summary.robots;
    let mut names: Vec<&String> = members
        .iter()
        .flat_map(|robot| robot.threads.as_object().into_iter().flatten())
        .map(|(name, _)| name)
        .collect();
    names.sort();
    names.dedup();
    if names.is_empty() {
        return None;
    }
    let half_px = (WIDTH_PX - LEFT_PX - GAP_PX - 28.0) / 2.0;
    let group_px = STRIP_STEP_PX * members.len() as f64 + GROUP_GAP_PX;
    let bottom_px = TOP_PX + group_px * names.len() as f64 - GROUP_GAP_PX + 4.0;
    let mut canvas = Canvas::default();
    for (half, (group, title)) in [
        ("wakeup_us", "wake-up latency"),
        ("exec_us", "execution time"),
    ]
    .into_iter()
    .enumerate()
    {
        let left_px = LEFT_PX + half as f64 * (half_px + GAP_PX);
        let all = members.iter().flat_map(|robot| {
            let threads = robot.threads.as_object().into_iter().flatten();
            threads.flat_map(|(_, thread)| ["p50", "max"].map(|key| micros(thread, group, key)))
        });
        let axis = LogAxis::over(all.flatten(), left_px, left_px + half_px);
        canvas.text("cap", [left_px, 14.0], title);
        axis.draw(&mut canvas, TOP_PX - 6.0, bottom_px);
        canvas.line("rule", [left_px, bottom_px], [left_px + half_px, bottom_px]);
        for (index, name) in names.iter().enumerate() {
            for (row, robot) in members.iter().enumerate() {
                let y = TOP_PX + group_px * index as f64 + STRIP_STEP_PX * row as f64;
                if half == 0 {
                    if row == 0 {
                        canvas.text("b", [0.0, y + 9.5], &shortened(name, 15));
                    }
                    let class = view.class(&robot.id);
                    canvas.open("g", format_args!("class=\"{class}\""));
                    canvas.text(
                        "name small e",
                        [LEFT_PX - 8.0, y + 9.0],
                        &shortened(&robot.id, 9),
                    );
                    canvas.close("g");
                }
                let thread = &robot.threads[name.as_str()];
                let figures = ["p50", "p99", "p999", "max"].map(|key| micros(thread, group, key));
                let class = view.class(&robot.id);
                canvas.open("g", format_args!("class=\"{class}\""));
                strip(&mut canvas, &axis, figures, y);
                canvas.close("g");
            }
        }
    }
    Some(canvas.finish_inline("threads", [WIDTH_PX, bottom_px + 26.0], "timing of threads"))
}

/// From the median to the 99th percentile solid, to 99.9 % paler, a line to the largest.
fn strip(canvas: &mut Canvas, axis: &LogAxis, figures: [Option<f64>; 4], top_px: f64) {
    let [Some(p50), Some(p99), Some(p999), Some(max)] = figures else {
        return;
    };
    let [p50, p99, p999, max] = [p50, p99, p999, max].map(|value| axis.x(value));
    let hint = figures.map(short_time);
    let hint = format!(
        "p50 {}, p99 {}, p99.9 {}, max {}",
        hint[0], hint[1], hint[2], hint[3]
    );
    let middle = top_px + STRIP_PX / 2.0;
    let mut line = Curve::default();
    line.move_to([p999, middle]);
    line.line_to([max, middle]);
    canvas.curve("class=\"q3\"", &line);
    for (class, from, to) in [("q2", p99, p999), ("q1", p50, p99)] {
        let place = [from, top_px, (to - from).max(1.0), STRIP_PX];
        canvas.rect_with_hint(&format!("class=\"{class}\""), place, &hint);
    }
    canvas.circle("q4", [max, middle], 3.0);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_reaches_over_all_values_whatever_they_are() {
        let axis = LogAxis::over([0.3, 7.0].into_iter(), 0.0, 100.0);
        assert_eq!((axis.low, axis.high), (-1.0, 1.0));
        assert!((axis.x(1.0) - 50.0).abs() < 1e-9);
        for odd in [
            vec![],
            vec![0.0],
            vec![f64::NAN, -1.0],
            vec![f64::INFINITY, 1e300],
        ] {
            let axis = LogAxis::over(odd.into_iter(), 0.0, 100.0);
            assert!(axis.high > axis.low && axis.high < 10.0, "{axis:?}");
            assert!(axis.x(0.0).is_finite() && axis.x(f64::NAN).is_finite());
        }
    }

    #[test]
    fn powers_of_ten_have_units() {
        assert_eq!(
            [-3, -1, 0, 2, 3].map(decade),
            ["1 µs", "100 µs", "1 ms", "100 ms", "1 s"]
        );
    }
}
