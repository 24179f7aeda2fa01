//! `[teleop]`: how a person drives the robot by hand.

use crate::keys::{Count, SPEED};
use crate::section;

section! {
    /// How a person drives the robot by hand, with `onboard teleop`.
    #[derive(Copy)]
    pub struct Teleop: Default {
        /// No faster than this; borders, tubes and areas may allow less.
        pub speed_m_s: f64 as SPEED => 0.20,
        /// No faster than this while the robot does not know where it is.
        pub creep_m_s: f64 as SPEED => 0.10,
        /// A wish older than this counts as none, and the robot stops.
        pub deadline_ms: u32 as Count::new("a time in ms", 50, 1000) => 250,
    }
}
