//! What carries Ethernet frames between MainDevice and segment.

use std::io;
use std::sync::Arc;

use crate::clock::{Clock, Monotonic};

/// Carries Ethernet frames to an EtherCAT segment and back.
///
/// # Real-time contract
/// Implementations do not allocate, lock or log in [`send`](Link::send) and [`receive`](Link::receive), and make no
/// system call but those of their own device.
pub trait Link: Send {
    /// Sends one Ethernet frame (destination, source, ethertype `0x88A4`, EtherCAT frame) without waiting.
    ///
    /// # Errors
    /// What the system says. After [`io::ErrorKind::WouldBlock`], `Interrupted` or `ConnectionRefused` the link can be
    /// used again; after any other error open a new link.
    fn send(&mut self, ethernet_frame: &[u8]) -> io::Result<()>;

    /// Waits for one Ethernet frame until `deadline_ns` of its [`clock`](Link::clock) and returns its length, or `None` at the
    /// deadline. What has already arrived is returned even when the deadline has passed.
    ///
    /// A frame that comes from the segment has the locally-administered bit of its source address set.
    ///
    /// # Errors
    /// As for [`send`](Link::send). Reaching the deadline is no error.
    fn receive(&mut self, buffer: &mut [u8], deadline_ns: u64) -> io::Result<Option<usize>>;

    /// The clock of its deadlines: `CLOCK_BOOTTIME`, unless the segment is simulated on another.
    fn clock(&self) -> Arc<dyn Clock> {
        Arc::new(Monotonic)
    }

    /// What this link is, for messages: "interface eth0", "UDP 127.0.0.1:34980".
    fn describe(&self) -> String;
}

/// Why a link cannot be opened.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum LinkError {
    /// The interface does not exist.
    #[error("no network interface {interface:?}; this machine has: {available}")]
    NoSuchInterface {
        interface: String,
        available: String,
    },
    /// The interface exists but is down.
    #[error(
        "network interface {interface:?} is down; bring it up with `ip link set {interface} up`"
    )]
    InterfaceDown { interface: String },
    /// The process may not open raw sockets.
    #[error(
        "not allowed to send raw Ethernet frames on {interface:?}: CAP_NET_RAW is missing; let only a group of its own run the program \
         (`chown root:GROUP`, `chmod 0750`), then grant it with `sudo setcap cap_net_raw+ep <path of the program>`"
    )]
    NotPermitted { interface: String },
    /// The system refused something else.
    #[error("cannot open {link}: {step}: {source}")]
    System {
        /// The link, as [`Link::describe`] names it.
        link: String,
        step: &'static str,
        source: io::Error,
    },
}
