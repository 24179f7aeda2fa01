//! Composition: the two files become parts, and parts, symbols and ports become activities.

pub mod compose;
pub mod plan;
mod site_parts;
