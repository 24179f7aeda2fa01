//! A thread that serves a segment: receives frames, has them carried out, sends them back.
//!
//! The reply leaves before the drive's side runs, so that simulating the mechanics does not delay it. Without
//! frames the segment is still called every 2 ms. The thread ends within that time when it is stopped or its handle is
//! dropped.

use std::collections::VecDeque;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::wire::{RawError, RawWire, UdpWire, Wire};
use crate::ethercat::segment::{Reply, Segment};
use crate::rt::{self, Granted, monotonic_ns};

/// Longest time between two calls of the segment.
const TICK_NS: u64 = 2_000_000;
/// Longest frame; longer ones are cut and then found malformed.
const FRAME: usize = 1600;
/// Most frames that can be held back at a time; more are lost.
const MAX_HELD: usize = 64;

/// Why a segment cannot be served.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum ServeError {
    /// The UDP port is taken, or not ours to take.
    #[error("EtherCAT segment: cannot bind UDP port {} on {}: {source}", address.port(), address.ip())]
    Udp {
        address: SocketAddr,
        source: io::Error,
    },
    /// There is no such interface.
    #[error("EtherCAT segment: no network interface {name:?}")]
    NoInterface { name: String },
    /// The interface carries no frames.
    #[error("EtherCAT segment: network interface {name:?} is down; try `ip link set {name} up`")]
    InterfaceDown { name: String },
    /// Frames would come back on a loopback interface without having passed the segment.
    #[error(
        "EtherCAT segment: {name:?} is a loopback interface; use UDP, or a pair of virtual interfaces"
    )]
    Loopback { name: String },
    /// The interface cannot be opened, usually for lack of CAP_NET_RAW.
    #[error(
        "EtherCAT segment: cannot open network interface {name:?} for raw frames (needs CAP_NET_RAW): {source}"
    )]
    Raw { name: String, source: io::Error },
    /// No thread can be started.
    #[error("EtherCAT segment: cannot start a thread: {0}")]
    Thread(io::Error),
}

/// How a segment is served.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ServeOptions {
    /// SCHED_FIFO priority of the thread, if permitted; should be above the MainDevice's.
    pub priority: Option<u8>,
}

/// A running server. Dropping it stops the thread and waits for it.
#[derive(Debug)]
pub struct ServerHandle {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    local_addr: Option<SocketAddr>,
    granted: Option<Granted>,
}

impl ServerHandle {
    /// The UDP address that is served, with the port that was chosen if 0 was asked for; `None` on an interface.
    #[must_use]
    pub fn local_addr(&self) -> Option<SocketAddr> {
        self.local_addr
    }

    /// How the thread is scheduled, if a priority was asked for.
    #[must_use]
    pub fn granted(&self) -> Option<&Granted> {
        self.granted.as_ref()
    }

    /// Whether the thread still runs.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.thread
            .as_ref()
            .is_some_and(|thread| !thread.is_finished())
    }

    /// Stops the thread and waits for it. False if it had panicked.
    #[must_use]
    pub fn stop(mut self) -> bool {
        self.join()
    }

    fn join(&mut self) -> bool {
        self.stop.store(true, Ordering::Relaxed);
        self.thread
            .take()
            .is_none_or(|thread| thread.join().is_ok())
    }
}

impl Drop for ServerHandle {
    fn drop(&mut self) {
        self.join();
    }
}

/// Serves a segment over UDP: each datagram carries an EtherCAT header and EtherCAT datagrams.
///
/// # Errors
/// [`ServeError::Udp`] when the port cannot be bound, [`ServeError::Thread`] when no thread can be started.
pub fn serve_udp(
    address: SocketAddr,
    segment: Segment,
    options: ServeOptions,
) -> Result<ServerHandle, ServeError> {
    let wire = UdpWire::bind(address).map_err(|source| ServeError::Udp { address, source })?;
    let local_addr = wire
        .local_addr()
        .map_err(|source| ServeError::Udp { address, source })?;
    start(wire, segment, options, Some(local_addr))
}

/// Serves a segment on a network interface: whole Ethernet frames.
///
/// # Errors
/// [`ServeError`]: no such interface, one that is down or a loopback, CAP_NET_RAW missing, or no thread.
pub fn serve_raw(
    interface: &str,
    segment: Segment,
    options: ServeOptions,
) -> Result<ServerHandle, ServeError> {
    let wire = RawWire::open(interface).map_err(|error| {
        let name = interface.to_owned();
        match error {
            RawError::Unknown => ServeError::NoInterface { name },
            RawError::Down => ServeError::InterfaceDown { name },
            RawError::Loopback => ServeError::Loopback { name },
            RawError::Io(source) => ServeError::Raw { name, source },
        }
    })?;
    start(wire, segment, options, None)
}

fn start<W: Wire + 'static>(
    wire: W,
    segment: Segment,
    options: ServeOptions,
    local_addr: Option<SocketAddr>,
) -> Result<ServerHandle, ServeError> {
    let stop = Arc::new(AtomicBool::new(false));
    let (tell, told) = mpsc::sync_channel(1);
    let mut server = Server {
        wire,
        segment,
        held: VecDeque::new(),
    };
    let stopped = stop.clone();
    let thread = thread::Builder::new()
        .name("sim-ethercat".into())
        .spawn(move || {
            let granted = options.priority.map(rt::promote);
            // The caller may have gone away; the server runs anyway.
            let _ = tell.send(granted);
            server.run(&stopped);
        })
        .map_err(ServeError::Thread)?;
    let granted = told
        .recv()
        .map_err(|_| ServeError::Thread(io::Error::other("it ended at once")))?;
    Ok(ServerHandle {
        stop,
        thread: Some(thread),
        local_addr,
        granted,
    })
}

/// A reply that is held back.
struct Held<P> {
    due_ns: u64,
    frame: Vec<u8>,
    copies: u32,
    peer: P,
}

struct Server<W: Wire> {
    wire: W,
    segment: Segment,
    held: VecDeque<Held<W::Peer>>,
}

impl<W: Wire> Server<W> {
    fn run(&mut self, stop: &AtomicBool) {
        let mut buffer = [0; FRAME];
        while !stop.load(Ordering::Relaxed) {
            self.wait();
            self.release_held();
            match self.wire.receive(&mut buffer) {
                Ok((length, peer)) => {
                    self.serve(&mut buffer[..length], peer);
                    continue;
                }
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                // For instance: interface down, or the peer's port closed. May be temporary; do not spin.
                Err(_) => thread::sleep(Duration::from_millis(1)),
            }
            self.segment.cycle(monotonic_ns());
        }
    }

    fn serve(&mut self, frame: &mut [u8], peer: W::Peer) {
        let now_ns = monotonic_ns();
        if let Some(reply) = W::process(&mut self.segment, frame, now_ns) {
            // However late this thread is, what was to be back before leaves before.
            self.release_held();
            if reply.foreign_before {
                self.send(W::foreign_frame(), peer);
            }
            self.answer(&frame[..reply.length.min(frame.len())], reply, peer, now_ns);
        }
        self.segment.cycle(now_ns);
    }

    fn answer(&mut self, frame: &[u8], reply: Reply, peer: W::Peer, now_ns: u64) {
        if reply.delay.is_zero() {
            for _ in 0..reply.copies {
                self.send(frame, peer);
            }
        } else if self.held.len() < MAX_HELD {
            let delay_ns = u64::try_from(reply.delay.as_nanos()).unwrap_or(u64::MAX);
            let due_ns = now_ns.saturating_add(delay_ns);
            self.held.push_back(Held {
                due_ns,
                frame: frame.to_vec(),
                copies: reply.copies,
                peer,
            });
        }
    }

    fn release_held(&mut self) {
        let now_ns = monotonic_ns();
        let mut i = 0;
        while i < self.held.len() {
            if self.held[i].due_ns > now_ns {
                i += 1;
            } else if let Some(held) = self.held.remove(i) {
                for _ in 0..held.copies {
                    self.send(&held.frame, held.peer);
                }
            }
        }
    }

    fn send(&mut self, frame: &[u8], peer: W::Peer) {
        // A reply that cannot be sent is lost, as on a wire.
        let _ = self.wire.send(frame, peer);
    }

    /// Waits for a frame, for a held reply to become due, or for the tick.
    fn wait(&self) {
        let now_ns = monotonic_ns();
        let due_ns = self
            .held
            .iter()
            .map(|held| held.due_ns)
            .min()
            .unwrap_or(u64::MAX);
        let wait_ns = due_ns.saturating_sub(now_ns).min(TICK_NS);
        let timeout = Timespec {
            tv_sec: 0,
            tv_nsec: wait_ns as _,
        };
        let mut fds = [PollFd::from_borrowed_fd(self.wire.fd(), PollFlags::IN)];
        // Interrupted or failed: the receive that follows tells.
        let _ = poll(&mut fds, Some(&timeout));
    }
}
