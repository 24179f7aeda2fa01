//! The fleet's network (feature `network`): a zenoh session that is no part of any other, with certificates on both ends of
//! each of its links, or on the loopback only.

mod access;
mod identity;
mod threads;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use description::endpoints::Endpoint;
use serde_json::{Value, json};
use zenoh::Wait;

pub use access::Access;
pub use identity::{Identity, LONGEST_NAME, Name, Party, Request};
pub use threads::carry_links_on_one_thread;

/// Longer messages are dropped, bytes: a robot's report on a site with a thousand areas has a tenth of that.
pub const LONGEST_MESSAGE: usize = 1 << 20;

/// A client waits so long for its link, milliseconds.
const PATIENCE_MS: i64 = 3000;
/// Links of a process at once.
const MOST_SESSIONS: u32 = 4096;

/// How to take part.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NetworkSettings {
    /// Endpoints to listen on, such as `tcp/0.0.0.0:7447`.
    pub listen: Vec<String>,
    /// Endpoints to connect to. A peer that is not there yet is connected to when it comes.
    pub connect: Vec<String>,
    /// Whether peers are looked for by multicast.
    pub scouting: bool,
    /// The interface for multicast.
    pub interface: Option<String>,
    /// Who this is, and what others may say and hear. `None`: no certificates.
    pub security: Option<Security>,
    /// Whether this only asks and hears through one of the endpoints that it connects to, and needs it at once.
    pub client: bool,
}

/// Mutual TLS on every link.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Security {
    /// Who this is.
    pub identity: Identity,
    /// Who the others are. Links with whoever else has a certificate of the site carry nothing.
    pub access: Access,
}

/// A reason not to open a network as it is set.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum Unprotected {
    /// Others than this computer's programs could reach in.
    #[error("{what} reaches beyond this computer without certificates")]
    Open { what: String },
    /// Endpoints with certificates, and none to show.
    #[error("endpoint {endpoint} needs certificates, and none are named")]
    NoIdentity { endpoint: String },
    /// The other way round.
    #[error("endpoint {endpoint} has no certificates: expected `tls/` in place of its protocol")]
    NoTls { endpoint: String },
}

impl NetworkSettings {
    /// Whether every link has certificates on both ends, or stays on this computer.
    ///
    /// # Errors
    /// [`Unprotected`]: the first thing that does not.
    pub fn check(&self) -> Result<(), Unprotected> {
        let endpoints = || self.listen.iter().chain(&self.connect);
        let is_tls = |endpoint: &&String| Endpoint::parse(endpoint).is_some_and(|own| own.is_tls);
        let is_near =
            |endpoint: &&String| Endpoint::parse(endpoint).is_some_and(|own| own.is_loopback());
        if self.security.is_some() {
            let mut others = endpoints().filter(|endpoint| !is_tls(endpoint));
            return others.next().map_or(Ok(()), |endpoint| {
                let endpoint = endpoint.clone();
                Err(Unprotected::NoTls { endpoint })
            });
        }
        if let Some(endpoint) = endpoints().find(is_tls) {
            let endpoint = endpoint.clone();
            return Err(Unprotected::NoIdentity { endpoint });
        }
        if self.scouting {
            let what = "scouting".to_owned();
            return Err(Unprotected::Open { what });
        }
        match endpoints().find(|endpoint| !is_near(endpoint)) {
            Some(endpoint) => Err(Unprotected::Open {
                what: format!("endpoint {endpoint}"),
            }),
            None => Ok(()),
        }
    }

    /// Opens a session as a peer. Blocks; zenoh starts threads of its own, which inherit this thread's scheduling.
    ///
    /// # Errors
    /// A sentence that names the setting that is refused, or says why nothing can be opened.
    pub fn open(&self) -> Result<zenoh::Session, String> {
        if self.security.is_some() {
            threads::check()?;
        }
        zenoh::open(self.config()?)
            .wait()
            .map_err(|error| error.to_string())
    }

    fn config(&self) -> Result<zenoh::Config, String> {
        let mut config = zenoh::Config::default();
        let mut set = |key: &str, value: Value| {
            config
                .insert_json5(key, &value.to_string())
                .map_err(|error| {
                    format!("fleet network setting {key} = {value} is refused: {error}")
                })
        };
        let mode = if self.client { "client" } else { "peer" };
        set("mode", mode.into())?;
        set("listen/endpoints", self.listen.clone().into())?;
        set("connect/endpoints", self.connect.clone().into())?;
        // Retried for ever in the background: the session opens at once, and finds a restarted peer within a second.
        let timeout_ms = if self.client { PATIENCE_MS } else { -1 };
        set("connect/timeout_ms", timeout_ms.into())?;
        set("connect/exit_on_failure", self.client.into())?;
        let retry = serde_json::json!({
            "period_init_ms": 200, "period_max_ms": 1000, "period_increase_factor": 1.5
        });
        set("connect/retry", retry)?;
        // A thousand robots, each twice while it gets another certificate, and operators. zenoh's own bound is a thousand in all.
        set("transport/unicast/max_sessions", MOST_SESSIONS.into())?;
        // A mediator answers many robots in one burst. With the usual two batches, and a millisecond for a sender that
        // was not scheduled, much of that would be dropped.
        set("transport/link/tx/queue/size/data", 16.into())?;
        set(
            "transport/link/tx/queue/congestion_control/drop/wait_before_drop",
            5_000.into(),
        )?;
        // Who does not read what must not be dropped is cut off soon: meanwhile the one thread waits that carries all links.
        set(
            "transport/link/tx/queue/congestion_control/block/wait_before_close",
            500_000.into(),
        )?;
        // What comes in fragments is put together in memory before anybody can look at it.
        set("transport/link/rx/max_message_size", LONGEST_MESSAGE.into())?;
        set("scouting/multicast/enabled", self.scouting.into())?;
        set("scouting/gossip/enabled", self.scouting.into())?;
        if let Some(interface) = &self.interface {
            set("scouting/multicast/interface", interface.clone().into())?;
        }
        if let Some(Security { identity, access }) = &self.security {
            set("transport/link/protocols", json!(["tls"]))?;
            // What a host is called proves nothing: the name in its certificate does, by the access control below.
            set("transport/link/tls/verify_name_on_connect", false.into())?;
            set("transport/link/tls/enable_mtls", true.into())?;
            set("transport/link/tls/close_link_on_expiration", true.into())?;
            let access = access.config().map_err(|error| error.to_string())?;
            set("access_control", access)?;
            let (key, own) = (identity.key(), identity.certificate());
            for (setting, secret) in [
                ("root_ca_certificate_base64", identity.authority()),
                ("listen_private_key_base64", key),
                ("listen_certificate_base64", own),
                ("connect_private_key_base64", key),
                ("connect_certificate_base64", own),
            ] {
                let value = json!(BASE64.encode(secret)).to_string();
                // Without the value, which must not get into a log.
                { config.insert_json5(&format!("transport/link/tls/{setting}"), &value) }
                    .map_err(|_| format!("fleet network setting {setting} is refused"))?;
            }
        }
        Ok(config)
    }
}

#[cfg(test)]
mod tests {
    use std::net::{Ipv4Addr, TcpListener};
    use std::time::{Duration, Instant};

    use super::*;

    /// A port that was free a moment ago. The address is this process's own: on the common one any connection may take the port.
    fn endpoint() -> String {
        let [_, _, high, low] = std::process::id().to_be_bytes();
        let own = Ipv4Addr::new(127, high, low, 1);
        let address = TcpListener::bind((own, 0)).and_then(|socket| socket.local_addr());
        format!("tcp/{}", address.expect("a port is free"))
    }

    #[test]
    fn a_peer_that_comes_later_is_connected_to_when_it_comes() {
        let endpoint = endpoint();
        let connect = NetworkSettings {
            connect: vec![endpoint.clone()],
            ..NetworkSettings::default()
        };
        let early = Instant::now();
        let robot = connect.open().expect("it opens although nobody is there");
        assert!(early.elapsed() < Duration::from_secs(5), "it does not wait");
        let subscriber = robot.declare_subscriber("late/word").wait();
        let subscriber = subscriber.expect("it subscribes");
        std::thread::sleep(Duration::from_millis(500));
        let listen = NetworkSettings {
            listen: vec![endpoint],
            ..NetworkSettings::default()
        };
        let mediator = listen.open().expect("the port is still free");
        let deadline = Instant::now() + Duration::from_secs(20);
        loop {
            mediator.put("late/word", "here").wait().expect("it sends");
            let heard = subscriber.recv_timeout(Duration::from_millis(100));
            if heard.is_ok_and(|heard| heard.is_some()) {
                break;
            }
            assert!(Instant::now() < deadline, "they never met");
        }
    }

    #[test]
    fn only_what_stays_on_this_computer_goes_without_certificates() {
        let with = |endpoint: &str| NetworkSettings {
            connect: vec![endpoint.to_owned()],
            ..NetworkSettings::default()
        };
        for near in [
            "tcp/127.0.0.1:7447",
            "tcp/127.1.2.3:1",
            "tcp/[::1]:7447",
            "tcp/localhost:7447",
        ] {
            assert_eq!(with(near).check(), Ok(()), "{near}");
        }
        for far in [
            "tcp/0.0.0.0:7447",
            "tcp/[::]:7447",
            "tcp/192.168.1.2:7447",
            "tcp/hall:7447",
            "tcp/localhost.hall:1",
            "x",
        ] {
            let refused = with(far).check().expect_err(far).to_string();
            assert!(refused.contains(far), "{refused}");
        }
        assert!(matches!(
            with("tls/127.0.0.1:1").check(),
            Err(Unprotected::NoIdentity { .. })
        ));
        let scouting = NetworkSettings {
            scouting: true,
            ..NetworkSettings::default()
        };
        assert!(matches!(scouting.check(), Err(Unprotected::Open { .. })));
    }

    #[test]
    fn a_bad_endpoint_is_named() {
        let settings = NetworkSettings {
            listen: vec!["nonsense".into()],
            ..NetworkSettings::default()
        };
        let error = settings.config().expect_err("refused");
        assert!(
            error.contains("listen/endpoints") && error.contains("nonsense"),
            "{error}"
        );
    }
}
