//! The page from top to bottom.

use std::fmt::Write;

use crate::record::Record;
use crate::report::draw::canvas::Escaped;
use crate::report::drive::drive_svg;

use super::html::Page;
use super::view::View;
use super::{
    floorplan, frames, headline, keys, nets, spacetime as spacetimes, style, tables,
    timing as timings,
};

/// Largest size of a report.
#[cfg(test)]
pub(super) const LARGEST_BYTES: usize = 3_000_000;

/// The page of one run.
#[must_use]
pub fn html(record: &Record) -> String {
    let view = View::new(record);
    let (rules, patterns) = style::colours();
    let mut page = Page::default();
    page.raw(&format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>\
         <meta name=\"viewport\" content=\"width=device-width\"/><title>{}</title>\n\
         <style>\n{}{rules}</style></head>\n<body>\n\
         <svg width=\"0\" height=\"0\" style=\"position:absolute\" aria-hidden=\"true\"><defs>\n{patterns}</defs></svg>\n",
        Escaped(&headline::title(&view)),
        style::STYLE,
    ));
    headline::write(&mut page, &view);
    tables::robots(&mut page, &view);
    tables::figures(&mut page, &view);
    let mut figure = 1;
    match drive_svg(record).filter(|_| !record.site.areas_managed) {
        Some(svg) => drive(&mut page, &svg, &mut figure),
        None => places(&mut page, &view, &mut figure),
    }
    if record.site.areas_managed {
        spacetime(&mut page, &view, &mut figure);
    }
    figure = nets::write(&mut page, &view, figure);
    timing(&mut page, &view, figure);
    page.raw("</body></html>\n");
    page.text
}

/// The way of a robot that was alone. As a picture, since its style must not mix with that of the page.
fn drive(page: &mut Page, svg: &str, figure: &mut usize) {
    page.element("h2", "How the robot drove");
    let mut picture = String::from("<img alt=\"way of the robot\" src=\"data:image/svg+xml,");
    for byte in svg.bytes() {
        // Writing to a string cannot fail.
        let _ = match byte {
            b'a'..=b'z'
            | b'A'..=b'Z'
            | b'0'..=b'9'
            | b' '
            | b'.'
            | b','
            | b'-'
            | b'='
            | b'/'
            | b':' => {
                write!(picture, "{}", char::from(byte))
            }
            _ => write!(picture, "%{byte:02x}"),
        };
    }
    picture.push_str("\" style=\"max-width:100%\"/>\n");
    let caption = format!(
        "Figure {figure}. The way of the robot, its speed, clearance and place on the lane, by the world's truth; report.svg \
         is the same drawing."
    );
    page.figure(&picture, &caption);
    *figure += 1;
}

/// Where everybody was.
fn places(page: &mut Page, view: &View<'_>, figure: &mut usize) {
    page.element("h2", "Where the robots were");
    keys::robots(page, view);
    let (drawing, step_s) = floorplan::draw(view);
    page.figure(
        &drawing,
        &format!(
            "Figure {figure}. Where base_link truly was; marks along the paths every {step_s} s, with the time since the \
             first robot's start in seconds. Where paths lie on one another, the wider one is underneath. Dashed \
             outlines: starts; filled: ends; pale: in between. A dot: it stood there for 3 s or more. Red rings: \
             something went wrong."
        ),
    );
    *figure += 1;
    if frames::write(page, view, *figure) {
        *figure += 1;
    }
}

/// Which robot had which area when.
fn spacetime(page: &mut Page, view: &View<'_>, figure: &mut usize) {
    page.element("h2", "Who had which area");
    keys::robots(page, view);
    keys::signs(page, view);
    let managed = match view.record.mediator.len() {
        0 => " No mediator ran.",
        1 => "",
        _ => " Red ground: no mediator ran.",
    };
    page.figure(
        &spacetimes::draw(view),
        &format!(
            "Figure {figure}. Areas and their owners, as an independent listener heard them; areas that hold several \
             robots have a line for each. Coordinations reach across. Below: true speed and the state of each robot's \
             machine. Red lines: something went wrong; grey lines: something was done to the run.{managed}"
        ),
    );
    *figure += 1;
    tables::areas(page, view);
}

/// How fast all went.
fn timing(page: &mut Page, view: &View<'_>, figure: usize) {
    page.element("h2", "Timing");
    let alone = view.record.robots.len() == 1;
    if alone && !view.record.site.areas_managed {
        threads(page, view, figure);
        return;
    }
    let caption = format!(
        "Figure {figure}. Latencies as an independent listener heard both ends; logarithmic axes. Bars count measurements."
    );
    page.figure(&timings::histograms(view), &caption);
    tables::latencies(page, view);
    threads(page, view, figure + 1);
}

/// How regularly threads ran.
fn threads(page: &mut Page, view: &View<'_>, figure: usize) {
    if let Some(drawing) = timings::threads(view) {
        let caption = format!(
            "Figure {figure}. Every thread as its robot measured it; logarithmic axes. Solid: from the median to the 99th \
             percentile; paler: to the 99.9th; line and ring: to the largest. A thread that wakes on data has no wake-up \
             latency."
        );
        page.figure(&drawing, &caption);
    }
    tables::threads(page, view);
}
