//! The thread that gives a device its time, its turns and its terminal.

mod options;
mod port;
mod run;
mod serve;
#[cfg(test)]
mod tests;

pub use options::{LidarError, LidarOptions};
pub use serve::LidarServer;
