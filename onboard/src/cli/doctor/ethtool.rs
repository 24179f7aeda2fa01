//! What `ethtool -c` prints, asked of the kernel.

use std::io;

use rustix::io::Errno;
use rustix::ioctl::{Updater, ioctl};
use rustix::net::{AddressFamily, SocketType, socket};

/// `SIOCETHTOOL` of `linux/sockios.h`.
const ETHTOOL: rustix::ioctl::Opcode = 0x8946;
/// `ETHTOOL_GCOALESCE` of `linux/ethtool.h`.
const GET_COALESCE: u32 = 0x0e;

/// How long an interface keeps frames before it tells of them, µs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coalescing {
    /// A frame that has come.
    pub receive_us: u32,
    /// The end of a frame that was sent.
    pub send_us: u32,
}

/// `struct ethtool_coalesce`: the number of the question, then 22 numbers, of which these two are wanted.
#[repr(C)]
struct Coalesce {
    command: u32,
    receive_us: u32,
    receive_frames: u32,
    receive_us_interrupt: u32,
    receive_frames_interrupt: u32,
    send_us: u32,
    others: [u32; 17],
}

/// `struct ifreq`: the interface's name, and here a pointer; as long as its longest variant.
#[repr(C)]
struct Request {
    name: [u8; libc::IFNAMSIZ],
    data: *mut Coalesce,
    rest: [u8; size_of::<libc::ifreq>() - libc::IFNAMSIZ - size_of::<*mut Coalesce>()],
}

const _: () = assert!(size_of::<Request>() == size_of::<libc::ifreq>());

/// How the interface saves interrupts; none where it does not.
///
/// # Errors
/// The system's, such as that there is no such interface.
pub fn coalescing(interface: &str) -> io::Result<Option<Coalescing>> {
    let mut answer = Coalesce {
        command: GET_COALESCE,
        receive_us: 0,
        receive_frames: 0,
        receive_us_interrupt: 0,
        receive_frames_interrupt: 0,
        send_us: 0,
        others: [0; 17],
    };
    let mut request = Request {
        name: [0; libc::IFNAMSIZ],
        data: &raw mut answer,
        rest: [0; _],
    };
    if interface.len() >= request.name.len() {
        return Err(io::ErrorKind::InvalidInput.into());
    }
    request.name[..interface.len()].copy_from_slice(interface.as_bytes());
    let any = socket(AddressFamily::INET, SocketType::DGRAM, None)?;
    // SAFETY: this question takes a `struct ifreq` whose pointer leads to a `struct ethtool_coalesce`, which it fills; both have the
    // kernel's layout and outlive the call.
    let asked = unsafe { ioctl(&any, Updater::<ETHTOOL, Request>::new(&mut request)) };
    match asked {
        Ok(()) => Ok(Some(Coalescing {
            receive_us: answer.receive_us,
            send_us: answer.send_us,
        })),
        Err(Errno::OPNOTSUPP) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loopback_saves_no_interrupts_and_no_interface_is_an_error() {
        assert_eq!(coalescing("lo").expect("it is there"), None);
        let error = coalescing("no-such-one").expect_err("it is not");
        assert_eq!(error.raw_os_error(), Some(libc::ENODEV));
        coalescing("a-name-that-is-too-long").expect_err("it is none");
    }
}
