//! The judge: finds in the world's truth what must not happen.
//!
//! It compares poses of the world with the site's map, with what everybody said on the network, and with what robots
//! believe; it asks neither robots nor mediator whether they did well.
//!
//! - [`Judge`] is composed of what is judged of each robot (collisions, clearance, lane and speed, borders, stops, pose) and
//!   of all together (areas and their grants, rules that hold during something);
//! - [`Figures`](crate::figures::Figures) are what comes out of one robot's run;
//! - [`two_owners`] finds areas that had more owners at once than they hold,
//!   [`fences_not_grown`] grants whose fence is no larger than that of an earlier one, [`two_nets`] robots that two nets commanded;
//! - [`view`] says which walls a lidar can see.
//!
#![doc = include_str!("INVARIANTS.md")]

mod areas;
mod borders;
mod braking;
mod composed;
mod conduct;
mod contact;
mod during;
mod fences;
mod lane;
mod latched;
mod look;
mod nets;
mod overlap;
mod owners;
mod pose;
mod recovery;
mod stops;
pub mod view;
mod violations;

pub use composed::Judge;
pub use fences::fences_not_grown;
pub use latched::Waiting;
pub use look::Look;
pub use nets::two_nets;
pub use owners::two_owners;

#[cfg(test)]
mod during_tests;
#[cfg(test)]
mod message_tests;
#[cfg(test)]
mod tests;
