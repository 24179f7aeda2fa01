//! The plan: a robot file and a site file, checked, and made into the parts that the activities run.

mod budget;
mod contents;
mod differences;
mod error;
mod fleet;
mod load;
mod managed;
mod parts;

pub use budget::{Budget, Lateness};
pub use contents::{Plan, ns_from_ms, thread_names, wanted_scheduling};
pub use error::PlanError;

#[cfg(test)]
mod tests;
