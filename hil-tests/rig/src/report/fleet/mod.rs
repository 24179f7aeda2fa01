//! `report.html` of a scenario with a fleet: one file that needs nothing else, for people to look at.
//!
//! Paths are the world's truth, areas and their owners what an independent listener heard, firings the mediator's own
//! word. Each robot has one colour throughout. The page reads in light, in dark and on paper; however long the run
//! was, it stays under [`LARGEST_BYTES`], because curves are thinned to what can be seen.

mod floorplan;
mod frames;
mod headline;
mod html;
mod keys;
mod lanes;
mod layers;
mod net;
mod nets;
mod spacetime;
mod style;
mod tables;
mod timing;
mod view;

#[cfg(test)]
mod tests;

use crate::record::Record;

use super::canvas::Escaped;
use html::Page;
use view::View;

/// What a report stays under.
pub const LARGEST_BYTES: usize = 3_000_000;

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
    let mut figure = 1;
    places(&mut page, &view, &mut figure);
    spacetime(&mut page, &view, &mut figure);
    figure = nets::write(&mut page, &view, figure);
    timing(&mut page, &view, figure);
    page.raw("</body></html>\n");
    page.text
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

/// Who had what when.
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
        &spacetime::draw(view),
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
    let caption = format!(
        "Figure {figure}. Latencies as an independent listener heard both ends; logarithmic axes. Bars count measurements."
    );
    page.figure(&timing::histograms(view), &caption);
    tables::latencies(page, view);
    if let Some(drawing) = timing::threads(view) {
        let caption = format!(
            "Figure {}. Every thread as its robot measured it; logarithmic axes. Solid: from the median to the 99th \
             percentile; paler: to the 99.9th; line and ring: to the largest. A thread that wakes on data has no wake-up \
             latency.",
            figure + 1
        );
        page.figure(&drawing, &caption);
    }
    tables::threads(page, view);
}
