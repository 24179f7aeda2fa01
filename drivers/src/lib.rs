//! Hardware protocols: EtherCAT bring-up and links, the KELO drive, the Hokuyo lidar; no policy.
//!
//! | module | holds |
//! |---|---|
//! | [`ethercat`] | a MainDevice for one SubDevice: links, bring-up to OP, cyclic exchange |
//! | [`kelo`] | what the KELO drive says in its process data, and how a setpoint is said to it |
//! | [`hokuyo`] | the lidar: finding its bit rate, SCIP, scans |

pub mod ethercat;
pub mod hokuyo;
pub mod kelo;
