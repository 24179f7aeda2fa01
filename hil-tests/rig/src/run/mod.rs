//! One run of a scenario, and the two ways to run it.
//!
//! - [`Execution`] is the seam: robots, world and mediator, whoever runs them;
//! - [`stage`] runs the real programs in real time; [`stepped`](crate::stepped) is the other way;
//! - [`Run`] judges a run and knows when it ends; [`live`] shows it; [`Record`](crate::record::Record) is what is left of it.

mod ending;
mod execution;
mod finish;
mod hours;
pub mod links;
pub mod live;
pub(crate) mod measured;
pub mod member;
mod options;
mod path;
mod printing;
mod programs;
mod recording;
mod repeat;
mod settings;
pub mod stage;
mod watch;

pub use ending::Ending;
pub use execution::{Execution, Found, LOOK_NS, MediatorRuns};
pub use finish::{finish, leave, look_on};
pub use options::Options;
pub use path::Path;
pub use programs::run;
pub use recording::record;
pub use repeat::SPOILED;
pub use settings::settings;
pub use watch::{Run, Track};
