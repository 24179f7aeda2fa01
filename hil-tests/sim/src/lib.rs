//! Simulated EtherCAT segment, KELO drive, Hokuyo lidar and world; knows nothing of the rest

pub mod plant;
