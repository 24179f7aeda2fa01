//! The Hokuyo driver against devices on pseudo terminals.

mod allocation;
mod peer;
mod scripted_connect;
mod scripted_read;
mod simulated;
