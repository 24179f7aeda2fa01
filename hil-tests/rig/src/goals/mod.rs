//! How far robots are with what they are to do, by the world's truth.

mod laps;
mod places;
mod progress;
mod states;
#[cfg(test)]
mod tests;

pub use progress::Progress;
