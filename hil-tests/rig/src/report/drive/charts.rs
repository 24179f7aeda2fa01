//! The lower panel: speed, clearance and lateral position over time.

use super::run::{DrawnRun, Sample};
use crate::report::draw::canvas::{Canvas, Curve, Px2, shortened};
use crate::report::draw::labels::text_width_px;
use crate::report::draw::scale;
use crate::report::draw::sheet::{PLOT_LEFT_PX, PLOT_RIGHT_PX};
use crate::report::draw::thin::{Column, columns};

const HEIGHT_PX: f64 = 130.0;
const GAP_PX: f64 = 58.0;
/// The lateral position is shown at least to here on both sides.
const SHOWN_LATERAL_M: f64 = 0.13;
/// Room for the areas' ids.
const STRIP_PX: f64 = 18.0;
/// Bands of areas and marks of violations are no nearer to each other than this.
const LEAST_BAND_PX: usize = 4;
/// A longer time without a value leaves a gap in a curve.
const GAP_S: f64 = 0.5;

/// One value over time.
struct Chart {
    title: &'static str,
    /// A gap where there is none.
    value: fn(&Sample) -> Option<f64>,
    /// The axis reaches at least from here to there,
    shown: (f64, f64),
    /// and at most over this range; beyond it the curve is cut.
    most: (f64, f64),
    /// Values outside are violations.
    allowed: (f64, f64),
    /// The speed limit of the area is drawn, too.
    has_speed_limit: bool,
}

/// Places of one chart.
#[derive(Clone, Copy)]
struct Plot {
    top_px: f64,
    low: f64,
    high: f64,
    time_s: (f64, f64),
}

impl Plot {
    fn x(&self, at_s: f64) -> f64 {
        PLOT_LEFT_PX + (PLOT_RIGHT_PX - PLOT_LEFT_PX) * self.share(at_s)
    }

    fn share(&self, at_s: f64) -> f64 {
        (at_s - self.time_s.0) / (self.time_s.1 - self.time_s.0)
    }

    fn y(&self, value: f64) -> f64 {
        let share = (value - self.low) / (self.high - self.low);
        self.top_px + HEIGHT_PX * (1.0 - share.clamp(0.0, 1.0))
    }

    /// Most columns without a value that leave no gap.
    fn gap_columns(&self) -> usize {
        let gap = whole_columns() as f64 * GAP_S / (self.time_s.1 - self.time_s.0);
        (gap.ceil() as usize).max(2)
    }

    fn bottom_px(&self) -> f64 {
        self.top_px + HEIGHT_PX
    }

    fn rectangle(&self) -> [f64; 4] {
        [
            PLOT_LEFT_PX,
            self.top_px,
            PLOT_RIGHT_PX - PLOT_LEFT_PX,
            HEIGHT_PX,
        ]
    }
}

/// Draws the panel; returns where it ends.
pub(super) fn draw(canvas: &mut Canvas, run: &DrawnRun<'_>, top_px: f64) -> f64 {
    let top_m_s = run.top_speed_m_s() * 1.12;
    let nearest = |sample: &Sample| sample.clearance_m.is_finite().then_some(sample.clearance_m);
    let lateral_m = run.limits.lateral_error_m.unwrap_or(f64::INFINITY);
    let charts = [
        Chart {
            title: "True speed, m/s (dashed: the area's limit)",
            value: |sample| Some(sample.speed_m_s),
            shown: (0.0, top_m_s),
            most: (-top_m_s, top_m_s),
            allowed: (f64::NEG_INFINITY, f64::INFINITY),
            has_speed_limit: true,
        },
        Chart {
            title: "Clearance of the footprint, m",
            value: nearest,
            shown: (0.0, 0.3),
            most: (0.0, 4.0),
            allowed: (
                // Without a limit no part of the axis is red.
                if run.limits.clearance_m > 0.0 {
                    run.limits.clearance_m
                } else {
                    f64::NEG_INFINITY
                },
                f64::INFINITY,
            ),
            has_speed_limit: false,
        },
        Chart {
            title: "Lateral position on the lane, m (left is positive; none where no lane is followed)",
            value: |sample| sample.lateral_m,
            shown: (-SHOWN_LATERAL_M, SHOWN_LATERAL_M),
            most: (-1.0, 1.0),
            allowed: (-lateral_m, lateral_m),
            has_speed_limit: false,
        },
    ];
    let first_px = top_px + 48.0;
    let mut plots = Vec::new();
    for (index, chart) in charts.iter().enumerate() {
        plots.push(plot(
            run,
            chart,
            first_px + (HEIGHT_PX + GAP_PX) * index as f64,
        ));
    }
    draw_areas(canvas, run, &plots);
    for (chart, plot) in charts.iter().zip(&plots) {
        draw_chart(canvas, run, chart, plot);
    }
    let bottom_px = plots.last().map_or(first_px, Plot::bottom_px);
    canvas.text(
        "axis m",
        [(PLOT_LEFT_PX + PLOT_RIGHT_PX) / 2.0, bottom_px + 40.0],
        "time since the start of the run, s",
    );
    bottom_px + 66.0
}

fn plot(run: &DrawnRun<'_>, chart: &Chart, top_px: f64) -> Plot {
    let values = || run.samples.iter().filter_map(chart.value);
    let (least, most) = (
        values().fold(f64::INFINITY, f64::min),
        values().fold(f64::NEG_INFINITY, f64::max),
    );
    let (mut low, mut high) = (least.min(chart.shown.0), most.max(chart.shown.1));
    // What reaches beyond what is shown anyway gets some room.
    let room = 0.07 * (high - low);
    if least < chart.shown.0 {
        low -= room;
    }
    if most > chart.shown.1 {
        high += room;
    }
    Plot {
        top_px,
        low: low.max(chart.most.0),
        high: high.min(chart.most.1),
        time_s: run.time_range_s(),
    }
}

/// Bands behind all charts, in the areas' colours, and their ids over the first one.
fn draw_areas(canvas: &mut Canvas, run: &DrawnRun<'_>, plots: &[Plot]) {
    let Some(first) = plots.first() else { return };
    let columns = whole_columns();
    let area_at = |column: usize| {
        let share = (column as f64 + 0.5) / columns as f64;
        let at_s = first.time_s.0 + share * (first.time_s.1 - first.time_s.0);
        run.sample_at(at_s).and_then(|sample| sample.area)
    };
    let mut shown: Vec<[f64; 4]> = plots.iter().map(Plot::rectangle).collect();
    shown[0][1] -= STRIP_PX;
    shown[0][3] += STRIP_PX;
    canvas.open_clipped("plots", &shown);
    let (top_px, bottom_px) = (first.top_px - STRIP_PX, plots[plots.len() - 1].bottom_px());
    let mut begin = 0;
    while begin < columns && !run.samples.is_empty() {
        let area = area_at(begin);
        let end = (begin..columns)
            .step_by(LEAST_BAND_PX)
            .find(|&column| area_at(column) != area)
            .unwrap_or(columns);
        if let Some(index) = area {
            let (left, width) = (PLOT_LEFT_PX + begin as f64, (end - begin) as f64);
            let colour = scale::area_colour(index);
            canvas.rect(
                &format!("fill=\"{colour}\" fill-opacity=\".6\""),
                [left, top_px, width, bottom_px - top_px],
            );
            let id = shortened(&run.site.areas[index].id, 24);
            if text_width_px(&id, 13.0) + 6.0 < width {
                canvas.text("b m", [left + width / 2.0, top_px + 13.5], &id);
            }
        }
        begin = end;
    }
    canvas.close("g");
    canvas.text("axis e", [PLOT_LEFT_PX - 10.0, top_px + 13.5], "area");
}

fn draw_chart(canvas: &mut Canvas, run: &DrawnRun<'_>, chart: &Chart, plot: &Plot) {
    draw_grid(canvas, chart, plot);
    draw_limits(canvas, chart, plot);
    if chart.has_speed_limit {
        canvas.curve("class=\"limit\"", &speed_limits(run, plot));
    }
    canvas.curve("class=\"when\"", &violation_marks(run, plot));
    let values = run.samples.iter().map(|sample| {
        (
            plot.share(sample.at_s),
            (chart.value)(sample).unwrap_or(f64::NAN),
        )
    });
    let columns = columns(values, whole_columns());
    if columns.is_empty() {
        let middle = [
            (PLOT_LEFT_PX + PLOT_RIGHT_PX) / 2.0,
            plot.top_px + 0.6 * HEIGHT_PX,
        ];
        canvas.text("axis m", middle, "nothing was recorded");
    }
    canvas.curve("class=\"curve\"", &curve(&columns, plot, |_| true));
    let (low, high) = chart.allowed;
    let over = curve(&columns, plot, |column| {
        column.low < low || column.high > high
    });
    canvas.curve("class=\"over\"", &over);
}

fn draw_grid(canvas: &mut Canvas, chart: &Chart, plot: &Plot) {
    let step = scale::step(plot.high - plot.low, 5.0);
    for value in scale::ticks(plot.low, plot.high, step) {
        let y = plot.y(value);
        canvas.line("grid", [PLOT_LEFT_PX, y], [PLOT_RIGHT_PX, y]);
        canvas.text(
            "tick e",
            [PLOT_LEFT_PX - 8.0, y + 4.0],
            &scale::label(value, step),
        );
    }
    let step_s = scale::step(plot.time_s.1 - plot.time_s.0, 20.0);
    for at_s in scale::ticks(plot.time_s.0, plot.time_s.1, step_s) {
        let x = plot.x(at_s);
        canvas.line("grid", [x, plot.top_px], [x, plot.bottom_px()]);
        canvas.line("mark", [x, plot.bottom_px()], [x, plot.bottom_px() + 4.0]);
        canvas.text(
            "tick m",
            [x, plot.bottom_px() + 17.0],
            &scale::label(at_s, step_s),
        );
    }
    canvas.rect("class=\"frame\"", plot.rectangle());
    let above_px = if chart.has_speed_limit {
        STRIP_PX + 9.0
    } else {
        9.0
    };
    canvas.text("cap", [PLOT_LEFT_PX, plot.top_px - above_px], chart.title);
}

/// Red from a limit on to the end of the axis.
fn draw_limits(canvas: &mut Canvas, chart: &Chart, plot: &Plot) {
    let (low, high) = chart.allowed;
    for (limit, from, to) in [(low, low, plot.low), (high, plot.high, high)] {
        if !limit.is_finite() {
            continue;
        }
        let (top_px, width_px) = (plot.y(from), PLOT_RIGHT_PX - PLOT_LEFT_PX);
        let place = [PLOT_LEFT_PX, top_px, width_px, plot.y(to) - top_px];
        canvas.rect("class=\"forbidden\"", place);
        let y = plot.y(limit);
        canvas.line("ban", [PLOT_LEFT_PX, y], [PLOT_RIGHT_PX, y]);
    }
}

/// Upright lines at the times of violations.
fn violation_marks(run: &DrawnRun<'_>, plot: &Plot) -> Curve {
    let mut places: Vec<f64> = run
        .violations()
        .map(|violation| plot.x(violation.at_s).clamp(PLOT_LEFT_PX, PLOT_RIGHT_PX))
        .collect();
    places.sort_unstable_by(f64::total_cmp);
    places.dedup_by(|next, kept| *next - *kept < LEAST_BAND_PX as f64);
    let mut curve = Curve::default();
    for x in places {
        curve.move_to([x, plot.top_px]);
        curve.vertical_to(plot.bottom_px());
    }
    curve
}

/// The limit of the area that the robot is in, as steps.
fn speed_limits(run: &DrawnRun<'_>, plot: &Plot) -> Curve {
    let limits = run.samples.iter().map(|sample| {
        let limit = sample
            .area
            .map(|index| run.site.areas[index].control.speed_limit_m_s);
        (plot.share(sample.at_s), limit.unwrap_or(f64::NAN))
    });
    let mut curve = Curve::default();
    let mut before: Option<Column> = None;
    let columns = columns(limits, whole_columns());
    let gap = plot.gap_columns();
    for (index, column) in columns.iter().enumerate() {
        let (x, y) = (PLOT_LEFT_PX + column.index as f64, plot.y(column.high));
        let goes_on = before.is_some_and(|before| before.index + gap >= column.index);
        let changes = before.is_none_or(|before| before.high != column.high);
        let ends = columns
            .get(index + 1)
            .is_none_or(|next| next.index > column.index + gap);
        match before {
            Some(before) if goes_on && changes => {
                curve.line_to([x, plot.y(before.high)]);
                curve.line_to([x, y]);
            }
            Some(_) if goes_on => {}
            _ => curve.move_to([x, y]),
        }
        if ends {
            curve.line_to([x + 1.0, y]);
        }
        before = Some(*column);
    }
    curve
}

/// Columns that the charts are wide.
fn whole_columns() -> usize {
    (PLOT_RIGHT_PX - PLOT_LEFT_PX) as usize
}

/// A curve through those columns that are wanted.
fn curve(columns: &[Column], plot: &Plot, wanted: impl Fn(&Column) -> bool) -> Curve {
    let mut curve = Curve::default();
    let mut before: Option<&Column> = None;
    let gap = plot.gap_columns();
    for column in columns {
        if !wanted(column) {
            before = None;
            continue;
        }
        let x = PLOT_LEFT_PX + column.index as f64 + 0.5;
        let (low, high): (Px2, Px2) = ([x, plot.y(column.low)], [x, plot.y(column.high)]);
        let (from, to) = if column.rises {
            (low, high)
        } else {
            (high, low)
        };
        if before.is_some_and(|before| before.index + gap >= column.index) {
            curve.line_to(from);
        } else {
            curve.move_to(from);
        }
        // Without length it still makes a lone column a dot.
        if (from[1] - to[1]).abs() >= 0.1 || before.is_none() {
            curve.vertical_to(to[1]);
        }
        before = Some(column);
    }
    curve
}
