//! Nets and machines bound to protocols.

mod aborts;
mod common;
mod junction;
mod lossy;
mod machine;
mod net;
mod proof;
