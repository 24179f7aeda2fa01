//! Free-space motion tubes: is the floor free that the robot is about to sweep?
//!
//! A *tube* is the area that the footprint sweeps at a constant curvature over a horizon. At start-up its border is
//! sampled once, a little outside, and every sample is mapped to the beam that looks at it and to the range at which it
//! lies. At run time the tube is free when every one of those beams measures farther than its sample: one comparison
//! per sample, whatever stands around it. After Rodrigues, Tsiogkas, Huebel and Bruyninckx, *Clutter-resilient
//! autonomous mobile robot navigation with computationally efficient free-space features*, ISRR 2022.
//!
//! | part | does |
//! |---|---|
//! | [`error`] | what can be wrong with what tubes are made of, the section [`Tubes`](description::robot::Tubes) of a robot file |
//! | [`memory`] | what is known of the floor around the robot |
//! | [`set`] | the set of tubes, how it is made, and its evaluation |
//! | [`adapt`] | the run-time object: scans in, safe commands out |
//!
//! # What is guaranteed
//! A disc, or a box, whose every side is longer than `sample_step_m`, that stands still, that the sensor measures without
//! error, and that the robot does not touch already, does not reach into a tube that is declared free. It holds for
//! every tube of the set, ahead and behind, and for every path between two neighbouring ones that are both free, as far
//! as [`TubeSet::length_between_m`]. Where the sensor does not look, a tube is free only over floor that was seen free,
//! or driven over, within the last metres of driving, [`floor_memory_m`](description::robot::Tubes::floor_memory_m).
//!
//! Needed for it: `augment_m` of at least half of `sample_step_m`, *plus* the sensor's error and the motion that alignment
//! leaves. A thin wedge can reach further in. Not known is what has come in out of view since it was looked at, and, at
//! the beginning, what stands beside the robot where it was put down.
//!
//! Things that move: the robot drives slowly enough to stand before anything that it sees moving, at up to
//! [`MovingPolicy::speed_m_s`](description::robot::MovingPolicy::speed_m_s), can arrive. Something that comes from out of view can run into a driving robot.
//! In a dead end, a robot that makes detours also backs out, slowly, over floor that it knows. It does not see who has
//! come up behind it since: where that can happen, set [`DetourPolicy::retreat_m`](description::robot::DetourPolicy::retreat_m) to 0.
//!
//! # Real time
//! Generation allocates. [`MotionTubes::observe`] and [`MotionTubes::adapt`] do not, and take a bounded time.

pub mod adapt;
pub mod error;
pub mod memory;
pub mod set;

pub use adapt::motion_tubes::MotionTubes;
pub use adapt::outcome::{Adapted, Counters, ObserveError, Reason, Verdict};
pub use adapt::room::Room;
pub(crate) use adapt::room::turning_back_m;
pub use adapt::stop_rules::StopRules;
pub use error::{Refusal, TubeError};
pub use memory::checkpoint::FloorCheckpoint;
pub use memory::known::KnownRanges;
pub use set::brute_force::BruteForce;
pub use set::report::TubeReport;
pub use set::tube_set::{Surroundings, TubeId, TubeSet};

#[cfg(test)]
mod tests;
