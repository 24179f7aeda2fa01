//! SVG text: elements, numbers, escapes.

use std::fmt::{self, Write};

use super::sheet::WIDTH_PX;

/// A place on the page in pixels, y down.
pub(in crate::report) type Px2 = [f64; 2];

/// Style of everything, by class. Sizes of text that is measured stand in [`super::labels`].
const STYLE: &str = "\
text{font-family:'Helvetica Neue',Arial,'DejaVu Sans',sans-serif;font-size:13px;fill:#334155}
.h{font-size:27px;font-weight:700;fill:#0f172a}.sub{font-size:15px;fill:#64748b}
.k{font-size:13px;fill:#64748b}.v{font-size:23px;font-weight:600;fill:#0f172a}
.badge{font-size:16px;font-weight:700;fill:#fff}.bad{fill:#dc2626}.good{fill:#15803d}
.tick{font-size:12px;fill:#64748b}.axis{font-size:13px;fill:#475569}.cap{font-size:14px;font-weight:600}
.m{text-anchor:middle}.e{text-anchor:end}.b{font-weight:700}
.id{font-size:20px;font-weight:700;fill:#475569}.note{font-size:12px;fill:#64748b}
.frame{fill:none;stroke:#cbd5e1}.grid{stroke:#e2e8f0}.mark{stroke:#94a3b8}
.area{stroke:#94a3b8;stroke-width:.8}.zone{fill:none;stroke:#94a3b8;stroke-dasharray:2 4}
.thing{fill:#78716c;fill-opacity:.35;stroke:#57534e;stroke-width:1.5}
.wall{stroke:#1e293b;stroke-width:5;stroke-linecap:round}
.scale{stroke:#1e293b;stroke-width:2.5;stroke-linecap:round}
.lane{stroke:#94a3b8;stroke-width:1.2;stroke-dasharray:9 5}.arrow{fill:none;stroke:#64748b;stroke-width:1.6}
.path{fill:none;stroke-width:3;stroke-linejoin:round;stroke-linecap:round}
.wrong{fill:none;stroke:#dc2626;stroke-width:3;stroke-linecap:round}
.ghost{fill:#334155;fill-opacity:.04;stroke:#334155;stroke-opacity:.3}
.start{fill:#fff;fill-opacity:.4;stroke:#0f172a;stroke-width:1.6;stroke-dasharray:4 2}
.end{fill:#0f172a;fill-opacity:.35;stroke:#0f172a;stroke-width:1.8}
.dot{fill:#0f172a;stroke:#fff;stroke-width:1.2}.later{fill:#0f172a;fill-opacity:.55}
.pill{fill:#fff;fill-opacity:.93;stroke:#475569}.lead{stroke:#475569}
.hit{fill:#fff;fill-opacity:.6;stroke:#dc2626;stroke-width:2.5}
.curve{fill:none;stroke:#1d4ed8;stroke-width:1.5;stroke-linejoin:round;stroke-linecap:round}
.over{fill:none;stroke:#dc2626;stroke-width:2.2;stroke-linejoin:round;stroke-linecap:round}
.limit{fill:none;stroke:#64748b;stroke-dasharray:6 4}.ban{stroke:#dc2626;stroke-dasharray:6 4}
.forbidden{fill:#dc2626;fill-opacity:.07}.when{stroke:#dc2626;stroke-width:1.3}
";

/// The page as it grows.
#[derive(Debug, Default)]
pub(in crate::report) struct Canvas {
    body: String,
}

impl Canvas {
    /// An element without content. Attributes must hold nothing but numbers and names of this module's own.
    pub(in crate::report) fn element(&mut self, name: &str, attributes: fmt::Arguments<'_>) {
        self.write(format_args!("<{name} {attributes}/>\n"));
    }

    /// The same with a text that browsers show over it.
    pub(in crate::report) fn element_with_hint(
        &mut self,
        name: &str,
        attributes: fmt::Arguments<'_>,
        hint: &str,
    ) {
        let hint = Escaped(hint);
        self.write(format_args!(
            "<{name} {attributes}><title>{hint}</title></{name}>\n"
        ));
    }

    /// Opens an element, to be closed by [`close`](Self::close).
    pub(in crate::report) fn open(&mut self, name: &str, attributes: fmt::Arguments<'_>) {
        self.write(format_args!("<{name} {attributes}>\n"));
    }

    /// Closes an element.
    pub(in crate::report) fn close(&mut self, name: &str) {
        self.write(format_args!("</{name}>\n"));
    }

    /// A line of text; the class says how it looks and which end stands at `at`.
    pub(in crate::report) fn text(&mut self, class: &str, at: Px2, text: &str) {
        let (x, y, text) = (Px(at[0]), Px(at[1]), Escaped(text));
        self.write(format_args!(
            "<text class=\"{class}\" x=\"{x}\" y=\"{y}\">{text}</text>\n"
        ));
    }

    /// A number in bold and a name, either of which may be empty.
    pub(in crate::report) fn numbered_text(
        &mut self,
        class: &str,
        at: Px2,
        number: &str,
        name: &str,
    ) {
        let ([x, y], number, gap) = (
            at.map(Px),
            Escaped(number),
            if number.is_empty() { "" } else { " " },
        );
        let name = Escaped(name);
        self.write(format_args!(
            "<text class=\"{class}\" x=\"{x}\" y=\"{y}\"><tspan class=\"b\">{number}</tspan>{gap}{name}</text>\n"
        ));
    }

    /// A straight line.
    pub(in crate::report) fn line(&mut self, class: &str, from: Px2, to: Px2) {
        let [x1, y1, x2, y2] = [from[0], from[1], to[0], to[1]].map(Px);
        self.element(
            "line",
            format_args!("class=\"{class}\" x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\""),
        );
    }

    /// A disc.
    pub(in crate::report) fn circle(&mut self, class: &str, at: Px2, radius_px: f64) {
        let [x, y, r] = [at[0], at[1], radius_px].map(Px);
        self.element(
            "circle",
            format_args!("class=\"{class}\" cx=\"{x}\" cy=\"{y}\" r=\"{r}\""),
        );
    }

    /// A rectangle: left, top, width and height.
    pub(in crate::report) fn rect(&mut self, attributes: &str, place: [f64; 4]) {
        let [x, y, width, height] = place.map(Px);
        self.element(
            "rect",
            format_args!("{attributes} x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\""),
        );
    }

    /// The same with a text that browsers show over it.
    pub(in crate::report) fn rect_with_hint(
        &mut self,
        attributes: &str,
        place: [f64; 4],
        hint: &str,
    ) {
        let [x, y, width, height] = place.map(Px);
        self.element_with_hint(
            "rect",
            format_args!("{attributes} x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\""),
            hint,
        );
    }

    /// Opens a group in which nothing leaves these rectangles.
    pub(in crate::report) fn open_clipped(&mut self, id: &str, places: &[[f64; 4]]) {
        self.open("clipPath", format_args!("id=\"{id}\""));
        for place in places {
            self.rect("", *place);
        }
        self.close("clipPath");
        self.open("g", format_args!("clip-path=\"url(#{id})\""));
    }

    /// A curve; none if it holds nothing.
    pub(in crate::report) fn curve(&mut self, attributes: &str, curve: &Curve) {
        if !curve.data.is_empty() {
            let data = &curve.data;
            self.element("path", format_args!("{attributes} d=\"{data}\""));
        }
    }

    /// The whole file.
    pub(in crate::report) fn finish(self, height_px: f64, title: &str) -> String {
        let (width, height) = (Px(WIDTH_PX), Px(height_px));
        let (title, body) = (Escaped(title), &self.body);
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
             <svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\">\n<title>{title}</title>\n<style>\n{STYLE}</style>\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n{body}</svg>\n"
        )
    }

    /// A drawing as part of a page that has its own style: with what is said of it to those who cannot see it.
    pub(in crate::report) fn finish_inline(self, class: &str, size_px: Px2, label: &str) -> String {
        let ([width, height], label) = (size_px.map(Px), Escaped(label));
        let body = &self.body;
        format!(
            "<svg class=\"{class}\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
             role=\"img\" aria-label=\"{label}\">\n{body}</svg>\n"
        )
    }

    fn write(&mut self, text: fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.body.write_fmt(text);
    }
}

/// Data of a `path` element.
#[derive(Debug, Default)]
pub(in crate::report) struct Curve {
    data: String,
}

impl Curve {
    /// Begins a piece.
    pub(in crate::report) fn move_to(&mut self, at: Px2) {
        self.push('M', at);
    }

    /// Goes on straight.
    pub(in crate::report) fn line_to(&mut self, at: Px2) {
        self.push('L', at);
    }

    /// Goes on straight up or down.
    pub(in crate::report) fn vertical_to(&mut self, y_px: f64) {
        // Writing to a string cannot fail.
        let _ = write!(self.data, "V{}", Px(y_px));
    }

    /// Goes on in a bend that begins and ends upright.
    pub(in crate::report) fn bend_to(&mut self, from: Px2, to: Px2) {
        let middle = (from[1] + to[1]) / 2.0;
        self.bezier_to([from[0], middle], [to[0], middle], to);
    }

    /// Goes on in a bend that begins and ends level.
    pub(in crate::report) fn lean_to(&mut self, from: Px2, to: Px2) {
        let middle = (from[0] + to[0]) / 2.0;
        self.bezier_to([middle, from[1]], [middle, to[1]], to);
    }

    fn bezier_to(&mut self, first: Px2, second: Px2, to: Px2) {
        self.push('C', first);
        self.push(' ', second);
        self.push(' ', to);
    }

    /// A piece with straight lines from point to point.
    pub(in crate::report) fn along(&mut self, points: impl IntoIterator<Item = Px2>) {
        for (index, at) in points.into_iter().enumerate() {
            self.push(if index == 0 { 'M' } else { 'L' }, at);
        }
    }

    /// Goes back to where the piece began.
    pub(in crate::report) fn close(&mut self) {
        self.data.push('Z');
    }

    fn push(&mut self, command: char, at: Px2) {
        // Writing to a string cannot fail.
        let _ = write!(self.data, "{command}{},{}", Px(at[0]), Px(at[1]));
    }
}

/// A number of pixels, to a tenth; what is no number becomes 0, so that a file is always a drawing.
#[derive(Clone, Copy, Debug)]
pub(in crate::report) struct Px(pub(in crate::report) f64);

impl fmt::Display for Px {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        const FARTHEST: f64 = 1e6;
        let finite = if self.0.is_nan() { 0.0 } else { self.0 };
        // Adding 0 turns -0 into 0.
        let tenths = (finite.clamp(-FARTHEST, FARTHEST) * 10.0).round() + 0.0;
        if tenths % 10.0 == 0.0 {
            write!(formatter, "{:.0}", tenths / 10.0)
        } else {
            write!(formatter, "{:.1}", tenths / 10.0)
        }
    }
}

/// Text as XML takes it; characters that XML cannot hold are replaced.
#[derive(Clone, Copy, Debug)]
pub(in crate::report) struct Escaped<'a>(pub(in crate::report) &'a str);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for character in self.0.chars() {
            match character {
                '&' => formatter.write_str("&amp;")?,
                '<' => formatter.write_str("&lt;")?,
                '>' => formatter.write_str("&gt;")?,
                '"' => formatter.write_str("&quot;")?,
                '\'' => formatter.write_str("&apos;")?,
                '\t' | '\n' | '\r' => formatter.write_char(' ')?,
                '\0'..='\u{1f}' | '\u{7f}'..='\u{9f}' | '\u{fffe}' | '\u{ffff}' => {
                    formatter.write_char(char::REPLACEMENT_CHARACTER)?;
                }
                other => formatter.write_char(other)?,
            }
        }
        Ok(())
    }
}

/// The text cut to a number of characters; an ellipsis stands for what was cut.
pub(in crate::report) fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    let kept: String = text.chars().take(most.saturating_sub(1)).collect();
    format!("{}…", kept.trim_end())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_always_numbers() {
        let text = |value: f64| Px(value).to_string();
        assert_eq!(
            [text(12.0), text(12.34), text(-0.01), text(f64::NAN)],
            ["12", "12.3", "0", "0"]
        );
        assert_eq!([text(f64::INFINITY), text(-1e300)], ["1000000", "-1000000"]);
    }

    #[test]
    fn what_xml_cannot_hold_is_escaped_or_replaced() {
        let text = Escaped("a<b & \"c\" > 'd'\u{1b}\n\u{ffff}é").to_string();
        assert_eq!(
            text,
            "a&lt;b &amp; &quot;c&quot; &gt; &apos;d&apos;\u{fffd} \u{fffd}é"
        );
    }

    #[test]
    fn long_text_ends_in_an_ellipsis() {
        assert_eq!(shortened("short", 5), "short");
        assert_eq!(shortened("much longer", 6), "much…");
    }
}
