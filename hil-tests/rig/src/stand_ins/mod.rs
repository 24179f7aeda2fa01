//! What the rig plays in the place of people and of the mediator.

pub mod clutter;
pub mod leave;
pub mod operator;
