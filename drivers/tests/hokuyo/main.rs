//! The Hokuyo driver against devices on pseudo terminals.

mod allocation;
#[path = "../../../coordination/tests/counting/mod.rs"]
mod counting;
mod peer;
mod scripted_connect;
mod scripted_read;
mod simulated;
