//! The fleet's network (feature `network`): a zenoh session that is no part of any other.

use serde_json::Value;
use zenoh::Wait;

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
        set("connect/timeout_ms", 0.into())?;
        set("connect/exit_on_failure", false.into())?;
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
    use super::*;

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
