//! What colours and signs mean, over the figures that use them.

use super::html::Page;
use super::view::View;
use crate::report::draw::canvas::Escaped;

/// One line with the robots' colours.
pub(super) fn robots(page: &mut Page, view: &View<'_>) {
    page.raw("<div class=\"keys\">");
    for robot in &view.record.robots {
        let (class, id, role) = (
            view.class(&robot.id),
            Escaped(&robot.id),
            Escaped(&robot.role),
        );
        page.raw(&format!(
            "<span class=\"{class}\"><i class=\"sw\"></i>{id} ({role})</span>"
        ));
    }
    page.raw("</div>\n");
}

/// One line with the signs of the space-time diagram.
pub(super) fn signs(page: &mut Page, view: &View<'_>) {
    let class = view
        .record
        .robots
        .first()
        .map_or_else(|| "neutral".to_owned(), |robot| view.class(&robot.id));
    page.raw("<div class=\"keys\">");
    let sign = |markup: &str| {
        format!(
            "<svg class=\"{class}\" width=\"34\" height=\"14\" aria-hidden=\"true\">{markup}</svg>"
        )
    };
    let bar = |class: &str, height: u32| {
        let y = (14 - height) / 2;
        format!("<rect class=\"{class}\" x=\"1\" y=\"{y}\" width=\"32\" height=\"{height}\"/>")
    };
    for (markup, name) in [
        (
            bar("ask", 7) + &bar("edge", 7),
            "asked for, not granted yet",
        ),
        (bar("hold", 13) + &bar("edge", 13), "granted, not entered"),
        (bar("own", 13), "in it"),
        (bar("bandbar", 13), "coordination; marks under it: firings"),
    ] {
        page.raw(&format!("<span>{}{}</span>", sign(&markup), Escaped(name)));
    }
    page.raw("</div>\n");
}
