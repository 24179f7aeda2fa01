//! One run of a scenario.

pub mod live;
mod outcome;
#[expect(clippy::module_inception, reason = "the run itself")]
pub mod run;
pub mod stage;

pub use run::{Ending, Options, Run};
