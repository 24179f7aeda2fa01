//! What comes first: outcome, seed, duration, machine, and what went wrong, in words.

use crate::stalls::Stalls;
use crate::summary::{Spoiled, Violation};

use super::html::{Page, quantity};
use super::view::View;

/// Violations that are written out.
const MOST_VIOLATIONS: usize = 40;

/// Writes it.
pub(super) fn write(page: &mut Page, view: &View<'_>) {
    let (record, summary) = (view.record, &view.record.summary);
    page.raw("<header>\n<div class=\"top\">");
    page.element("h1", title(view));
    let class = if summary.passed() {
        "span class=\"badge well\""
    } else {
        "span class=\"badge\""
    };
    page.element(class, summary.outcome.clone() + &summary.with_violations());
    page.raw("</div>\n");
    if !record.about.is_empty() {
        page.element("p class=\"soft\"", &record.about);
    }
    page.raw("<dl class=\"facts\">\n");
    let coordinations = &summary.coordinations;
    let ended = coordinations.iter().filter(|run| run.duration_s.is_some());
    let firings: usize = coordinations.iter().map(|run| run.firings.len()).sum();
    let machine = &summary.machine;
    let stalled = |stalls: &Stalls| {
        // With what else counts it is a sentence.
        let class = if stalls.without_priority { "long" } else { "" };
        ("machine stalled", stalls.in_words(), class)
    };
    let spoiled = |spoiled: &Spoiled| {
        let value = format!("{} ({})", spoiled.reason, spoiled.stalls);
        ("made once more, as spoiled before", value, "long")
    };
    let facts = [
        ("duration", quantity(summary.duration_s, 1, "s"), ""),
        ("seed", summary.seed.to_string(), ""),
        ("robots", record.robots.len().to_string(), ""),
        ("grants of areas", record.holdings.len().to_string(), ""),
        (
            "coordinations run to their end",
            format!("{} of {}", ended.count(), coordinations.len()),
            "",
        ),
        ("firings", firings.to_string(), ""),
        (
            "violations",
            summary.violations.len().to_string(),
            if summary.violations.is_empty() {
                ""
            } else {
                "bad"
            },
        ),
        (
            "machine",
            format!(
                "{}, {} cores, Linux {}",
                machine.processor, machine.cores, machine.kernel
            ),
            "long",
        ),
    ];
    for (name, value, class) in { facts.into_iter() }
        .chain(summary.stalls.as_ref().map(stalled))
        .chain(summary.spoiled.as_ref().map(spoiled))
    {
        page.raw("<div>");
        page.element("dt", name);
        page.element(&format!("dd class=\"{class}\""), value);
        page.raw("</div>\n");
    }
    page.raw("</dl>\n</header>\n");
    violations(page, &summary.violations);
    during(page, view);
    incidents(page, view);
}

/// The page's name.
pub(super) fn title(view: &View<'_>) -> String {
    let (scenario, site) = (&view.record.summary.scenario, &view.record.site.name);
    if scenario == site {
        scenario.clone()
    } else {
        format!("{scenario} in {site}")
    }
}

fn violations(page: &mut Page, violations: &[Violation]) {
    if violations.is_empty() {
        return;
    }
    page.element("h2", "What went wrong");
    page.raw("<ul class=\"wrong\">\n");
    for violation in violations.iter().take(MOST_VIOLATIONS) {
        page.raw("<li>");
        let who = if violation.robot.is_empty() {
            String::new()
        } else {
            format!(", {}", violation.robot)
        };
        page.element("b", violation.kind.name().replace('-', " "));
        page.element(
            "span",
            format!(
                "at {}{who}: {}",
                quantity(violation.at_s, 1, "s"),
                violation.detail
            ),
        );
        page.raw("</li>\n");
    }
    page.raw("</ul>\n");
    if let Some(more) = violations
        .len()
        .checked_sub(MOST_VIOLATIONS)
        .filter(|&more| more > 0)
    {
        page.element(
            "p class=\"bad\"",
            format!("and {more} more: see summary.json"),
        );
    }
}

/// What had to be true while something else was.
fn during(page: &mut Page, view: &View<'_>) {
    for check in &view.record.summary.during {
        let checked = quantity(check.checked_s, 1, "s");
        let (class, text) = match (check.checked_s > 0.0, check.broken_s > 0.0) {
            (false, _) => (
                "p class=\"bad\"",
                "this never came to be checked".to_owned(),
            ),
            (true, false) => (
                "p",
                format!("true throughout the {checked} in which it had to be"),
            ),
            (true, true) => (
                "p class=\"bad\"",
                format!(
                    "not true for {} of {checked}",
                    quantity(check.broken_s, 1, "s")
                ),
            ),
        };
        page.element(class, format!("{}: {text}.", check.rule));
    }
}

/// What was done to the run.
fn incidents(page: &mut Page, view: &View<'_>) {
    if view.record.incidents.is_empty() {
        return;
    }
    let told: Vec<String> = view
        .record
        .incidents
        .iter()
        .map(|incident| format!("{} ({})", incident.what, quantity(incident.at_s, 1, "s")))
        .collect();
    page.element("p", format!("Done to the run: {}.", told.join("; ")));
}
