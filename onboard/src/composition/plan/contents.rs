//! What the plan holds.

use std::time::Duration;

use config::{RobotConfig, SiteConfig};
use coordination::fsm::StateId;
use description::site::{FsmConfig, SiteRobot};
use description::threads::{Core, Scheduling, ThreadConfig};
use skills::tubes::{TubeReport, TubeSet};

use crate::fleet::Start;
use crate::realtime::scheduling::{CoreClass, Wanted};

/// What the two files say, checked as far as that can be done without a device.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The robot file.
    pub robot: RobotConfig,
    /// The site file.
    pub site: SiteConfig,
    /// Role that the site gives this robot.
    pub role: String,
    /// The state machine of that role.
    pub fsm: FsmConfig,
    /// Where it starts, and in which state.
    pub start: SiteRobot,
    /// How many tubes there are, and which are refused.
    pub tube_report: TubeReport,
    /// The tubes themselves; none while the plan is being checked.
    pub(super) tubes: Option<TubeSet>,
}

impl Plan {
    /// Where the robot starts, in `state` of its machine.
    #[must_use]
    pub fn start(&self, state: StateId) -> Start {
        let gains = &self.robot.navigation;
        Start {
            pose: self.start.start,
            std_m: gains.start_std_m,
            std_rad: gains.start_std_rad,
            state,
        }
    }
}

/// Milliseconds as nanoseconds.
#[must_use]
pub fn ns_from_ms(milliseconds: u32) -> u64 {
    u64::try_from(Duration::from_millis(u64::from(milliseconds)).as_nanos()).unwrap_or(u64::MAX)
}

/// Names of the configured threads, in their order.
#[must_use]
pub fn thread_names(robot: &RobotConfig) -> Vec<String> {
    robot
        .threads
        .iter()
        .map(|thread| thread.name.clone())
        .collect()
}

/// What a thread asks the scheduler for.
#[must_use]
pub fn wanted_scheduling(thread: &ThreadConfig) -> Wanted {
    Wanted {
        fifo_priority: match thread.scheduling {
            Scheduling::Fifo { priority } => Some(u8::try_from(priority).unwrap_or(u8::MAX)),
            Scheduling::Normal => None,
        },
        cores: match thread.core {
            Core::Any => CoreClass::Any,
            Core::Big => CoreClass::Big,
            Core::Little => CoreClass::Little,
            Core::Number(number) => CoreClass::Number(number),
        },
    }
}
