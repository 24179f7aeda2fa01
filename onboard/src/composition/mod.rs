//! Composition: the two files become parts, and parts, symbols and ports become activities.

pub mod beginning;
pub mod checkpoint;
pub mod compose;
pub mod failure;
pub mod files;
pub mod plan;
pub mod replacement;
#[cfg(test)]
mod tests;
