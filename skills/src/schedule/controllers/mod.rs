//! The controllers that a skill can name: one file for each, with its parameters, its checks and what it does.
//!
//! A new controller has a file here, a variant in [`controller`] and one in the plain data that it is made from.
//!
//! * [`case`]: one state under consideration, what a check may ask;
//! * [`motion`], [`pace`]: how to steer, and how fast to be on the way;
//! * [`behaviour`]: what every controller answers while its state lasts;
//! * [`corridor`], [`end_of_lane`], [`u_turn`], [`shift`], [`turn`], [`stop_at`], [`dock`], [`creep`], [`stop`]: the
//!   controllers;
//! * [`controller`]: any one of them.

pub(crate) mod behaviour;
pub(super) mod case;
pub(crate) mod controller;
mod corridor;
mod creep;
mod dock;
mod end_of_lane;
pub(crate) mod motion;
pub(crate) mod pace;
mod shift;
mod stop;
pub(crate) mod stop_at;
mod turn;
mod u_turn;

pub use controller::Controller;
pub use corridor::Corridor;
pub use creep::CreepBy;
pub use dock::Dock;
pub use pace::Hold;
pub use shift::Shift;
pub use stop_at::StopAt;
pub use turn::Turn;
pub use u_turn::UTurn;
