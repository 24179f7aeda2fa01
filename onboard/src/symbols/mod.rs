//! The symbols: what activities share, who owns each value, who reads it.

pub mod faults;
pub mod values;
pub mod wiring;
