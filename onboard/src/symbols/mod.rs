//! The symbols: what activities share, who owns each value, who reads it.

pub mod faults;
mod layouts;
pub mod values;
pub mod wiring;
