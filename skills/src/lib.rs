//! Pure algorithms: odometry, perception, controllers, monitors, motion tubes, semantic map

pub mod geometry;
pub mod history;
pub mod scan;
pub mod tubes;
