//! Scenarios with one robot.

pub mod campaign;
pub mod course;
pub mod judge;
pub mod lap;
pub mod listener;
pub mod live;
pub mod progress;
pub mod stage;
pub mod summary;
pub mod trial;
pub mod trials;
