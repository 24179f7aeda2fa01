//! Spans of time in lanes, so that none covers another: an area's slots, and those who wait for it.

use description::site::Area;

use super::view::View;

/// Requests that are granted sooner are not shown as waits.
const AT_ONCE_S: f64 = 0.02;
/// A wait and a request of the same robot that began within this are the same.
const SAME_S: f64 = 0.5;
/// Waits for one area that are shown.
const MOST_ASKS: usize = 400;

/// What is shown of an area.
#[derive(Debug)]
pub(super) struct AreaRow<'a> {
    pub(super) area: &'a Area,
    /// Lanes for its owners: its capacity, more if more had it at once.
    pub(super) slots: usize,
    /// Lanes for those who wait.
    pub(super) ask_lanes: usize,
    /// By lane.
    pub(super) holds: Vec<(usize, Bar<'a>)>,
    /// By lane.
    pub(super) asks: Vec<(usize, Bar<'a>)>,
}

/// A robot had an area, or asked for it.
#[derive(Clone, Debug)]
pub(super) struct Bar<'a> {
    pub(super) robot: &'a str,
    pub(super) class: String,
    pub(super) asks: bool,
    pub(super) span: (f64, f64),
    /// When it was in it.
    pub(super) inside: Option<(f64, f64)>,
    pub(super) hint: String,
}

/// A row for each area of the site.
pub(super) fn area_rows<'a>(view: &View<'a>) -> Vec<AreaRow<'a>> {
    view.record
        .site
        .areas
        .iter()
        .map(|area| row(view, area))
        .collect()
}

fn row<'a>(view: &View<'a>, area: &'a Area) -> AreaRow<'a> {
    let (mut holds, mut asks) = (Vec::new(), Vec::new());
    for holding in view
        .record
        .holdings
        .iter()
        .filter(|holding| holding.area == area.id)
    {
        let Some(span) = view.shown(holding.granted_s, holding.released_s) else {
            continue;
        };
        let entered = holding
            .entered_s
            .and_then(|at_s| view.shown(at_s.max(span.0), holding.released_s));
        let (from_s, to_s) = span;
        let hint = format!(
            "{} had area {} from {from_s:.2} s to {to_s:.2} s, fence {}",
            holding.robot, area.id, holding.fence
        );
        holds.push(Bar {
            robot: &holding.robot,
            class: view.class(&holding.robot),
            asks: false,
            span,
            inside: entered,
            hint,
        });
        if let Some(requested_s) = holding.requested_s {
            asks.extend(ask(
                view,
                &holding.robot,
                &area.id,
                (requested_s, Some(holding.granted_s)),
                "",
            ));
        }
    }
    for wait in view.record.waits.iter().filter(|wait| wait.area == area.id) {
        let same = |bar: &&mut Bar<'_>| {
            bar.robot == wait.robot && (bar.span.0 - wait.from_s).abs() < SAME_S
        };
        let told = ask(
            view,
            &wait.robot,
            &area.id,
            (wait.from_s, wait.to_s),
            &wait.why,
        );
        match (asks.iter_mut().find(same), told) {
            (Some(known), Some(told)) => known.hint = told.hint,
            (None, Some(told)) => asks.push(told),
            _ => {}
        }
    }
    // Of very many, keep the longest.
    asks.sort_by(|a, b| (b.span.1 - b.span.0).total_cmp(&(a.span.1 - a.span.0)));
    asks.truncate(MOST_ASKS);
    asks.sort_by(|a, b| a.span.0.total_cmp(&b.span.0));
    let slot = stacked(holds.iter().map(|bar| bar.span));
    let lane = stacked(asks.iter().map(|bar| bar.span));
    let most = |lanes: &[usize]| lanes.iter().max().map_or(0, |last| last + 1);
    AreaRow {
        area,
        slots: most(&slot).max(area.capacity.clamp(1, 12) as usize),
        ask_lanes: most(&lane),
        holds: slot.into_iter().zip(holds).collect(),
        asks: lane.into_iter().zip(asks).collect(),
    }
}

fn ask<'a>(
    view: &View<'a>,
    robot: &'a str,
    area: &str,
    (from_s, to_s): (f64, Option<f64>),
    why: &str,
) -> Option<Bar<'a>> {
    let span = view
        .shown(from_s, to_s)
        .filter(|span| span.1 - span.0 > AT_ONCE_S)?;
    let end = if to_s.is_some() {
        ""
    } else {
        ", until the end"
    };
    let why = if why.is_empty() {
        String::new()
    } else {
        format!(": {why}")
    };
    Some(Bar {
        robot,
        class: view.class(robot),
        asks: true,
        span,
        inside: None,
        hint: format!(
            "{robot} waited {:.2} s for area {area}{end}{why}",
            span.1 - span.0
        ),
    })
}

/// A lane for each span, the first that is free; spans are in the order of their beginnings.
pub(super) fn stacked(spans: impl Iterator<Item = (f64, f64)>) -> Vec<usize> {
    // What ends where the next begins is heard a moment late.
    const SLACK_S: f64 = 0.05;
    let mut ends_s: Vec<f64> = Vec::new();
    spans
        .map(|(from_s, to_s)| {
            let free = ends_s.iter().position(|end_s| *end_s <= from_s + SLACK_S);
            let lane = free.unwrap_or(ends_s.len());
            if lane == ends_s.len() {
                ends_s.push(to_s);
            } else {
                ends_s[lane] = to_s;
            }
            lane
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_that_overlap_have_lanes_of_their_own() {
        let spans = [(0.0, 4.0), (1.0, 2.0), (2.0, 9.0), (4.0, 5.0), (4.5, 6.0)];
        assert_eq!(stacked(spans.into_iter()), [0, 1, 1, 0, 2]);
        assert!(stacked(std::iter::empty()).is_empty());
    }
}
