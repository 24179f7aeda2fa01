//! Endpoints of the fleet's network: the one rule for files, commands and the network itself.

use std::net::IpAddr;

/// An endpoint, as `tcp/192.168.1.20:7447`: where one listens, or connects to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Endpoint<'a> {
    /// Whether both ends show certificates.
    pub is_tls: bool,
    /// A name or an address.
    pub host: &'a str,
    /// TCP port.
    pub port: u16,
}

impl<'a> Endpoint<'a> {
    /// Reads an endpoint over one of the transports that are built in. What stands behind `?` or `#` is for zenoh.
    #[must_use]
    pub fn parse(text: &'a str) -> Option<Self> {
        let (protocol, address) = text.split_once('/')?;
        let is_tls = match protocol {
            "tcp" => false,
            "tls" => true,
            _ => return None,
        };
        let address = address.split(['?', '#']).next().unwrap_or_default();
        let (host, port) = address.rsplit_once(':')?;
        let port = port.parse().ok()?;
        (!host.is_empty()).then_some(Self { is_tls, host, port })
    }

    /// Whether only programs of this computer are at its other end.
    #[must_use]
    pub fn is_loopback(&self) -> bool {
        let host = self.host.trim_start_matches('[').trim_end_matches(']');
        host == "localhost" || host.parse().is_ok_and(|host: IpAddr| host.is_loopback())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endpoints_are_read_and_the_loopback_is_known() {
        let tls = Endpoint::parse("tls/[::]:7447?so_rcvbuf=1").expect("an endpoint");
        assert_eq!((tls.is_tls, tls.host, tls.port), (true, "[::]", 7447));
        let is_near = |text: &str| Endpoint::parse(text).map(|endpoint| endpoint.is_loopback());
        for near in [
            "tcp/127.0.0.1:1",
            "tcp/127.1.2.3:1",
            "tls/[::1]:1",
            "tcp/localhost:1",
        ] {
            assert_eq!(is_near(near), Some(true), "{near}");
        }
        for far in [
            "tcp/0.0.0.0:1",
            "tcp/[::]:1",
            "tls/192.168.1.2:1",
            "tcp/hall:1",
            "tcp/localhost.hall:1",
        ] {
            assert_eq!(is_near(far), Some(false), "{far}");
        }
        for bad in [
            "",
            "x",
            "tcp",
            "tcp/",
            "tcp/:1",
            "tcp/a",
            "tcp/a:b",
            "tcp/a:65536",
            "udp/127.0.0.1:1",
        ] {
            assert_eq!(Endpoint::parse(bad), None, "{bad}");
        }
    }
}
