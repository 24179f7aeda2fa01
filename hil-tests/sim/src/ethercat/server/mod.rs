//! A thread that serves a segment over UDP or on a network interface.

mod serve;
mod wire;

pub use serve::{ServeError, ServeOptions, ServerHandle, serve_raw, serve_udp};
