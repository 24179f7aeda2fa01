//! From site and net files to plans: names resolved, protocols recognised, nets analysed.

mod loader;
mod plans;
mod preempt;
mod roles;
mod situations;

pub use loader::PlanError;
pub use plans::plans;
