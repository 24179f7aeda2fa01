//! Nets as pictures: text for Graphviz's `dot`.

use alloc::boxed::Box;
use alloc::format;
use alloc::string::String;
use core::fmt::{self, Write};

use super::model::{Binding, NetModel, Place, PlaceKind, PlaceSet};

/// A net as DOT text, by [`Display`](fmt::Display).
///
/// Places are circles with a dot in those that are marked: internal ones white, sources dark, sinks
/// light, the last two with what they are bound to. Transitions are bars. Arcs that the model's
/// check refuses are left out. Not for real-time threads.
///
/// ```
/// use coordination::petri::{Binding, Dot, NetModel};
///
/// let mut model = NetModel::new("bell");
/// model.source("button", Binding::event("press")).sink("bell", Binding::event("ring"));
/// model.transition("pull", &["button"], &["bell"]);
///
/// let picture = Dot::new(&model).marking(|place| place == "button").to_string();
/// assert!(picture.starts_with("digraph \"bell\" {"));
/// assert!(picture.contains("\"button\" -> \"pull\";"));
/// ```
pub struct Dot<'a> {
    model: &'a NetModel,
    marked: Option<Box<Marked<'a>>>,
    note: Option<Box<Note<'a>>>,
}

type Marked<'a> = dyn Fn(&str) -> bool + 'a;
type Note<'a> = dyn Fn(&str) -> Option<&'a str> + 'a;

impl<'a> Dot<'a> {
    /// The net in its initial marking.
    #[must_use]
    pub fn new(model: &'a NetModel) -> Self {
        Self {
            model,
            marked: None,
            note: None,
        }
    }

    /// Shows another marking: whether the place of that name is marked.
    pub fn marking(mut self, marked: impl Fn(&str) -> bool + 'a) -> Self {
        self.marked = Some(Box::new(marked));
        self
    }

    /// Adds a tooltip to places and transitions by their names, for pictures in a browser.
    pub fn notes(mut self, note: impl Fn(&str) -> Option<&'a str> + 'a) -> Self {
        self.note = Some(Box::new(note));
        self
    }

    fn tooltip(&self, name: &str, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.note.as_ref().and_then(|note| note(name)) {
            Some(note) => write!(formatter, ", tooltip={}", Quoted(note)),
            None => Ok(()),
        }
    }

    fn place(&self, place: Place<'_>, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let marked = match &self.marked {
            Some(marked) => marked(place.name),
            None => place.marked,
        };
        // The token inside, the name and what it is bound to outside.
        let token = if marked { "&#9679;" } else { "" };
        let (fill, color) = match place.kind {
            PlaceKind::Internal => ("white", "black"),
            PlaceKind::Source => ("gray35", "white"),
            PlaceKind::Sink => ("gray85", "black"),
        };
        let bound = place.binding.map(|binding| match (place.kind, binding) {
            (PlaceKind::Sink, binding) => format!("{} →", shown(binding)),
            (_, binding) => format!("→ {}", shown(binding)),
        });
        write!(
            formatter,
            "  {} [shape=circle, label=\"{token}\", xlabel={}, fillcolor={fill}, fontcolor={color}",
            Quoted(place.name),
            Lines(place.name, bound.as_deref()),
        )?;
        self.tooltip(place.name, formatter)?;
        formatter.write_str("];\n")
    }
}

impl fmt::Display for Dot<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(formatter, "digraph {} {{", Quoted(self.model.name()))?;
        formatter.write_str("  rankdir=LR; forcelabels=true;\n")?;
        formatter.write_str("  node [style=filled, width=0.35, fixedsize=true, fontsize=10];\n")?;
        for place in self.model.places() {
            self.place(place, formatter)?;
        }
        for transition in self.model.transitions() {
            let name = Quoted(transition.name);
            write!(
                formatter,
                "  {name} [shape=box, width=0.12, height=0.5, label=\"\", xlabel={name}, fillcolor=black"
            )?;
            self.tooltip(transition.name, formatter)?;
            formatter.write_str("];\n")?;
            for place in transition.inputs {
                writeln!(formatter, "  {} -> {name};", Quoted(place))?;
            }
            for place in transition.outputs {
                writeln!(formatter, "  {name} -> {};", Quoted(place))?;
            }
        }
        for PlaceSet { name, places } in self.model.exclusions() {
            writeln!(
                formatter,
                "  // at most one of `{}`: {}",
                OneLine(name),
                Listed(&places)
            )?;
        }
        for PlaceSet { name, places } in self.model.ends() {
            writeln!(
                formatter,
                "  // end `{}`: {}",
                OneLine(name),
                Listed(&places)
            )?;
        }
        formatter.write_str("}\n")
    }
}

fn shown(binding: &Binding) -> String {
    match binding {
        Binding::Event(event) => format!("event {event}"),
        Binding::Flag { .. } => binding.event_name(),
    }
}

/// A text in double quotes; DOT knows no other escape than these.
struct Quoted<'a>(&'a str);

impl fmt::Display for Quoted<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_char('"')?;
        escape(self.0, formatter)?;
        formatter.write_char('"')
    }
}

/// One or two lines in one pair of quotes.
struct Lines<'a>(&'a str, Option<&'a str>);

impl fmt::Display for Lines<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_char('"')?;
        escape(self.0, formatter)?;
        if let Some(second) = self.1 {
            formatter.write_str("\\n")?;
            escape(second, formatter)?;
        }
        formatter.write_char('"')
    }
}

fn escape(text: &str, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
    for character in text.chars() {
        match character {
            '"' => formatter.write_str("\\\"")?,
            '\\' => formatter.write_str("\\\\")?,
            // Else a name could be taken for an HTML entity.
            '&' => formatter.write_str("&amp;")?,
            control if control.is_control() => formatter.write_char(' ')?,
            other => formatter.write_char(other)?,
        }
    }
    Ok(())
}

/// A text that cannot end a comment.
struct OneLine<'a>(&'a str);

impl fmt::Display for OneLine<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut characters = self.0.chars();
        characters.try_for_each(|c| formatter.write_char(if c.is_control() { ' ' } else { c }))
    }
}

struct Listed<'a>(&'a [&'a str]);

impl fmt::Display for Listed<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, name) in self.0.iter().enumerate() {
            let separator = if index == 0 { "" } else { ", " };
            write!(formatter, "{separator}{}", OneLine(name))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gate() -> NetModel {
        let mut net = NetModel::new("gate");
        net.source("asked", Binding::flag("robot", "request"));
        net.sink("bell", Binding::event("ring"));
        net.place("free").mark("free").place("taken");
        net.exclusion("one", &["free", "taken"])
            .end("shut", &["taken"]);
        net.transition("enter", &["asked", "free"], &["taken", "bell"]);
        net
    }

    #[test]
    fn everything_of_a_net_is_in_its_picture() {
        assert_eq!(
            Dot::new(&gate()).to_string(),
            r#"digraph "gate" {
  rankdir=LR; forcelabels=true;
  node [style=filled, width=0.35, fixedsize=true, fontsize=10];
  "asked" [shape=circle, label="", xlabel="asked\n→ robot.request", fillcolor=gray35, fontcolor=white];
  "bell" [shape=circle, label="", xlabel="bell\nevent ring →", fillcolor=gray85, fontcolor=black];
  "free" [shape=circle, label="&#9679;", xlabel="free", fillcolor=white, fontcolor=black];
  "taken" [shape=circle, label="", xlabel="taken", fillcolor=white, fontcolor=black];
  "enter" [shape=box, width=0.12, height=0.5, label="", xlabel="enter", fillcolor=black];
  "asked" -> "enter";
  "free" -> "enter";
  "enter" -> "taken";
  "enter" -> "bell";
  // at most one of `one`: free, taken
  // end `shut`: taken
}
"#
        );
    }

    #[test]
    fn another_marking_and_notes_are_shown() {
        let net = gate();
        let picture = Dot::new(&net)
            .marking(|place| place == "asked")
            .notes(|name| (name == "enter").then_some("lets it \"in\""))
            .to_string();
        assert!(
            picture.contains(r#""asked" [shape=circle, label="&#9679;""#),
            "{picture}"
        );
        assert!(
            picture.contains(r#""free" [shape=circle, label="","#),
            "{picture}"
        );
        assert!(picture.contains(r#"tooltip="lets it \"in\"""#), "{picture}");
    }

    #[test]
    fn odd_names_cannot_break_out_of_the_picture() {
        let mut net = NetModel::new("a\"]; b");
        net.place("x\\")
            .place("&lt;\n}")
            .exclusion("two\nlines", &["x\\", "&lt;\n}"]);
        net.transition("t\"", &["x\\"], &["&lt;\n}"]);
        let picture = Dot::new(&net).to_string();
        assert!(
            picture.starts_with("digraph \"a\\\"]; b\" {\n"),
            "{picture}"
        );
        assert!(picture.contains(r#"  "x\\" -> "t\"";"#), "{picture}");
        assert!(picture.contains(r#"  "t\"" -> "&amp;lt; }";"#), "{picture}");
        assert!(
            picture.contains("  // at most one of `two lines`: x\\, &lt; }\n"),
            "{picture}"
        );
        for line in picture
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"))
        {
            let plain = line.replace("\\\\", "").replace("\\\"", "");
            assert_eq!(plain.matches('"').count() % 2, 0, "{line}");
        }
    }
}
