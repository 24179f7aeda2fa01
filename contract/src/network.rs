//! The fleet's network (feature `network`): a zenoh session that is no part of any other.

use serde_json::Value;
use zenoh::Wait;

/// Longer messages are dropped, bytes: a robot's report on a site with a thousand areas has a tenth of that.
pub const LONGEST_MESSAGE: usize = 1 << 20;

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
}

impl NetworkSettings {
    /// Opens a session as a peer. Blocks; zenoh starts threads of its own, which inherit this thread's scheduling.
    ///
    /// # Errors
    /// A sentence that names the setting that is refused, or says why nothing can be opened.
    pub fn open(&self) -> Result<zenoh::Session, String> {
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
        set("mode", "peer".into())?;
        set("listen/endpoints", self.listen.clone().into())?;
        set("connect/endpoints", self.connect.clone().into())?;
        // Retried for ever in the background: the session opens at once, and finds a restarted peer within a second.
        set("connect/timeout_ms", (-1).into())?;
        set("connect/exit_on_failure", false.into())?;
        let retry = serde_json::json!({
            "period_init_ms": 200, "period_max_ms": 1000, "period_increase_factor": 1.5
        });
        set("connect/retry", retry)?;
        // A mediator answers many robots in one burst. With the usual two batches, and a millisecond for a sender that
        // was not scheduled, much of that would be dropped.
        set("transport/link/tx/queue/size/data", 16.into())?;
        set(
            "transport/link/tx/queue/congestion_control/drop/wait_before_drop",
            5_000.into(),
        )?;
        // What comes in fragments is put together in memory before anybody can look at it.
        set("transport/link/rx/max_message_size", LONGEST_MESSAGE.into())?;
        set("scouting/multicast/enabled", self.scouting.into())?;
        set("scouting/gossip/enabled", self.scouting.into())?;
        if let Some(interface) = &self.interface {
            set("scouting/multicast/interface", interface.clone().into())?;
        }
        Ok(config)
    }
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;
    use std::time::{Duration, Instant};

    use super::*;

    /// A port that was free a moment ago.
    fn endpoint() -> String {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port is free");
        let port = listener.local_addr().expect("it is bound").port();
        format!("tcp/127.0.0.1:{port}")
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
