//! What carries frames between a MainDevice and a segment: UDP datagrams or a network interface.

use std::io;
use std::net::{SocketAddr, UdpSocket};
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, OwnedFd};

use rustix::net::{AddressFamily, RecvFlags, SendFlags, SocketFlags, SocketType};

use crate::ethercat::frame::ETHERTYPE;
use crate::ethercat::segment::{Reply, Segment};

/// Carries frames; never blocks.
pub(super) trait Wire: Send {
    /// Where a frame came from.
    type Peer: Copy + Send;

    /// What to wait on for a frame.
    fn fd(&self) -> BorrowedFd<'_>;

    /// The next frame, if there is one.
    fn receive(&mut self, buffer: &mut [u8]) -> io::Result<(usize, Self::Peer)>;

    /// Sends a frame.
    fn send(&mut self, frame: &[u8], to: Self::Peer) -> io::Result<()>;

    /// Has the segment carry out a frame of this wire.
    fn process(segment: &mut Segment, frame: &mut [u8], now_ns: u64) -> Option<Reply>;

    /// A frame of another protocol on this wire.
    fn foreign_frame() -> &'static [u8];
}

/// EtherCAT headers and datagrams in UDP.
pub(super) struct UdpWire(UdpSocket);

impl UdpWire {
    pub(super) fn bind(address: SocketAddr) -> io::Result<UdpWire> {
        let socket = UdpSocket::bind(address)?;
        socket.set_nonblocking(true)?;
        Ok(UdpWire(socket))
    }

    pub(super) fn local_addr(&self) -> io::Result<SocketAddr> {
        self.0.local_addr()
    }
}

impl Wire for UdpWire {
    type Peer = SocketAddr;

    fn fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }

    fn receive(&mut self, buffer: &mut [u8]) -> io::Result<(usize, SocketAddr)> {
        self.0.recv_from(buffer)
    }

    fn send(&mut self, frame: &[u8], to: SocketAddr) -> io::Result<()> {
        self.0.send_to(frame, to).map(drop)
    }

    fn process(segment: &mut Segment, frame: &mut [u8], now_ns: u64) -> Option<Reply> {
        segment.process_payload(frame, now_ns)
    }

    fn foreign_frame() -> &'static [u8] {
        b"this is not EtherCAT"
    }
}

/// Whole Ethernet frames on a network interface.
pub(super) struct RawWire(OwnedFd);

/// Why a network interface cannot carry a segment.
pub(super) enum RawError {
    Unknown,
    Down,
    Loopback,
    Io(io::Error),
}

impl RawWire {
    pub(super) fn open(interface: &str) -> Result<RawWire, RawError> {
        let name = std::ffi::CString::new(interface).map_err(|_| RawError::Unknown)?;
        // SAFETY: `name` is a valid, terminated string for the duration of the call.
        let index = unsafe { libc::if_nametoindex(name.as_ptr()) };
        let index = i32::try_from(index)
            .ok()
            .filter(|index| *index > 0)
            .ok_or(RawError::Unknown)?;
        let flags = SocketFlags::NONBLOCK | SocketFlags::CLOEXEC;
        let socket = rustix::net::socket_with(AddressFamily::PACKET, SocketType::RAW, flags, None)
            .map_err(|error| RawError::Io(error.into()))?;
        let flags = interface_flags(&socket, &name).map_err(RawError::Io)?;
        if flags & libc::IFF_LOOPBACK != 0 {
            return Err(RawError::Loopback);
        }
        if flags & libc::IFF_UP == 0 {
            return Err(RawError::Down);
        }
        bind(&socket, index).map_err(RawError::Io)?;
        Ok(RawWire(socket))
    }
}

fn interface_flags(socket: &OwnedFd, name: &std::ffi::CStr) -> io::Result<i32> {
    // SAFETY: all-zero bytes are a valid `ifreq`.
    let mut request: libc::ifreq = unsafe { std::mem::zeroed() };
    // The last byte stays 0; the kernel knows no longer name.
    let room = request.ifr_name.len() - 1;
    for (slot, byte) in request.ifr_name.iter_mut().take(room).zip(name.to_bytes()) {
        *slot = *byte as libc::c_char;
    }
    // SAFETY: the descriptor is open, and `request` is the structure that this request reads and writes.
    let result = unsafe { libc::ioctl(socket.as_raw_fd(), libc::SIOCGIFFLAGS as _, &mut request) };
    if result < 0 {
        return Err(io::Error::last_os_error());
    }
    // SAFETY: the request above has filled this member of the union.
    Ok(i32::from(unsafe { request.ifr_ifru.ifru_flags }))
}

/// Receives this EtherType on this interface only; what the socket itself sends is not received.
fn bind(socket: &OwnedFd, index: i32) -> io::Result<()> {
    // SAFETY: all-zero bytes are a valid `sockaddr_ll`.
    let mut address: libc::sockaddr_ll = unsafe { std::mem::zeroed() };
    address.sll_family = libc::AF_PACKET as libc::sa_family_t;
    address.sll_protocol = ETHERTYPE.to_be();
    address.sll_ifindex = index;
    let length = size_of::<libc::sockaddr_ll>() as libc::socklen_t;
    // SAFETY: the descriptor is open; pointer and length describe `address`, which outlives the call.
    let result = unsafe { libc::bind(socket.as_raw_fd(), (&raw const address).cast(), length) };
    if result < 0 {
        Err(io::Error::last_os_error())
    } else {
        Ok(())
    }
}

impl Wire for RawWire {
    type Peer = ();

    fn fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }

    fn receive(&mut self, buffer: &mut [u8]) -> io::Result<(usize, ())> {
        let (bytes, _) = rustix::net::recv(&self.0, buffer, RecvFlags::empty())?;
        Ok((bytes, ()))
    }

    fn send(&mut self, frame: &[u8], (): ()) -> io::Result<()> {
        rustix::net::send(&self.0, frame, SendFlags::empty())?;
        Ok(())
    }

    fn process(segment: &mut Segment, frame: &mut [u8], now_ns: u64) -> Option<Reply> {
        segment.process_frame(frame, now_ns)
    }

    fn foreign_frame() -> &'static [u8] {
        // Broadcast, locally administered source, an experimental EtherType.
        b"\xFF\xFF\xFF\xFF\xFF\xFF\x02\x00\x00\x00\x00\x01\x88\xB5this is not EtherCAT, but of the least length"
    }
}
