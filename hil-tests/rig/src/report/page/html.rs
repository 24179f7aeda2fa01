//! Pieces of HTML: text, tables, numbers with units.

use std::fmt::{Display, Write};

use crate::report::draw::canvas::Escaped;

/// Between a number and its unit.
const NARROW: char = '\u{a0}';

/// The page as it grows. Tags are written as they are, texts are escaped.
#[derive(Debug, Default)]
pub(super) struct Page {
    pub(super) text: String,
}

impl Page {
    /// Markup of this module's own.
    pub(super) fn raw(&mut self, markup: &str) {
        self.text.push_str(markup);
    }

    /// An element with a text in it; `open` is its name and its attributes.
    pub(super) fn element(&mut self, open: &str, text: impl Display) {
        let name = open.split(' ').next().unwrap_or(open);
        let text = text.to_string();
        // Writing to a string cannot fail.
        let _ = writeln!(self.text, "<{open}>{}</{name}>", Escaped(&text));
    }

    /// A table; columns whose heading begins with `<` stand to the left, `w` columns may break lines.
    pub(super) fn table(&mut self, headings: &[&str], rows: &[Vec<Cell>]) {
        self.raw("<div class=\"scroll\"><table>\n<thead><tr>");
        for heading in headings {
            let (class, heading) = match heading.strip_prefix('<') {
                Some(heading) => (" class=\"l\"", heading),
                None => ("", *heading),
            };
            let _ = write!(self.text, "<th{class}>{}</th>", Escaped(heading));
        }
        self.raw("</tr></thead>\n<tbody>\n");
        for row in rows {
            self.raw("<tr>");
            for (cell, heading) in row.iter().zip(headings) {
                let left = heading.starts_with('<');
                cell.write(&mut self.text, left);
            }
            self.raw("</tr>\n");
        }
        self.raw("</tbody></table></div>\n");
    }

    /// A drawing with what it shows.
    pub(super) fn figure(&mut self, drawing: &str, caption: &str) {
        self.raw("<figure>\n");
        self.raw(drawing);
        self.element("figcaption", caption);
        self.raw("</figure>\n");
    }
}

/// A cell of a table.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    text: String,
    /// Class of the colour that stands before the text.
    swatch: Option<String>,
    bad: bool,
    long: bool,
}

impl Cell {
    pub(super) fn new(text: impl Display) -> Self {
        Self {
            text: text.to_string(),
            swatch: None,
            bad: false,
            long: false,
        }
    }

    /// Marks it as wrong if `bad`.
    pub(super) fn bad(mut self, bad: bool) -> Self {
        self.bad = bad;
        self
    }

    /// It may need several lines.
    pub(super) fn long(mut self) -> Self {
        self.long = true;
        self
    }

    /// With a colour before the text.
    pub(super) fn swatch(mut self, class: String) -> Self {
        self.swatch = Some(class);
        self
    }

    fn write(&self, page: &mut String, left: bool) {
        let classes: Vec<&str> = [(left, "l"), (self.bad, "bad"), (self.long, "w")]
            .into_iter()
            .filter_map(|(is, class)| is.then_some(class))
            .collect();
        // Writing to a string cannot fail.
        let _ = match classes.is_empty() {
            true => write!(page, "<td>"),
            false => write!(page, "<td class=\"{}\">", classes.join(" ")),
        };
        if let Some(class) = &self.swatch {
            let _ = write!(page, "<span class=\"sw {class}\"></span>");
        }
        let _ = write!(page, "{}</td>", Escaped(&self.text));
    }
}

/// A number with its unit, or a dash.
pub(super) fn quantity(value: impl Into<Option<f64>>, digits: usize, unit: &str) -> String {
    match value.into() {
        Some(value) if value.is_finite() => {
            // Adding 0 turns -0 into 0.
            format!("{:.digits$}{NARROW}{unit}", value + 0.0).replace('-', "−")
        }
        _ => "–".to_owned(),
    }
}

/// A time in milliseconds, in the unit that fits its size, with three digits.
pub(super) fn short_time(value_ms: impl Into<Option<f64>>) -> String {
    let Some(value_ms) = value_ms.into().filter(|value| value.is_finite()) else {
        return "–".to_owned();
    };
    let (value, unit) = match value_ms.abs() {
        size if size < 0.9995 => (value_ms * 1e3, "µs"),
        size if size < 999.5 => (value_ms, "ms"),
        _ => (value_ms / 1e3, "s"),
    };
    let digits = match value.abs() {
        size if size < 9.995 => 2,
        size if size < 99.95 => 1,
        _ => 0,
    };
    quantity(value, digits, unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_three_digits_and_a_unit_that_fits() {
        let texts = [0.0123, 0.9999, 4.567, 12.34, 5_600.0].map(short_time);
        let wanted = ["12.3 µs", "1.00 ms", "4.57 ms", "12.3 ms", "5.60 s"];
        assert_eq!(texts, wanted.map(|text| text.replace(' ', "\u{a0}")));
        assert_eq!(short_time(f64::NAN), "–");
        assert_eq!(quantity(None, 1, "m"), "–");
        assert_eq!(quantity(-0.04, 1, "m"), "−0.0\u{a0}m");
    }

    #[test]
    fn text_is_escaped_and_marked() {
        let mut page = Page::default();
        page.table(
            &["<a", "b"],
            &[vec![
                Cell::new("<&").swatch("r1".to_owned()),
                Cell::new(1).bad(true).long(),
            ]],
        );
        assert!(page.text.contains("<th class=\"l\">a</th><th>b</th>"));
        assert!(
            page.text
                .contains("<td class=\"l\"><span class=\"sw r1\"></span>&lt;&amp;</td>")
        );
        assert!(page.text.contains("<td class=\"bad w\">1</td>"));
    }
}
