//! Endpoints on the loopback interface.

use std::net::{Ipv4Addr, TcpListener};
use std::sync::atomic::{AtomicU8, Ordering};

use contract::network::NetworkSettings;

/// Ports below those that Linux gives to whoever asks for any: a program that listens on all addresses has none of them by chance, and
/// none is gone between being found free and being listened on.
const PORTS: std::ops::Range<u16> = 20_000..30_000;

/// So many endpoints are tried for a session.
const TRIES: usize = 5;

/// A free endpoint on the loopback. It has an address of its own: on the common one, the port of a program that is started again may
/// meanwhile be another one's, or that of any connection.
///
/// # Errors
/// A sentence when there is none.
pub fn free_endpoint() -> Result<String, String> {
    static LAST: AtomicU8 = AtomicU8::new(0);
    let [_, _, high, low] = std::process::id().to_be_bytes();
    let own = Ipv4Addr::new(
        127,
        high,
        low,
        1 + LAST.fetch_add(1, Ordering::Relaxed) % 254,
    );
    let mut refused = String::new();
    for port in PORTS {
        match TcpListener::bind((own, port)) {
            Ok(_) => return Ok(format!("tcp/{own}:{port}")),
            Err(error) => refused = error.to_string(),
        }
    }
    Err(format!("no free port: {refused}"))
}

/// A session that listens on the loopback, and its endpoint.
///
/// # Errors
/// A sentence when the network cannot be opened.
pub fn open_session() -> Result<(zenoh::Session, String), String> {
    let mut refused = String::new();
    // A child that is just being started has a copy of what found the endpoint free, until it is its own program.
    for _ in 0..TRIES {
        let endpoint = free_endpoint()?;
        let settings = NetworkSettings {
            listen: vec![endpoint.clone()],
            ..NetworkSettings::default()
        };
        match settings.open() {
            Ok(session) => return Ok((session, endpoint)),
            Err(error) => refused = error.to_string(),
        }
    }
    Err(format!(
        "the listener's network cannot be opened: {refused}"
    ))
}
