//! What carries Ethernet frames between MainDevice and segment: a network interface or UDP.

mod link;
mod raw;
mod ring;
mod socket;
mod udp;

pub use link::{Link, LinkError};
pub use raw::RawLink;
pub use socket::refused;
pub use udp::UdpLink;
