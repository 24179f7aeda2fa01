//! EtherCAT over UDP port 34980: the same datagrams without an Ethernet header, and without privileges.

use super::link::{Link, LinkError};
use super::socket::Socket;
use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};

const ETHERNET_HEADER: usize = 14;

/// Put in front of what arrives. The source address has the locally-administered bit set, as the first SubDevice of a
/// segment leaves it.
const HEADER_FROM_SEGMENT: [u8; ETHERNET_HEADER] = [
    0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x12, 0x10, 0x10, 0x10, 0x10, 0x10, 0x88, 0xA4,
];

/// A link to a segment that is reached over UDP. A UDP payload is one EtherCAT frame.
pub struct UdpLink {
    socket: Socket,
    segment: SocketAddr,
}

impl UdpLink {
    /// The port that IANA has assigned to EtherCAT.
    pub const PORT: u16 = 34980;

    /// Opens a link to the segment at `segment`. Nothing is sent yet; bring-up tells whether a segment answers.
    ///
    /// # Errors
    /// [`LinkError::System`] when no local port can be had or the address cannot be reached from here.
    pub fn open(segment: SocketAddr) -> Result<UdpLink, LinkError> {
        let failed = |step| {
            move |source| LinkError::System {
                link: describe(segment),
                step,
                source,
            }
        };
        let any: SocketAddr = match segment {
            SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
            SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
        };
        let socket = UdpSocket::bind(any).map_err(failed("binding a local port"))?;
        // Connected, so that only the segment's answers arrive, and "nobody listens there" is reported.
        socket.connect(segment).map_err(failed("connecting"))?;
        Ok(UdpLink {
            socket: Socket(socket.into()),
            segment,
        })
    }
}

fn describe(segment: SocketAddr) -> String {
    format!("UDP {segment}")
}

impl Link for UdpLink {
    fn send(&mut self, ethernet_frame: &[u8]) -> io::Result<()> {
        let datagrams = ethernet_frame
            .get(ETHERNET_HEADER..)
            .ok_or(io::ErrorKind::InvalidInput)?;
        match self.socket.send(datagrams) {
            // The network's answer to an earlier frame. The error is reported once; this frame was not sent.
            Err(error) if error.kind() == io::ErrorKind::ConnectionRefused => {
                self.socket.send(datagrams)
            }
            result => result,
        }
    }

    fn receive(&mut self, buffer: &mut [u8], deadline_ns: u64) -> io::Result<Option<usize>> {
        let Some((header, datagrams)) = buffer.split_at_mut_checked(ETHERNET_HEADER) else {
            return Err(io::ErrorKind::InvalidInput.into());
        };
        header.copy_from_slice(&HEADER_FROM_SEGMENT);
        Ok(self
            .socket
            .receive(datagrams, deadline_ns)?
            .map(|received| received + ETHERNET_HEADER))
    }

    fn describe(&self) -> String {
        describe(self.segment)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monotonic_ns;

    fn loopback() -> (UdpSocket, UdpLink) {
        let segment = UdpSocket::bind("127.0.0.1:0").unwrap();
        let link = UdpLink::open(segment.local_addr().unwrap()).unwrap();
        (segment, link)
    }

    #[test]
    fn the_ethernet_header_is_stripped_and_added() {
        let (segment, mut link) = loopback();
        let mut frame = [0u8; 30];
        frame[14..].copy_from_slice(b"EtherCAT frame..");
        link.send(&frame).unwrap();
        let mut at_segment = [0u8; 64];
        let (received, main_device) = segment.recv_from(&mut at_segment).unwrap();
        assert_eq!(&at_segment[..received], b"EtherCAT frame..");

        segment.send_to(b"answer", main_device).unwrap();
        let mut buffer = [0u8; 64];
        let length = link
            .receive(&mut buffer, monotonic_ns() + 1_000_000_000)
            .unwrap()
            .unwrap();
        assert_eq!(&buffer[..14], &HEADER_FROM_SEGMENT);
        assert_eq!(&buffer[14..length], b"answer");
    }

    #[test]
    fn waiting_ends_at_the_deadline_and_not_before() {
        let (_segment, mut link) = loopback();
        let deadline_ns = monotonic_ns() + 20_000_000;
        assert_eq!(link.receive(&mut [0u8; 64], deadline_ns).unwrap(), None);
        assert!(monotonic_ns() >= deadline_ns);
    }

    #[test]
    fn a_port_where_nobody_listens_is_reported() {
        let (segment, mut link) = loopback();
        drop(segment);
        link.send(&[0u8; 30]).unwrap();
        let error = link
            .receive(&mut [0u8; 64], monotonic_ns() + 1_000_000_000)
            .unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::ConnectionRefused);
        // The error must not cost the frames after it.
        link.send(&[0u8; 30]).unwrap();
        link.send(&[0u8; 30]).unwrap();
    }

    #[test]
    fn too_short_buffers_are_errors() {
        let (_segment, mut link) = loopback();
        assert!(link.send(&[0u8; 13]).is_err());
        assert!(link.receive(&mut [0u8; 13], 0).is_err());
    }
}
