//! A robot on its lane among boxes and moving discs, driven through its motion tubes; judged by the truth of the plant.

#[allow(dead_code, reason = "shared with the tests of the whole loop")]
#[path = "../closed_loop/plant.rs"]
mod plant;

mod boxes;
mod discs;
mod robot;
mod world;
