//! What is known of the floor around the robot: by the newest scan, by what was seen before, by what was driven over.
//!
//! * [`grid`]: the cells around the robot;
//! * [`known`]: what one scan says per beam, with unknown beams settled;
//! * [`seen`]: what was seen beside the robot in the last two seconds of driving;
//! * [`floor`]: which floor out of view is known to be free;
//! * [`checkpoint`]: floor and hits, for another process to go on with;
//! * [`moving`]: the distance to the nearest thing that moves.

mod cell;
pub mod checkpoint;
pub mod floor;
pub mod grid;
pub mod known;
pub mod moving;
pub mod seen;
