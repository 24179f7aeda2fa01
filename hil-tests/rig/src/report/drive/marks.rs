//! Marks on the map: violations, the two ends of the path, and where the schedule changed.

use super::run::Run;
use super::schedule::{Entry, Schedule};
use crate::report::draw::canvas::{Canvas, Px, Px2, shortened};
use crate::report::draw::frame::Frame;
use crate::report::draw::labels::{Field, LABEL_PX, Labels, PILL_HEIGHT_PX, text_width_px};
use crate::report::draw::thin::distance_px;

/// Violations and later changes that are marked; those nearer to each other than this share a mark.
const MOST_MARKS: usize = 200;
const APART_PX: f64 = 5.0;

/// Red rings where something went wrong.
pub(super) fn draw_violations(
    canvas: &mut Canvas,
    run: &Run<'_>,
    frame: &Frame,
    labels: &mut Labels,
) {
    const RADIUS_PX: f64 = 8.0;
    let mut marked: Vec<Px2> = Vec::new();
    for violation in run.violations() {
        let Some(sample) = run.sample_at(violation.at_s) else {
            continue;
        };
        let at = frame.at(sample.at_m());
        if !is_new(&mut marked, at) {
            continue;
        }
        let [x, y] = at.map(Px);
        let hint = format!(
            "{} at {:.1} s: {}",
            violation.kind, violation.at_s, violation.detail
        );
        canvas.element_with_hint(
            "circle",
            format_args!("class=\"hit\" cx=\"{x}\" cy=\"{y}\" r=\"{RADIUS_PX}\""),
            &shortened(&hint, 100),
        );
        labels.take(Field::around(at, [2.0 * RADIUS_PX + 4.0; 2]));
    }
}

/// Marks schedule changes and names the two ends; a skill without room is left to the list under the map.
pub(super) fn draw_changes(
    canvas: &mut Canvas,
    schedule: &Schedule<'_>,
    ends: &[(&'static str, Field)],
    frame: &Frame,
    labels: &mut Labels,
) {
    let mut marked: Vec<Px2> = Vec::new();
    for at_m in &schedule.later_m {
        let at = frame.at(*at_m);
        if is_new(&mut marked, at) {
            canvas.circle("later", at, 3.0);
        }
    }
    let place = |entry: &Entry<'_>| frame.at(entry.first.believed_m);
    let places: Vec<Px2> = schedule.entries.iter().map(place).collect();
    for place in &places {
        labels.take(Field::around(*place, [12.0; 2]));
    }
    for (_, covered) in ends {
        labels.take(*covered);
    }
    for (name, covered) in ends {
        draw_pill(canvas, labels, covered, "", name);
    }
    for (index, (entry, place)) in schedule.entries.iter().zip(&places).enumerate() {
        let (number, dot) = ((index + 1).to_string(), Field::around(*place, [0.0; 2]));
        let skill = shortened(&entry.first.skill, 28);
        if !draw_pill(canvas, labels, &dot, &number, &skill) {
            draw_pill(canvas, labels, &dot, &number, "");
        }
    }
    for place in &places {
        canvas.circle("dot", *place, 4.5);
    }
}

/// Adds a place unless a mark is there already, or there are enough.
fn is_new(marked: &mut Vec<Px2>, at: Px2) -> bool {
    let new = marked.len() < MOST_MARKS
        && !marked
            .iter()
            .any(|other| distance_px(*other, at) < APART_PX);
    if new {
        marked.push(at);
    }
    new
}

/// A label with a line to what it names; false if there is no room.
fn draw_pill(
    canvas: &mut Canvas,
    labels: &mut Labels,
    named: &Field,
    number: &str,
    name: &str,
) -> bool {
    let width_px = text_width_px(number, LABEL_PX) + text_width_px(name, LABEL_PX) + 20.0;
    let Some(field) = labels.place(named, [width_px, PILL_HEIGHT_PX]) else {
        return false;
    };
    let from = named.nearest(field.middle());
    canvas.line("lead", from, field.nearest(from));
    let [x, y, width, height] = field.rectangle().map(Px);
    let round = Px(PILL_HEIGHT_PX / 2.0);
    canvas.element(
        "rect",
        format_args!(
            "class=\"pill\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" rx=\"{round}\""
        ),
    );
    let [x, y] = field.middle();
    canvas.numbered_text("m", [x, y + 4.6], number, name);
    true
}
