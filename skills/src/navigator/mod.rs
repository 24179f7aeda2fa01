//! Navigation as one step: pose, perception, monitors, the robot's machine, and its controller.
//!
//! [`Navigator::step`] does, in this order: moves the pose and all estimates with odometry; looks at a new scan, with what
//! the present schedule perceives; evaluates the controller and the monitors; steps the machine with what was posted and
//! what fired, which may exchange the schedule; plans the path ahead; and commands a motion under the schedule in force
//! then, within the limits of speed, borders and instruction.
//!
//! Without a scan it goes on by odometry, and the covariance grows until the pose is uncertain. Then, when motion is not
//! allowed, and before an area that is not allowed, the command keeps its curve with speed 0. It goes on by itself when
//! the reason is over. What somebody wants who drives by hand ([`ByHand`]) stands in place of what the controller wants.
//!
//! Real time: [`Navigator::step`], [`Navigator::post`] and [`Navigator::instruct`] do not allocate, lock or panic;
//! [`Navigator::new`] does allocate.

mod build;
mod by_hand;
mod checkpoint;
mod command;
mod control;
mod coordinate;
mod instruction;
mod output;
mod setup;
mod state;
mod step;
mod take_over;

pub use crate::schedule::Hold;
pub use checkpoint::NavigatorCheckpoint;
pub use instruction::{Instructed, Instruction, InstructionError, Parameters};
pub use output::{
    ByHand, EventList, MAX_EVENTS, NavigationCounters, NavigationInput, NavigationOutput, PoseCheck,
};
pub use setup::NavigatorSetup;
pub use state::Navigator;
