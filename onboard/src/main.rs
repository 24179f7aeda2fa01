//! The robot.
fn main() {}
