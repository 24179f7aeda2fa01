//! Marks on a map: labels with a line to what they name, and rings where something went wrong.

use super::canvas::{Canvas, Px, Px2, shortened};
use super::labels::{Field, Labels, PILL_HEIGHT_PX};
use super::thin::distance_px;
use crate::summary::Violation;

/// Marks of one kind; those nearer to each other than this are one.
const MOST_MARKS: usize = 200;
const APART_PX: f64 = 5.0;

/// Adds a place unless a mark is there already, or there are enough.
pub(in crate::report) fn is_new(marked: &mut Vec<Px2>, at: Px2) -> bool {
    let near = |other: &Px2| distance_px(*other, at) < APART_PX;
    let new = marked.len() < MOST_MARKS && !marked.iter().any(near);
    if new {
        marked.push(at);
    }
    new
}

/// Red rings where something went wrong.
pub(in crate::report) fn draw_rings<'a>(
    canvas: &mut Canvas,
    labels: &mut Labels,
    radius_px: f64,
    violations: impl Iterator<Item = (&'a Violation, Px2)>,
) {
    const TAKEN_PX: f64 = 20.0;
    let mut marked = Vec::new();
    for (violation, at) in violations {
        if !is_new(&mut marked, at) {
            continue;
        }
        let ([x, y], radius) = (at.map(Px), Px(radius_px));
        let hint = format!(
            "{} at {:.1} s: {}",
            violation.kind, violation.at_s, violation.detail
        );
        canvas.element_with_hint(
            "circle",
            format_args!("class=\"hit\" cx=\"{x}\" cy=\"{y}\" r=\"{radius}\""),
            &shortened(&hint, 120),
        );
        labels.take(Field::around(at, [TAKEN_PX; 2]));
    }
}

/// The ground of a label, with a line to what it names; returns where the middle of its text stands, or none if there is no
/// room.
pub(in crate::report) fn draw_pill(
    canvas: &mut Canvas,
    labels: &mut Labels,
    named: &Field,
    width_px: f64,
) -> Option<Px2> {
    let field = labels.place(named, [width_px, PILL_HEIGHT_PX])?;
    let from = named.nearest(field.middle());
    canvas.line("lead", from, field.nearest(from));
    let round = Px(PILL_HEIGHT_PX / 2.0);
    canvas.rect(&format!("class=\"pill\" rx=\"{round}\""), field.rectangle());
    let [x, y] = field.middle();
    Some([x, y + 4.6])
}
