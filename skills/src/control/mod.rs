//! Control laws: from where the robot is to the motion that it should make. Steering and speed are separate.
//!
//! Steering:
//! * [`path_curvature`] and [`reverse_curvature`]: the laws that all of them steer by;
//! * [`keep_lane`]: on a lane, or beside it;
//! * [`Track`] and [`Follower`]: along the path of a manoeuvre onto a lane; [`manoeuvre`] makes the paths of U-turns,
//!   junction turns and shifts, and says why there is none;
//! * [`Creep`]: a short way forward or backward.
//!
//! Speed:
//! * [`approach_speed_m_s`]: the speed from which a lower one can still be reached;
//! * [`EndOfLane`], [`Stopping`]: done at a place, with a speed or at rest;
//! * [`SpeedRamp`]: limits acceleration and deceleration.
//!
//! Pure and real time: nothing allocates, locks or panics.

mod approach;
mod creep;
mod end_of_lane;
mod follow;
mod law;
pub mod manoeuvre;
mod ramp;
mod steer;
mod track;

pub use approach::{REACTION_S, Stopping, approach_speed_m_s};
pub use creep::{CREEP_SPEED_M_S, Creep, MAX_BACKWARD_M_S};
pub use end_of_lane::EndOfLane;
pub use follow::{Arrival, Follower};
pub use law::{keep_lane, path_curvature, reverse_curvature, speed_share};
pub use manoeuvre::TrackError;
pub use ramp::SpeedRamp;
pub use steer::{PathError, Steer};
pub use track::{Track, TrackPlace};

#[cfg(test)]
mod tests;
