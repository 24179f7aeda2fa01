//! All skills together drive a simulated tricycle through the corridor, lap after lap; judged by the simulation's truth.

mod by_hand;
mod docks;
mod floor;
mod hostile;
mod junctions;
mod lanes;
mod laps;
mod leave;
mod resume;
mod robot;
mod site;
mod stops;
mod trouble;
