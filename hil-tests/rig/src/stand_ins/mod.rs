//! The rig in the place of people, vehicles, operators and the mediator.

pub mod caretaker;
pub mod clutter;
pub mod leave;
pub mod operator;
