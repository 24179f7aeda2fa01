//! `[watchdog]`: the computer's own watchdog.

use crate::keys::{Count, Optional, Text};
use crate::section;

section! {
    /// The computer's watchdog, which restarts it when the program hangs.
    pub struct Watchdog: Default {
        /// It; none: nobody restarts the computer.
        pub device: Option<String> as Optional(Text("a device file, such as \"/dev/watchdog\"")) => None,
        /// Without a sign of life for this long it restarts the computer.
        pub timeout_s: u32 as Count::new("a time in s", 2, 600) => 15,
    }
}
