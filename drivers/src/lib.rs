//! Hardware protocols: EtherCAT bring-up and links, the KELO drive, the Hokuyo lidar; no policy

pub mod hokuyo;
