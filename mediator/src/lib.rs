//! The area manager: which robot may be in which area, and who goes first.
//!
//! * [`cli`]: the commands of the program;
//! * [`setup`]: the areas and robots of one site;
//! * [`nets`]: Petri nets between robots, started by the situation;
//! * [`manager`]: the manager itself, pure: reports in, journal entries and reports out, no clock, network or file;
//! * [`journal`]: what survives a restart;
//! * [`runtime`]: the running mediator, on the fleet's network.
//!
//! A step is always the same: hand in what arrived, write the entries to the journal, and only then send the messages.
//! So whatever a robot was told, the next start of the mediator knows.
//!
//! No part of it is real-time: it allocates, and writing the journal waits for the disk. Times are nanoseconds of the mediator's
//! own monotonic clock, lengths metres in the `map` frame.
//!
//! # Example
//! A robot registers, and then gets an area:
//! ```
//! use std::time::Duration;
//!
//! use contract::client::{Client, Situation};
//! use contract::floor::Floor;
//! use contract::timing::{ENTERS_NO_MORE_NS, SILENT_AFTER_NS};
//! use mediator::journal::{Entry, Stored};
//! use mediator::manager::{Manager, RestoreError};
//! use mediator::setup::{AreaSetup, RobotSetup, Setup};
//!
//! let setup = Setup {
//!     site: "hall".into(),
//!     areas: vec![AreaSetup { id: "gate".into(), capacity: 1 }],
//!     robots: vec![RobotSetup {
//!         id: "amr-1".into(),
//!         role: "normal".into(),
//!         priority: 0,
//!         ages_after: 0,
//!         starts_in: Vec::new(),
//!     }],
//!     floor: Floor::default(),
//!     silent_after: Duration::from_nanos(SILENT_AFTER_NS),
//! };
//! let mut manager = Manager::new(&setup, &Stored::new(1), 0)?;
//! // 5 s after a start nobody enters any more what a mediator before has granted.
//! let now_ns = ENTERS_NO_MORE_NS;
//! let mut robot = Client::new("amr-1", "hall", 7);
//! let wants = Situation { located: true, wanted: vec!["gate".into()], ..Situation::default() };
//! for _ in 0..2 {
//!     robot.step(wants.clone(), now_ns, SILENT_AFTER_NS);
//!     manager.report(&robot.report(), now_ns);
//!     // Here they go to the journal, before any message leaves.
//!     let _entries: Vec<Entry> = manager.entries().collect();
//!     while let Some(message) = manager.next_message(now_ns) {
//!         robot.receive(&message, now_ns);
//!     }
//! }
//! assert!(robot.holds("gate"));
//! assert_eq!(manager.why("amr-1", now_ns).as_deref(), Ok("amr-1 waits for nothing"));
//! # Ok::<(), RestoreError>(())
//! ```

use std::ffi::OsString;
use std::process::ExitCode;

pub mod cli;
pub mod journal;
pub mod keys;
pub mod manager;
pub mod nets;
pub mod runtime;
pub mod setup;
mod site;
mod whole_floor;

/// Runs the program with these arguments, the first being its name. What it makes is nobody else's. Ends the process after
/// `--help` and wrong usage.
pub fn main_from(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    contract::private::by_default();
    cli::main_from(arguments)
}
