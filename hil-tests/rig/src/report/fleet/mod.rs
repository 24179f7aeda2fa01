//! `report.html` of a scenario with a fleet: one file that needs nothing else, for people to look at.
//!
//! Paths are the world's truth, areas and their owners what an independent listener heard, firings the mediator's own
//! word. Each robot has one colour throughout. The page reads in light, in dark and on paper; however long the run
//! was, it stays under [`LARGEST_BYTES`], because curves are thinned to what can be seen.

mod floorplan;
mod frames;
mod headline;
mod html;
mod lanes;
mod layers;
mod net;
mod nets;
mod spacetime;
mod style;
mod tables;
mod view;

#[cfg(test)]
mod tests;

use crate::fleet::record::Record;

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
    tables::areas(&mut page, &view);
    let (drawing, step_s) = floorplan::draw(&view);
    page.figure(&drawing, &format!("{step_s}"));
    frames::write(&mut page, &view, 9);
    let drawing = spacetime::draw(&view);
    page.figure(&drawing, "Figure 2.");
    let _figure = nets::write(&mut page, &view, 3);
    tables::latencies(&mut page, &view);
    tables::threads(&mut page, &view);
    page.raw("</body></html>\n");
    page.text
}
