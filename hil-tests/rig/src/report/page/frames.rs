//! A coordination in a few pictures: where robots were, and who had which area, when transitions fired.

use std::fmt::Write;

use crate::summary::{CoordinationSummary, FiringSummary};

use super::html::{Page, quantity};
use super::view::View;
use crate::report::draw::canvas::{Canvas, Curve, Escaped, shortened};
use crate::report::draw::floor;
use crate::report::draw::frame::Frame;
use crate::report::draw::labels::{Field, Labels, text_width_px};
use crate::report::draw::outline::{covered, outline};

/// Pictures, and the least time from one to the next.
const MOST: usize = 9;
const LEAST_S: f64 = 1.0;
const WIDTH_PX: f64 = 384.0;
const MOST_HEIGHT_PX: f64 = 300.0;
/// How much of the path is shown behind each robot.
const TRAIL_S: f64 = 6.0;
const TEXT_PX: f64 = 12.0;

/// Writes the pictures of the first coordination that came to its end; false if there is none.
pub(super) fn write(page: &mut Page, view: &View<'_>, figure: usize) -> bool {
    let coordinations = &view.record.summary.coordinations;
    let runs = || coordinations.iter().filter(|run| run.firings.len() > 1);
    let Some(run) = runs()
        .find(|run| run.duration_s.is_some())
        .or_else(|| runs().next())
    else {
        return false;
    };
    page.raw("<figure>\n<div class=\"frames\">\n");
    for (index, (at_s, what)) in moments(run).iter().enumerate() {
        page.raw("<div>");
        page.raw(&picture(view, *at_s, index));
        let text = format!("<b>{}</b> {}", quantity(*at_s, 1, "s"), Escaped(what));
        page.raw(&text);
        page.raw("</div>\n");
    }
    page.raw("</div>\n");
    page.element(
        "figcaption",
        format!(
            "Figure {figure}. Coordination {} ({}) step by step: the robots where they truly were when the transition \
             fired, with the last {TRAIL_S:.0} s of their paths. Areas in the colour of the robot that had them; areas \
             without a colour were free.",
            run.number, run.id
        ),
    );
    page.raw("</figure>\n");
    true
}

/// Times with the transitions that fired then; as many as there is room for, evenly among them.
fn moments(run: &CoordinationSummary) -> Vec<(f64, String)> {
    let mut moments: Vec<(f64, String)> = Vec::new();
    let timed = run.firings.iter().filter(|own| own.at_s.is_finite());
    for FiringSummary { transition, at_s } in timed {
        match moments.last_mut().filter(|last| at_s - last.0 < LEAST_S) {
            Some(last) => {
                let _ = write!(last.1, ", {transition}");
            }
            None => moments.push((*at_s, transition.clone())),
        }
    }
    let count = moments.len().min(MOST);
    let last = (count.max(2) - 1) as f64;
    let chosen = |index: usize| ((moments.len() - 1) as f64 * index as f64 / last).round() as usize;
    (0..count)
        .map(|index| moments[chosen(index)].clone())
        .collect()
}

fn picture(view: &View<'_>, at_s: f64, index: usize) -> String {
    let record = view.record;
    let room = Field {
        min: [1.0; 2],
        max: [WIDTH_PX - 1.0, MOST_HEIGHT_PX],
    };
    let frame = Frame::within(&record.site, std::iter::empty(), room);
    let mut canvas = Canvas::default();
    let mut labels = Labels::new(frame.field);
    canvas.open_clipped(&format!("at{index}"), &[frame.field.rectangle()]);
    draw_areas(&mut canvas, view, &frame, &mut labels, at_s);
    floor::draw_walls(&mut canvas, &record.site, &frame, &mut labels);
    let mut named = Vec::new();
    for robot in &record.robots {
        let until = robot.path.partition_point(|point| point.at_s < at_s);
        let Some(here) = robot.path.get(until).or(robot.path.last()) else {
            continue;
        };
        let class = view.class(&robot.id);
        canvas.open("g", format_args!("class=\"{class}\""));
        let from = robot
            .path
            .partition_point(|point| point.at_s < at_s - TRAIL_S);
        let mut trail = Curve::default();
        let passed = robot.path[from..until.max(from)].iter().step_by(4);
        trail.along(passed.map(|point| frame.at([point.pose.x_m, point.pose.y_m])));
        canvas.curve("class=\"path\" stroke-width=\"1.8\"", &trail);
        canvas.curve(
            "class=\"here\"",
            &outline(&robot.footprint, &here.pose, &frame),
        );
        canvas.close("g");
        let body = covered(&robot.footprint, &here.pose, &frame);
        labels.take(body);
        named.push((shortened(&robot.id, 12), class, body));
    }
    for (id, class, body) in named {
        let size = [text_width_px(&id, TEXT_PX), TEXT_PX];
        if let Some(field) = labels.place(&body, size) {
            let [x, y] = field.middle();
            canvas.open("g", format_args!("class=\"{class}\""));
            canvas.text("name m halo", [x, y + 4.2], &id);
            canvas.close("g");
        }
    }
    canvas.close("g");
    let label = format!("map at {at_s:.1} s");
    canvas.finish_inline("at", [WIDTH_PX, frame.field.max[1] + 1.0], &label)
}

fn draw_areas(canvas: &mut Canvas, view: &View<'_>, frame: &Frame, labels: &mut Labels, at_s: f64) {
    for area in &view.record.site.areas {
        let field = frame.region(&area.region);
        canvas.rect("class=\"free\"", field.rectangle());
        let holders = view.record.holdings.iter().filter(|holding| {
            holding.area == area.id
                && holding.granted_s <= at_s
                && holding
                    .released_s
                    .is_none_or(|released_s| released_s > at_s)
        });
        for holding in holders {
            let class = view.class(&holding.robot);
            canvas.open("g", format_args!("class=\"{class}\""));
            canvas.rect("class=\"hold\"", field.rectangle());
            canvas.close("g");
        }
        let [left, top] = field.min;
        labels.take(Field {
            min: [left + 2.0, top + 2.0],
            max: [left + 6.0 + text_width_px(&area.id, 11.0), top + 14.0],
        });
        canvas.text("small", [left + 4.0, top + 12.0], &shortened(&area.id, 12));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(times_s: &[f64]) -> CoordinationSummary {
        let firing = |(index, at_s): (usize, &f64)| FiringSummary {
            transition: format!("t{index}"),
            at_s: *at_s,
        };
        CoordinationSummary {
            number: 1,
            id: "c".to_owned(),
            net: "n".to_owned(),
            situation: String::new(),
            robots: Vec::new(),
            from_s: 0.0,
            duration_s: None,
            firings: times_s.iter().enumerate().map(firing).collect(),
            marking: Vec::new(),
        }
    }

    #[test]
    fn firings_at_one_moment_share_a_picture() {
        let moments = moments(&run(&[1.0, 1.2, 5.0]));
        assert_eq!(
            moments,
            [(1.0, "t0, t1".to_owned()), (5.0, "t2".to_owned())]
        );
    }

    #[test]
    fn of_many_moments_the_first_and_the_last_are_among_those_chosen() {
        let times_s: Vec<f64> = (0..100).map(|index| f64::from(index) * 3.0).collect();
        let moments = moments(&run(&times_s));
        assert_eq!(moments.len(), MOST);
        assert_eq!((moments[0].0, moments[MOST - 1].0), (0.0, 297.0));
    }
}
