//! The robot's process.
