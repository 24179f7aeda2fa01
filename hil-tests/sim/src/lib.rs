//! Simulated devices that speak the real protocols, and the world between them.
//!
//! A robot program finds its fieldbus and its lidar here as it would find the real ones: EtherCAT datagrams on a
//! network interface or over UDP, SCIP on a terminal. The crate stands alone, so that any other program can be tested
//! against it. What really happened is the world's to say, never the robot's.
//!
//! Everything that decides is a pure value that is told the time: [`world::World`], [`lidar::Device`]. Servers with
//! threads are thin shells around them.

pub mod ethercat;
pub mod kelo;
pub mod lidar;
pub mod plant;
mod range_source;
pub mod rt;
pub mod world;
