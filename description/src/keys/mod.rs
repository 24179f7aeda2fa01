//! Keys of files: each is declared once, with its type, unit, range, default and explanation.
//!
//! [`section!`](crate::section) declares a table of a file and [`kinds!`](crate::kinds) a choice that brings keys of
//! its own. From a declaration come the type, the code that reads it from any [`Source`], a check of its ranges without
//! a file ([`Section::check`]), and its part of the reference page ([`Section::document`]).
//!
//! ```
//! use description::keys::{Page, Quantity, Section};
//!
//! description::section! {
//!     /// `[creep]`: how the robot feels its way.
//!     #[derive(Copy)]
//!     pub struct Creep: Default {
//!         /// Fastest speed while creeping.
//!         pub speed_m_s: f64 as Quantity::new("a speed", "m/s").above(0.0).at_most(0.3) => 0.1,
//!     }
//! }
//!
//! assert!(Creep::default().check().is_ok());
//! let error = Creep { speed_m_s: 0.5 }.check().unwrap_err();
//! assert_eq!(error.to_string(), "speed_m_s: found 0.5, expected a speed above 0 and at most 0.3 m/s");
//! ```

mod declare;
mod error;
mod field;
mod page;
mod quantity;
mod rules;
mod source;
mod tables;

pub use error::{KeyError, KeyErrors, article};
pub use field::{Field, Section};
pub use page::{KeyDoc, Page, TableDoc};
pub use quantity::{ANGLE, Count, OFFSET, POSITION, Quantity, SPEED, rounded};
pub(crate) use rules::none;
pub use rules::{
    Corners, Ends, Flat, Id, Micros, Millis, Name, Optional, Pose, Text, Texts, Truth, Word,
    WordList, Words, quoted_list,
};
pub use source::{Fault, Need, Source};
pub use tables::{Each, List, Map, Table, TableOrDefaults};
