//! The map: every robot's true path in its colour, with the time along it.

use crate::record::{PathPoint, RobotRecord};

use super::style::WIDTH_PX;
use super::view::View;
use crate::report::draw::canvas::{Canvas, Curve, Px2, shortened};
use crate::report::draw::floor;
use crate::report::draw::frame::Frame;
use crate::report::draw::labels::{Field, Labels, text_width_px};
use crate::report::draw::marks;
use crate::report::draw::outline::{covered, outline};
use crate::report::draw::scale;
use crate::report::draw::scale_bar;
use crate::report::draw::thin::{apart, distance_px};

const LEFT_PX: f64 = 58.0;
const RIGHT_PX: f64 = WIDTH_PX - 8.0;
const MOST_HEIGHT_PX: f64 = 720.0;
/// Paths that lie on one another are seen by their widths: the first is the widest.
const LINE_PX: f64 = 2.0;
const WIDER_PX: f64 = 3.0;
const WIDEST_PX: f64 = 11.0;
const MOST_POINTS: usize = 6000;
const SPACING_PX: f64 = 1.5;
/// Marks of time along all of a path.
const MOST_TICKS: f64 = 24.0;
const TICK_PX: f64 = 6.0;
const TEXT_PX: f64 = 12.0;
/// A robot that stays within a small distance for at least this long counts as standing.
const STANDS_S: f64 = 3.0;
const STANDS_M_S: f64 = 0.01;
const MOST_STANDS: usize = 12;
/// A footprint at every second mark of time, no nearer than this to another of the same robot.
const APART_M: f64 = 0.7;
const MOST_FOOTPRINTS: usize = 14;

/// Draws the map; also returns the time between two marks along the paths.
pub(super) fn draw(view: &View<'_>) -> (String, f64) {
    let record = view.record;
    let path = record.robots.iter().flat_map(|robot| &robot.path);
    let room = Field {
        min: [LEFT_PX, 6.0],
        max: [RIGHT_PX, 6.0 + MOST_HEIGHT_PX],
    };
    let places = path.filter(|point| point.pose.is_finite());
    let frame = Frame::within(&record.site, places.map(at_m), room);
    let mut labels = Labels::new(frame.field);
    let mut canvas = Canvas::default();
    canvas.open_clipped("floor", &[frame.field.rectangle()]);
    floor::draw_areas(&mut canvas, &record.site, &frame, &mut labels);
    floor::draw_lanes(&mut canvas, &record.site, &frame);
    let step_s = scale::step(view.end_s, MOST_TICKS);
    let robots: Vec<Track<'_>> = record
        .robots
        .iter()
        .map(|robot| Track::new(robot, view.class(&robot.id)))
        .collect();
    for track in &robots {
        track.draw_footprints(&mut canvas, &frame, step_s);
    }
    floor::draw_walls(&mut canvas, &record.site, &frame, &mut labels);
    for (index, track) in robots.iter().enumerate() {
        let over = robots.len() - 1 - index;
        let width_px = (LINE_PX + WIDER_PX * over as f64).min(WIDEST_PX);
        track.draw_path(&mut canvas, &frame, &mut labels, width_px);
    }
    draw_violations(&mut canvas, view, &frame, &mut labels);
    for track in &robots {
        track.draw_ends(&mut canvas, &frame, &mut labels);
    }
    for track in &robots {
        track.draw_stands(&mut canvas, &frame, &mut labels);
        track.draw_times(&mut canvas, &frame, &mut labels, step_s);
    }
    canvas.close("g");
    frame.draw_axes(&mut canvas);
    let below_px = frame.field.max[1] + 40.0;
    scale_bar::draw_scale_bar_at(&mut canvas, &frame, [RIGHT_PX, below_px - 6.0]);
    let drawing = canvas.finish_inline(
        "map",
        [WIDTH_PX, below_px + 24.0],
        "map with the robots' paths",
    );
    (drawing, step_s)
}

fn at_m(point: &PathPoint) -> [f64; 2] {
    [point.pose.x_m, point.pose.y_m]
}

struct Track<'a> {
    robot: &'a RobotRecord,
    class: String,
    points: Vec<&'a PathPoint>,
}

impl<'a> Track<'a> {
    fn new(robot: &'a RobotRecord, class: String) -> Self {
        let finite = |point: &&PathPoint| point.pose.is_finite() && point.at_s.is_finite();
        Self {
            robot,
            class,
            points: robot.path.iter().filter(finite).collect(),
        }
    }

    fn open(&self, canvas: &mut Canvas) {
        canvas.open("g", format_args!("class=\"{}\"", self.class));
    }

    /// Where it was at each multiple of a step.
    fn marks(&self, step_s: f64) -> Vec<(f64, &'a PathPoint)> {
        let (Some(first), Some(last)) = (self.points.first(), self.points.last()) else {
            return Vec::new();
        };
        scale::ticks(first.at_s.max(step_s), last.at_s, step_s)
            .filter_map(|at_s| {
                let next = self.points.partition_point(|point| point.at_s < at_s);
                self.points.get(next).map(|point| (at_s, *point))
            })
            .collect()
    }

    fn draw_footprints(&self, canvas: &mut Canvas, frame: &Frame, step_s: f64) {
        let mut drawn: Vec<[f64; 2]> = Vec::new();
        self.open(canvas);
        for (_, point) in self.marks(2.0 * step_s) {
            let near = |other: &[f64; 2]| distance_px(*other, at_m(point)) < APART_M;
            if drawn.len() < MOST_FOOTPRINTS && !drawn.iter().any(near) {
                drawn.push(at_m(point));
                canvas.curve(
                    "class=\"ghost\"",
                    &outline(&self.robot.footprint, &point.pose, frame),
                );
            }
        }
        canvas.close("g");
    }

    fn draw_path(&self, canvas: &mut Canvas, frame: &Frame, labels: &mut Labels, width_px: f64) {
        let points: Vec<Px2> = self
            .points
            .iter()
            .map(|point| frame.at(at_m(point)))
            .collect();
        let mut curve = Curve::default();
        let kept = apart(&points, SPACING_PX, MOST_POINTS);
        curve.along(kept.into_iter().map(|index| points[index]));
        self.open(canvas);
        canvas.curve(
            &format!("class=\"path\" stroke-width=\"{width_px:.1}\""),
            &curve,
        );
        canvas.close("g");
        let shadow = apart(&points, 10.0, 1500);
        labels.avoid(shadow.into_iter().map(|index| points[index]));
    }

    fn draw_ends(&self, canvas: &mut Canvas, frame: &Frame, labels: &mut Labels) {
        let (Some(first), Some(last)) = (self.points.first(), self.points.last()) else {
            return;
        };
        self.open(canvas);
        canvas.curve(
            "class=\"start\"",
            &outline(&self.robot.footprint, &first.pose, frame),
        );
        canvas.curve(
            "class=\"here\"",
            &outline(&self.robot.footprint, &last.pose, frame),
        );
        let id = shortened(&self.robot.id, 16);
        let ends = if distance_px(at_m(first), at_m(last)) < 0.05 {
            vec![(first, format!("{id} start, end"))]
        } else {
            vec![(first, format!("{id} start")), (last, format!("{id} end"))]
        };
        for (point, _) in &ends {
            labels.take(covered(&self.robot.footprint, &point.pose, frame));
        }
        for (point, text) in &ends {
            self.label(
                canvas,
                labels,
                &covered(&self.robot.footprint, &point.pose, frame),
                text,
            );
        }
        canvas.close("g");
    }

    /// Where it stood, and how long.
    fn draw_stands(&self, canvas: &mut Canvas, frame: &Frame, labels: &mut Labels) {
        let mut stands: Vec<(f64, &PathPoint)> = Vec::new();
        let mut begin: Option<&PathPoint> = None;
        for (index, point) in self.points.iter().enumerate() {
            let stands_still = point.speed_m_s.abs() < STANDS_M_S;
            if stands_still && begin.is_none() {
                begin = Some(point);
            }
            let over = !stands_still || index + 1 == self.points.len();
            if let Some(first) = begin.filter(|_| over) {
                let lasted_s = point.at_s - first.at_s;
                if lasted_s >= STANDS_S {
                    stands.push((lasted_s, first));
                }
                begin = None;
            }
        }
        stands.sort_by(|a, b| b.0.total_cmp(&a.0));
        self.open(canvas);
        for (lasted_s, point) in stands.into_iter().take(MOST_STANDS) {
            let at = frame.at(at_m(point));
            canvas.circle("own", at, 4.5);
            let text = format!("stood {lasted_s:.0} s from {:.0} s", point.at_s);
            self.label(canvas, labels, &Field::around(at, [9.0; 2]), &text);
        }
        canvas.close("g");
    }

    fn draw_times(&self, canvas: &mut Canvas, frame: &Frame, labels: &mut Labels, step_s: f64) {
        self.open(canvas);
        let mut last: Option<Px2> = None;
        for (at_s, point) in self.marks(step_s) {
            let at = frame.at(at_m(point));
            if last.is_some_and(|last| distance_px(last, at) < 2.0 * TICK_PX) {
                continue;
            }
            last = Some(at);
            let (sin, cos) = point.pose.theta_rad.sin_cos();
            // Across the path; y is down on the page.
            let end = |side: f64| [at[0] + side * TICK_PX * sin, at[1] + side * TICK_PX * cos];
            canvas.line("pip", end(-1.0), end(1.0));
            let around = Field::around(at, [2.0 * TICK_PX * sin.abs(), 2.0 * TICK_PX * cos.abs()]);
            self.label(canvas, labels, &around, &scale::label(at_s, step_s));
        }
        canvas.close("g");
    }

    /// A text beside what it names, with a line if it stands farther away; left out when there is no room.
    fn label(&self, canvas: &mut Canvas, labels: &mut Labels, named: &Field, text: &str) {
        const NEAR_PX: f64 = 12.0;
        let size = [text_width_px(text, TEXT_PX) + 8.0, TEXT_PX + 2.0];
        let Some(field) = labels.place(named, size) else {
            return;
        };
        let from = named.nearest(field.middle());
        let to = field.nearest(from);
        if distance_px(from, to) > NEAR_PX {
            canvas.line("lead", from, to);
        }
        let [x, y] = field.middle();
        canvas.text("name m halo", [x, y + 4.2], text);
    }
}

/// Red rings where something went wrong.
fn draw_violations(canvas: &mut Canvas, view: &View<'_>, frame: &Frame, labels: &mut Labels) {
    let places = { view.record.summary.violations.iter() }.filter_map(|violation| {
        let path = &view.robot(&violation.robot)?.path;
        let next = path.partition_point(|point| point.at_s < violation.at_s);
        let point = path.get(next).or(path.last())?;
        Some((violation, frame.at(at_m(point))))
    });
    marks::draw_rings(canvas, labels, 10.0, places);
}
