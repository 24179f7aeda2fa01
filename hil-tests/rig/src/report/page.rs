//! `report.html`: the drawing and the figures of a run in one file that needs nothing else.

use std::fmt::Write;

use super::canvas::Escaped;
use crate::one_robot::summary::Summary;

const STYLE: &str = "body{font-family:Helvetica,Arial,sans-serif;margin:2em;color:#334155}\
svg{max-width:100%;height:auto}table{border-collapse:collapse}\
td,th{padding:.2em .8em;text-align:left;border-bottom:1px solid #e2e8f0;vertical-align:top}\
.bad{color:#dc2626}";

/// The page of one run; `svg` is its drawing.
#[must_use]
pub fn html(summary: &Summary, svg: &str) -> String {
    let title = Escaped(&summary.scenario);
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}</title>\
         <style>{STYLE}</style></head><body>\n<h1>{title}, seed {}: {}</h1>\n",
        summary.seed,
        Escaped(&summary.outcome)
    );
    // The drawing without its XML declaration, which has no place inside a page.
    let drawing = svg.find("<svg").map_or("", |at| &svg[at..]);
    page.push_str(drawing);
    // Writing to a string cannot fail.
    if !summary.violations.is_empty() {
        page.push_str("<h2 class=\"bad\">Violations</h2>\n<table>\n");
        for violation in &summary.violations {
            let _ = writeln!(
                page,
                "<tr><td>{:.1} s</td><td>{}</td><td>{}</td></tr>",
                violation.at_s,
                Escaped(&violation.kind),
                Escaped(&violation.detail)
            );
        }
        page.push_str("</table>\n");
    }
    if let Some(figures) = &summary.figures
        && let Ok(serde_json::Value::Object(figures)) = serde_json::to_value(figures)
    {
        page.push_str("<h2>Figures</h2>\n<table>\n");
        for (name, value) in figures {
            let value = value.to_string();
            let _ = writeln!(
                page,
                "<tr><th>{}</th><td>{}</td></tr>",
                Escaped(&name),
                Escaped(&value)
            );
        }
        page.push_str("</table>\n");
    }
    page.push_str("</body></html>\n");
    page
}
