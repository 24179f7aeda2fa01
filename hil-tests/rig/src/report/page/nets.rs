//! The coordinations: each net as a drawing with the order of its firings, and the firings in order.

use config::NetConfig;
use coordination::petri::PlaceKind;

use crate::summary::CoordinationSummary;

use super::html::{Cell, Page, quantity, short_time};
use super::net;
use super::view::{View, cast};

/// Runs whose firings are listed, firings that are listed of each, and runs that are drawn of each net.
const MOST_LISTED: usize = 40;
const MOST_FIRINGS: usize = 200;
const MOST_DRAWN: usize = 3;
/// Times of firings are told in milliseconds.
const FINEST_MS: f64 = 0.5;

/// Writes the section; returns the number of the next figure.
pub(super) fn write(page: &mut Page, view: &View<'_>, mut figure: usize) -> usize {
    let (nets, coordinations) = (&view.record.nets, &view.record.summary.coordinations);
    if nets.is_empty() && coordinations.is_empty() {
        return figure;
    }
    page.element("h2", "Coordinations");
    summary(page, view);
    for net in nets {
        let runs: Vec<&CoordinationSummary> = { coordinations.iter() }
            .filter(|run| run.net == net.name)
            .collect();
        // One run for each situation in which it began; a run that came to its end says more.
        let mut drawn: Vec<&CoordinationSummary> = Vec::new();
        let ended = runs.iter().filter(|run| run.duration_s.is_some());
        for run in ended.chain(&runs) {
            if drawn.len() < MOST_DRAWN && !drawn.iter().any(|own| own.situation == run.situation) {
                drawn.push(run);
            }
        }
        page.element("h3", heading(net));
        if drawn.is_empty() {
            page.element("p class=\"bad\"", "It never ran.");
            let situation = net.situations.first().map_or("", |situation| &situation.id);
            draw(page, view, net, situation, None, &mut figure);
        }
        for run in &drawn {
            draw(page, view, net, &run.situation, Some(run), &mut figure);
        }
        meanings(page, net);
        let others = runs
            .iter()
            .filter(|run| !drawn.iter().any(|own| std::ptr::eq(*own, **run)));
        for run in others.clone().take(MOST_LISTED) {
            page.raw("<details>");
            page.element("summary", sentence(view, run));
            firings(page, net, run);
            page.raw("</details>\n");
        }
        let unlisted = others.count().saturating_sub(MOST_LISTED);
        if unlisted > 0 {
            page.element(
                "p class=\"soft\"",
                format!("{unlisted} more runs are in summary.json."),
            );
        }
    }
    figure
}

fn heading(net: &NetConfig) -> String {
    match &net.about {
        Some(about) => format!("Net {}: {about}", net.name),
        None => format!("Net {}", net.name),
    }
}

/// One row for each run.
fn summary(page: &mut Page, view: &View<'_>) {
    let rows: Vec<Vec<Cell>> = view
        .record
        .summary
        .coordinations
        .iter()
        .take(MOST_LISTED)
        .map(|run| {
            vec![
                Cell::new(run.number),
                Cell::new(&run.id),
                Cell::new(&run.net),
                Cell::new(if run.situation.is_empty() {
                    "getting out of the way"
                } else {
                    &run.situation
                }),
                Cell::new(cast(run)),
                Cell::new(quantity(run.from_s, 1, "s")),
                Cell::new(quantity(run.duration_s, 1, "s")),
                Cell::new(run.firings.len()),
                Cell::new(if run.duration_s.is_some() {
                    "over".to_owned()
                } else {
                    run.marking.join(", ")
                })
                .long(),
            ]
        })
        .collect();
    if rows.is_empty() {
        page.element("p", "None began.");
        return;
    }
    page.table(
        &[
            "number",
            "<coordination",
            "<net",
            "<situation",
            "<robots",
            "began",
            "took",
            "firings",
            "<at the end",
        ],
        &rows,
    );
}

fn sentence(view: &View<'_>, run: &CoordinationSummary) -> String {
    let how = match run.duration_s {
        Some(duration_s) => format!("took {}", quantity(duration_s, 1, "s")),
        None => format!("was not over at {}", quantity(view.end_s, 1, "s")),
    };
    let situation = if run.situation.is_empty() {
        String::new()
    } else {
        format!(" in situation {}", run.situation)
    };
    format!(
        "Coordination {} ({}){situation}, {}: began at {} and {how}; {} firings.",
        run.number,
        run.id,
        cast(run),
        quantity(run.from_s, 1, "s"),
        run.firings.len()
    )
}

fn draw(
    page: &mut Page,
    view: &View<'_>,
    net: &NetConfig,
    situation: &str,
    run: Option<&CoordinationSummary>,
    figure: &mut usize,
) {
    page.raw("<div class=\"net\">\n");
    match net::draw(view, net, situation, run) {
        Some(drawing) => {
            let shown = run.map_or_else(
                || format!("The net as it would begin in situation {situation}."),
                |run| sentence(view, run),
            );
            let caption = format!(
                "Figure {figure}. {shown} Circles are places, with a dot where the initial marking has a token; bars are \
                 transitions with the numbers of their firings and the times in the run. Filled: flags that a robot sets \
                 (sources); ringed: flags that the mediator sets (sinks); both in the colour of the robot that plays the \
                 role. Pale: never fired. An arrow at both ends: the token is put back."
            );
            page.figure(&drawing, &caption);
            *figure += 1;
        }
        None => page.element(
            "p class=\"soft\"",
            format!(
                "The net is too large to be drawn here ({} places, {} transitions): mediator show writes it for Graphviz.",
                net.places.len(),
                net.transitions.len()
            ),
        ),
    }
    if let Some(run) = run {
        page.raw("<div>");
        firings(page, net, run);
        page.raw("</div>");
    }
    page.raw("</div>\n");
}

/// The firings of a run in order.
fn firings(page: &mut Page, net: &NetConfig, run: &CoordinationSummary) {
    let mut before_s = run.from_s;
    let rows: Vec<Vec<Cell>> = run
        .firings
        .iter()
        .take(MOST_FIRINGS)
        .enumerate()
        .map(|(index, firing)| {
            let (id, at_s) = (&firing.transition, firing.at_s);
            let after_ms = (at_s - before_s) * 1e3;
            before_s = at_s;
            let transition = net.transitions.iter().find(|own| &own.id == id);
            let events = |ids: Option<&Vec<String>>, kind: PlaceKind| {
                let names: Vec<String> = ids
                    .into_iter()
                    .flatten()
                    .filter_map(|id| net.place(id))
                    .filter(|place| place.kind == kind)
                    .map(|place| {
                        place
                            .binding
                            .as_ref()
                            .map_or_else(|| place.id.clone(), |own| own.event_name())
                    })
                    .collect();
                names.join(", ")
            };
            vec![
                Cell::new(index + 1),
                Cell::new(id),
                Cell::new(quantity(at_s, 3, "s")),
                Cell::new(if after_ms.abs() < FINEST_MS {
                    quantity(0.0, 0, "ms")
                } else {
                    short_time(after_ms)
                }),
                Cell::new(events(transition.map(|own| &own.from), PlaceKind::Source)),
                Cell::new(events(transition.map(|own| &own.to), PlaceKind::Sink)),
            ]
        })
        .collect();
    page.table(
        &[
            "#",
            "<transition",
            "fired at",
            "after",
            "<told by robots",
            "<told to robots",
        ],
        &rows,
    );
    let unlisted = run.firings.len().saturating_sub(MOST_FIRINGS);
    if unlisted > 0 {
        page.element(
            "p class=\"soft\"",
            format!("{unlisted} more firings are in summary.json."),
        );
    }
}

/// What a token in each place means.
fn meanings(page: &mut Page, net: &NetConfig) {
    page.raw("<details>");
    page.element("summary", "What a token in each place means");
    let rows: Vec<Vec<Cell>> = net
        .places
        .iter()
        .filter(|place| place.kind == PlaceKind::Internal)
        .map(|place| vec![Cell::new(&place.id), Cell::new(&place.about).long()])
        .collect();
    page.table(&["<place", "<meaning"], &rows);
    page.raw("</details>\n");
}
