//! EtherCAT as raw Ethernet frames on a network interface of its own.

use super::link::{Link, LinkError};
use super::ring::Ring;
use super::socket::Socket;
use crate::monotonic_ns;
use std::ffi::CStr;
use std::io;
use std::mem;
use std::os::fd::{AsRawFd, FromRawFd, OwnedFd};

const ETHERTYPE: u16 = 0x88A4;
/// A wait this short is not worth sleeping: to be woken takes a good part of it.
const SHORT_NS: u64 = 20_000;

/// A link on a network interface, as an `AF_PACKET` socket that sees EtherCAT frames only.
///
/// Frames leave with ethercrab's source address `10:10:10:10:10:10` and the broadcast destination. They come back with
/// the same destination, so the interface need not be promiscuous, and with the locally-administered bit of the source
/// set. The interface's own address cannot be used: virtual interfaces already have that bit set.
pub struct RawLink {
    socket: Socket,
    /// Where the kernel has one to give.
    ring: Option<Ring>,
    /// The last frame came within [`SHORT_NS`].
    quick: bool,
    interface: String,
}

impl RawLink {
    /// Opens a link on the interface of that name. Needs CAP_NET_RAW, and the interface must be up.
    ///
    /// # Errors
    /// [`LinkError`]: no such interface, an interface that is down, or CAP_NET_RAW missing.
    pub fn open(interface: &str) -> Result<RawLink, LinkError> {
        let failed = |step| {
            let link = describe(interface);
            move |source| LinkError::System { link, step, source }
        };
        let interfaces = interface_names().map_err(failed("listing the network interfaces"))?;
        let Some(&(index, _)) = interfaces.iter().find(|(_, name)| name == interface) else {
            let names: Vec<_> = interfaces.into_iter().map(|(_, name)| name).collect();
            return Err(LinkError::NoSuchInterface {
                interface: interface.to_owned(),
                available: names.join(", "),
            });
        };
        // Without a protocol no frame arrives before `bind` names interface and EtherType.
        let flags = libc::SOCK_RAW | libc::SOCK_CLOEXEC | libc::SOCK_NONBLOCK;
        // SAFETY: no pointers are passed.
        let fd = unsafe { libc::socket(libc::AF_PACKET, flags, 0) };
        if fd < 0 {
            let error = io::Error::last_os_error();
            if error.kind() == io::ErrorKind::PermissionDenied {
                return Err(LinkError::NotPermitted {
                    interface: interface.to_owned(),
                });
            }
            return Err(failed("opening a packet socket")(error));
        }
        // SAFETY: the descriptor is new and owned by nobody else.
        let fd = unsafe { OwnedFd::from_raw_fd(fd) };
        if !is_up(&fd, interface).map_err(failed("reading the interface's flags"))? {
            return Err(LinkError::InterfaceDown {
                interface: interface.to_owned(),
            });
        }
        let ring = Ring::of(&fd).ok();
        bind(&fd, index).map_err(failed("binding"))?;
        Ok(RawLink {
            socket: Socket(fd),
            ring,
            quick: false,
            interface: interface.to_owned(),
        })
    }
}

fn describe(interface: &str) -> String {
    format!("interface {interface}")
}

/// Indices and names of the network interfaces.
fn interface_names() -> io::Result<Vec<(u32, String)>> {
    // SAFETY: takes nothing; returns null or an array that ends with index 0 and stays valid until it is freed below.
    let first = unsafe { libc::if_nameindex() };
    if first.is_null() {
        return Err(io::Error::last_os_error());
    }
    let mut names = Vec::new();
    let mut entry = first;
    loop {
        // SAFETY: `entry` is inside the array: the loop ends at its last entry.
        let libc::if_nameindex { if_index, if_name } = unsafe { *entry };
        if if_index == 0 || if_name.is_null() {
            break;
        }
        // SAFETY: every entry but the last holds a string that ends with zero.
        let name = unsafe { CStr::from_ptr(if_name) };
        names.push((if_index, name.to_string_lossy().into_owned()));
        // SAFETY: the entry just read was not the last.
        entry = unsafe { entry.add(1) };
    }
    // SAFETY: `first` came from `if_nameindex` and is freed once.
    unsafe { libc::if_freenameindex(first) };
    Ok(names)
}

fn is_up(socket: &OwnedFd, interface: &str) -> io::Result<bool> {
    // SAFETY: a structure of numbers and bytes, for which zero is valid.
    let mut request: libc::ifreq = unsafe { mem::zeroed() };
    if interface.len() >= request.ifr_name.len() {
        return Err(io::ErrorKind::InvalidInput.into());
    }
    for (to, from) in request.ifr_name.iter_mut().zip(interface.bytes()) {
        *to = from as libc::c_char;
    }
    // SAFETY: the request outlives the call and its name ends with zero.
    if unsafe { libc::ioctl(socket.as_raw_fd(), libc::SIOCGIFFLAGS as _, &mut request) } < 0 {
        return Err(io::Error::last_os_error());
    }
    // SAFETY: SIOCGIFFLAGS has filled this field of the union.
    let flags = unsafe { request.ifr_ifru.ifru_flags };
    Ok(i32::from(flags) & libc::IFF_UP != 0)
}

fn bind(socket: &OwnedFd, interface_index: u32) -> io::Result<()> {
    // SAFETY: a structure of numbers and bytes, for which zero is valid.
    let mut address: libc::sockaddr_ll = unsafe { mem::zeroed() };
    address.sll_family = libc::AF_PACKET as u16;
    address.sll_protocol = ETHERTYPE.to_be();
    address.sll_ifindex = interface_index as i32;
    let length = mem::size_of_val(&address) as libc::socklen_t;
    // SAFETY: address and length describe a whole sockaddr_ll that outlives the call.
    match unsafe { libc::bind(socket.as_raw_fd(), (&raw const address).cast(), length) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

impl Link for RawLink {
    fn send(&mut self, ethernet_frame: &[u8]) -> io::Result<()> {
        match self.socket.send(ethernet_frame) {
            // May be left over from when the interface was down. The error is reported once; this frame was not sent.
            Err(error) if error.kind() == io::ErrorKind::NetworkDown => {
                self.socket.send(ethernet_frame)
            }
            result => result,
        }
    }

    fn receive(&mut self, buffer: &mut [u8], deadline_ns: u64) -> io::Result<Option<usize>> {
        let Some(ring) = &mut self.ring else {
            return self.socket.receive(buffer, deadline_ns);
        };
        let began_ns = monotonic_ns();
        // Only where the frame before was quick: whoever has to be waited for longer gets the core.
        let look_until_ns = deadline_ns.min(began_ns + SHORT_NS * u64::from(self.quick));
        loop {
            if let Some(length) = ring.take(buffer) {
                self.quick = monotonic_ns() < began_ns + SHORT_NS;
                return Ok(Some(length));
            }
            if monotonic_ns() < look_until_ns {
                std::hint::spin_loop();
            } else if !self.socket.wait(deadline_ns)? {
                self.quick = false;
                // What came just before the deadline.
                return Ok(ring.take(buffer));
            }
        }
    }

    fn describe(&self) -> String {
        describe(&self.interface)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interface_that_does_not_exist_is_named_with_those_that_do() {
        let message = RawLink::open("no-such-if0").err().unwrap().to_string();
        assert!(message.contains("\"no-such-if0\""), "{message}");
        assert!(message.contains("lo"), "{message}");
    }

    #[test]
    fn names_that_no_interface_can_have_are_errors() {
        for name in [
            "",
            "a-name-that-is-longer-than-interfaces-have",
            "with\0zero",
        ] {
            assert!(
                matches!(RawLink::open(name), Err(LinkError::NoSuchInterface { .. })),
                "{name:?}"
            );
        }
    }
}
