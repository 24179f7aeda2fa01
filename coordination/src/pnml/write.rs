//! From a net to a document.

use std::collections::HashMap;
use std::fmt::{self, Write};

use super::error::WriteError;
use super::grammar::{NAMESPACE, PT_NET};
use super::own::{
    END, ENDLESS, EVENT, EXCLUSION, FLAG, NAME, PLACE, PROTOCOL, REF, SINK, SOURCE, TOOL, VERBATIM,
    VERSION,
};
use crate::petri::{Binding, NetModel, Place, PlaceKind, PlaceSet};

/// Nodes side by side on the grid, and how far from each other.
const COLUMNS: usize = 10;
const SPACING: usize = 120;

/// A net as a PNML document, by [`Display`](fmt::Display); see [the module](super).
pub struct Document<'a> {
    model: &'a NetModel,
}

impl<'a> Document<'a> {
    /// The net with its initial marking.
    ///
    /// # Errors
    /// If the net does not compile, or a name has a character that XML cannot hold.
    pub fn new(model: &'a NetModel) -> Result<Self, WriteError> {
        let errors = model.check();
        if !errors.is_empty() {
            return Err(WriteError::Model(errors));
        }
        let holds = |text: &str| match text.chars().find(|&c| !is_xml(c)) {
            None => Ok(()),
            Some(character) => Err(WriteError::Character {
                name: text.to_owned(),
                character,
            }),
        };
        holds(model.name())?;
        for place in model.places() {
            holds(place.name)?;
            match place.binding {
                Some(Binding::Event(event)) => holds(event)?,
                Some(Binding::Flag { protocol, flag }) => {
                    holds(protocol)?;
                    holds(flag)?;
                }
                None => {}
            }
        }
        model.transitions().try_for_each(|t| holds(t.name))?;
        { model.exclusions().chain(model.ends()) }.try_for_each(|set| holds(set.name))?;
        Ok(Self { model })
    }

    fn place(&self, number: usize, place: &Place<'_>, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(out, "      <place id=\"p{number}\">")?;
        node(place.name, number, 0, out)?;
        if place.marked {
            writeln!(
                out,
                "        <initialMarking><text>1</text></initialMarking>"
            )?;
        }
        let port = match place.kind {
            PlaceKind::Internal => None,
            PlaceKind::Source => Some(SOURCE),
            PlaceKind::Sink => Some(SINK),
        };
        if let (Some(port), Some(binding)) = (port, place.binding) {
            write!(out, "        {}<{port}", Toolspecific)?;
            match binding {
                Binding::Event(event) => write!(out, " {EVENT}=\"{}\"", Escaped(event))?,
                Binding::Flag { protocol, flag } => {
                    let (protocol, flag) = (Escaped(protocol), Escaped(flag));
                    write!(out, " {PROTOCOL}=\"{protocol}\" {FLAG}=\"{flag}\"")?;
                }
            }
            writeln!(out, "/></toolspecific>")?;
        }
        writeln!(out, "      </place>")
    }

    /// What PNML has no word for.
    fn own(&self, numbers: &HashMap<&str, usize>, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(out, "    {Toolspecific}")?;
        writeln!(out, "      <{VERBATIM}/>")?;
        if self.model.allows_endless() {
            writeln!(out, "      <{ENDLESS}/>")?;
        }
        let exclusions = self.model.exclusions().map(|set| (EXCLUSION, set));
        let ends = self.model.ends().map(|set| (END, set));
        for (what, PlaceSet { name, places }) in exclusions.chain(ends) {
            write!(out, "      <{what} {NAME}=\"{}\">", Escaped(name))?;
            for place in places.iter().filter_map(|place| numbers.get(place)) {
                write!(out, "<{PLACE} {REF}=\"p{place}\"/>")?;
            }
            writeln!(out, "</{what}>")?;
        }
        writeln!(out, "    </toolspecific>")
    }
}

impl fmt::Display for Document<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Escaped(self.model.name());
        writeln!(out, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>")?;
        writeln!(out, "<pnml xmlns=\"{NAMESPACE}\">")?;
        writeln!(out, "  <net id=\"net\" type=\"{PT_NET}\">")?;
        writeln!(out, "    <name><text>{name}</text></name>")?;
        writeln!(out, "    <page id=\"page\">")?;
        let mut numbers = HashMap::new();
        for (number, place) in self.model.places().enumerate() {
            self.place(number, &place, out)?;
            numbers.insert(place.name, number);
        }
        for (number, transition) in self.model.transitions().enumerate() {
            writeln!(out, "      <transition id=\"t{number}\">")?;
            node(transition.name, number, SPACING / 2, out)?;
            writeln!(out, "      </transition>")?;
        }
        let mut arcs = 0;
        let mut arc = |from: fmt::Arguments<'_>, to: fmt::Arguments<'_>| {
            writeln!(
                out,
                "      <arc id=\"a{arcs}\" source=\"{from}\" target=\"{to}\"/>"
            )?;
            arcs += 1;
            Ok(())
        };
        for (number, transition) in self.model.transitions().enumerate() {
            for input in transition
                .inputs
                .iter()
                .filter_map(|name| numbers.get(name))
            {
                arc(format_args!("p{input}"), format_args!("t{number}"))?;
            }
            for output in transition
                .outputs
                .iter()
                .filter_map(|name| numbers.get(name))
            {
                arc(format_args!("t{number}"), format_args!("p{output}"))?;
            }
        }
        writeln!(out, "    </page>")?;
        self.own(&numbers, out)?;
        writeln!(out, "  </net>")?;
        writeln!(out, "</pnml>")
    }
}

/// The name of a node, and where it stands.
fn node(name: &str, number: usize, lower: usize, out: &mut fmt::Formatter<'_>) -> fmt::Result {
    let (x, y) = (
        SPACING * (number % COLUMNS + 1),
        SPACING * (number / COLUMNS + 1) + lower,
    );
    writeln!(out, "        <name><text>{}</text></name>", Escaped(name))?;
    writeln!(
        out,
        "        <graphics><position x=\"{x}\" y=\"{y}\"/></graphics>"
    )
}

/// The beginning of an element of ours.
struct Toolspecific;

impl fmt::Display for Toolspecific {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "<toolspecific tool=\"{TOOL}\" version=\"{VERSION}\">")
    }
}

/// A text in an element, or in double quotes. White space of other kinds than a space would not
/// come through a reader as it is.
struct Escaped<'a>(&'a str);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for character in self.0.chars() {
            match character {
                '<' => out.write_str("&lt;")?,
                '>' => out.write_str("&gt;")?,
                '&' => out.write_str("&amp;")?,
                '"' => out.write_str("&quot;")?,
                '\t' | '\n' | '\r' => write!(out, "&#{};", character as u32)?,
                other => out.write_char(other)?,
            }
        }
        Ok(())
    }
}

/// Whether XML 1.0 can hold a character at all (its production 2).
fn is_xml(character: char) -> bool {
    match character {
        '\t' | '\n' | '\r' => true,
        control if control < ' ' => false,
        other => !matches!(other, '\u{FFFE}' | '\u{FFFF}'),
    }
}
