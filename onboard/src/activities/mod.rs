//! The seven activities: thin shells around drivers and skills, each with its port, its symbols and its 5C loop.

pub mod communication;
pub mod control;
pub mod drive;
pub mod exchange;
pub mod fleet_link;
pub mod lidar;
pub mod motion_tube;
pub mod navigation;
pub mod news;
mod per_minute;
pub mod port;
pub mod proprioception;
pub mod robot_activity;
pub mod scans;
mod unknown_floor;
