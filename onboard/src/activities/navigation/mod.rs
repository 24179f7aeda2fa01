//! Navigation: pose, perception, the robot's machine, and the motion that its present skill wants.

mod activity;
mod hands;
mod membership;
mod names;
mod part;

pub use activity::Navigation;
pub use part::Part;
