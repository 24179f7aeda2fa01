//! How far robots are with what they are to do, by the world's truth.

mod laps;
mod places;
mod progress;
mod states;

pub use laps::Laps;
pub use places::Way;
pub use progress::Progress;
pub use states::States;
