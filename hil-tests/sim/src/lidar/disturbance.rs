//! What goes wrong with a sensor.

use std::time::Duration;

/// Something that goes wrong with a sensor that is plugged in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Disturbance {
    /// Random bytes between scans.
    Garbage {
        /// How many.
        bytes: usize,
    },
    /// The second half of the next scans is lost.
    TruncateScans {
        /// Of how many.
        scans: u32,
    },
    /// A bit in the data of the next scans flips, so that a checksum is wrong.
    CorruptScans {
        /// Of how many.
        scans: u32,
    },
    /// It neither receives nor sends, or goes on.
    Freeze {
        /// Which of the two.
        frozen: bool,
    },
    /// Something covers its window, or is taken away: no beam has an echo.
    Cover {
        /// Which of the two.
        covered: bool,
    },
    /// Each scan says what the last one said, until the laser is switched off, or the next one measures again.
    Repeat {
        /// Which of the two.
        repeats: bool,
    },
    /// So does each scan again a second after each time that the laser is switched on, or the next one measures again.
    RepeatAgain {
        /// Which of the two.
        repeats: bool,
    },
    /// It says itself that it does not work well, and measures on; or that it does again.
    Unwell {
        /// Which of the two.
        unwell: bool,
    },
    /// Nothing that it sends arrives.
    Silence {
        /// For this long.
        duration: Duration,
    },
}
