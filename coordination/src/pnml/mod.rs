//! Nets as PNML documents: nets of other tools in, ours out.
//!
//! PNML is the interchange format of ISO/IEC 15909-2:2011; what is read and written are its
//! place/transition nets, grammar `http://www.pnml.org/version-2009/grammar/ptnet`.
//!
//! [`read()`] makes a [`NetModel`](crate::petri::NetModel). Pages, nested ones too, become one net, and
//! reference nodes the nodes that they refer to. A place or transition keeps its name if each of them
//! has a name of its own; otherwise all are called by their ids. Our nets are safe: an inscription or
//! an initial marking above one is refused, and so is whatever would mean something else than it
//! seems to, such as an element that place/transition nets do not have (the inhibitor arcs of some
//! tools, for example). The capacity of our places is one. A net of another tool that is safe behaves
//! the same; one that is not is found by the [analysis](crate::analysis).
//!
//! What is read has not been [checked](crate::petri::NetModel::check): a place that nothing fills or
//! empties is legal in PNML, but does not compile here. The final places of a workflow are such; PNML has no word
//! for them, so declare them an [end](crate::petri::NetModel::end) of what was read, and it compiles, and is
//! judged by whether it reaches that. [`properties`](crate::analysis::properties()) takes such nets as they stand.
//!
//! [`Document`] is a net as a document. What PNML has no word for (sources and sinks with their
//! bindings, exclusions, ends, whether the net may be endless) stands in `toolspecific` elements, which
//! other tools pass over and [`read()`] takes in again: same places, transitions, arcs, marks and
//! declarations, in the same order. Nodes stand on a grid.
//!
//! Documents may come from anywhere. Reading takes time and memory in proportion to the text, which
//! has at most [`MAX_BYTES`]; document types, and so entities, are refused; pages nest at most
//! [`MAX_DEPTH`] deep. Not for real-time threads.
//!
//! ```
//! use coordination::petri::NetModel;
//! use coordination::pnml::{Document, read};
//!
//! let mut light = NetModel::new("light");
//! light.place("red").mark("red").place("green");
//! light.transition("go", &["red"], &["green"]).transition("halt", &["green"], &["red"]);
//! let text = Document::new(&light)?.to_string();
//! assert!(text.contains("<place id=\"p1\">"));
//! assert!(read(&text)?.transitions().eq(light.transitions()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
mod grammar;
mod own;
mod read;
mod write;

pub use error::{At, ReadError, WriteError};
pub use read::{MAX_BYTES, MAX_DEPTH, read, read_all};
pub use write::Document;
