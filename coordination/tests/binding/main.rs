//! Nets and machines bound to protocols.

mod common;
mod junction;
mod lossy;
mod machine;
mod net;
