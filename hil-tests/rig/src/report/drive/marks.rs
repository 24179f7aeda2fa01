//! Marks on the map: violations, the two ends of the path, and where the schedule changed.

use super::run::DrawnRun;
use super::schedule::{Entry, Schedule};
use crate::report::draw::canvas::{Canvas, Px2, shortened};
use crate::report::draw::frame::Frame;
use crate::report::draw::labels::{Field, LABEL_PX, Labels, text_width_px};
use crate::report::draw::marks;

/// Red rings where something went wrong.
pub(super) fn draw_violations(
    canvas: &mut Canvas,
    run: &DrawnRun<'_>,
    frame: &Frame,
    labels: &mut Labels,
) {
    let places = { run.violations() }.filter_map(|violation| {
        let sample = run.sample_at(violation.at_s)?;
        Some((violation, frame.at(sample.at_m())))
    });
    marks::draw_rings(canvas, labels, 8.0, places);
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
        if marks::is_new(&mut marked, at) {
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

/// A label with a line to what it names; false if there is no room.
fn draw_pill(
    canvas: &mut Canvas,
    labels: &mut Labels,
    named: &Field,
    number: &str,
    name: &str,
) -> bool {
    let width_px = text_width_px(number, LABEL_PX) + text_width_px(name, LABEL_PX) + 20.0;
    let place = marks::draw_pill(canvas, labels, named, width_px);
    if let Some(at) = place {
        canvas.numbered_text("m", at, number, name);
    }
    place.is_some()
}
