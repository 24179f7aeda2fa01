//! A robot on its lane among boxes and moving discs, driven through its motion tubes; judged by the truth of the plant.

mod boxes;
mod discs;
mod robot;
mod world;
