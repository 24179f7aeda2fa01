//! Endpoints on the loopback interface.

use std::net::TcpListener;

use contract::network::NetworkSettings;

/// A free port on the loopback, picked by the system; another program could take it before it is used.
///
/// # Errors
/// A sentence when there is none.
pub fn free_endpoint() -> Result<String, String> {
    let port = TcpListener::bind("127.0.0.1:0")
        .and_then(|socket| socket.local_addr())
        .map_err(|error| format!("no free port: {error}"))?
        .port();
    Ok(format!("tcp/127.0.0.1:{port}"))
}

/// A session that listens on the loopback, and its endpoint.
///
/// # Errors
/// A sentence when the network cannot be opened.
pub fn open_session() -> Result<(zenoh::Session, String), String> {
    let endpoint = free_endpoint()?;
    let settings = NetworkSettings {
        listen: vec![endpoint.clone()],
        ..NetworkSettings::default()
    };
    let session = { settings.open() }
        .map_err(|error| format!("the listener's network cannot be opened: {error}"))?;
    Ok((session, endpoint))
}
