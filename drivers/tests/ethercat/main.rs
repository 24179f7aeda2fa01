//! The EtherCAT bus against a simulated segment: in the same thread, over UDP, and over a pair of network interfaces.
//!
//! Tests that need privileges say so and pass when they are missing.

mod bring_up;
mod conformance;
#[path = "../../../coordination/tests/counting/mod.rs"]
mod counting;
mod exchange;
mod interfaces;
mod kelo;
mod links;
mod real_time;
mod support;
mod timing;
