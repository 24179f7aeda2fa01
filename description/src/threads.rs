//! The thread table: which activity runs where, when, and how urgently.

use std::time::Duration;

use crate::keys::{Count, Field, Flat, Micros, Millis, Name, Need, Page, Source, WordList};
use crate::{kinds, section, words};

words! {
    /// The activities of a robot's process, in the order in which data flows.
    #[derive(PartialOrd, Ord)]
    pub enum ActivityKind {
        /// Exchanges wheel setpoints and encoders with the drive.
        Drive "drive",
        /// Dead reckoning from the encoders.
        Proprioception "proprioception",
        /// Motion command to wheel setpoints.
        Control "control",
        /// Receives scans.
        Lidar "lidar",
        /// Perception, pose, controllers, monitors, the robot's state machine.
        Navigation "navigation",
        /// Keeps the command inside free space.
        MotionTube "motion-tube",
        /// The network.
        Communication "communication",
    }
}

kinds! {
    /// What wakes a thread.
    #[derive(Copy, Eq)]
    pub enum Trigger by "trigger" else Async {
        /// Absolute times, evenly spaced.
        Period "period" {
            /// From one to the next.
            period @ "period_us": Duration as Micros(Count::new("a time in µs", 250, 1_000_000)),
        },
        /// Bytes from the lidar.
        Lidar "lidar",
        /// Each new scan.
        Scan "scan" {
            /// Longest sleep without a scan.
            at_least @ "at_least_ms": Duration as Millis(Count::new("a time in ms", 1, 1000)),
        },
        /// An asynchronous runtime.
        Async "async",
    }
}

kinds! {
    /// How the operating system schedules a thread.
    #[derive(Copy, Eq)]
    pub enum Scheduling by "scheduling" else Normal {
        /// SCHED_FIFO.
        Fifo "fifo" {
            /// Higher ones run first.
            priority: u32 as Count::new("a real-time priority", 1, 99),
        },
        /// Like any other program.
        Normal "normal",
    }
}

/// Where a thread may run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Core {
    /// Anywhere.
    Any,
    /// On the fast cores of a big.LITTLE machine; elsewhere anywhere.
    Big,
    /// On the slow cores of a big.LITTLE machine; elsewhere anywhere.
    Little,
    /// On exactly this one; an error where it does not exist.
    Number(usize),
}

/// The rule of [`Core`].
pub struct CoreRule;

impl CoreRule {
    const WORDS: &'static [&'static str] = &["any", "big", "little"];
    const EXPECTED: &'static str = "`big`, `little`, `any` or a core's number";
    /// No machine has more cores.
    const LARGEST: u32 = 1023;
}

impl Field<CoreRule> for Core {
    fn read(s: &dyn Source, key: &'static str, _: &CoreRule, _: Option<Self>) -> Self {
        match s.word_or_number(key, CoreRule::WORDS, CoreRule::LARGEST, CoreRule::EXPECTED) {
            Some(Ok("big")) => Self::Big,
            Some(Ok("little")) => Self::Little,
            Some(Err(number)) => Self::Number(number as usize),
            _ => Self::Any,
        }
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        _: &CoreRule,
        _: Option<Self>,
        about: &'static str,
    ) {
        page.key(key, CoreRule::EXPECTED, None, about);
    }
}

section! {
    /// One thread. Each activity must be on exactly one thread.
    #[derive(Eq)]
    pub struct ThreadConfig {
        /// Also the thread's name in the operating system: at most 15 bytes.
        pub name: String as Name,
        /// What it runs, in this order.
        pub activities: Vec<ActivityKind> as WordList(Need::Required),
        /// What wakes it.
        pub trigger: Trigger as Flat,
        /// How it is scheduled.
        pub scheduling: Scheduling as Flat,
        /// Where it may run.
        pub core: Core as CoreRule,
    }
}
