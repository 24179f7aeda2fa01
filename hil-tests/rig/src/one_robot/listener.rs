//! An independent ear on the fleet's network.

use std::collections::HashMap;
use std::net::TcpListener;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use contract::network::NetworkSettings;
use contract::wire::RobotState;
use contract::{decode, keys};
use zenoh::Wait;
use zenoh::pubsub::Subscriber;

/// The last state heard of one robot.
#[derive(Clone, Debug)]
pub struct Heard {
    /// What it said.
    pub state: RobotState,
    /// When it arrived.
    pub at: Instant,
    /// Messages heard so far.
    pub messages: u64,
}

#[derive(Debug, Default)]
struct Shared {
    robots: HashMap<String, Heard>,
    // (skill, arrival) of every change, of all robots in order.
    changes: Vec<Change>,
    malformed: u64,
}

/// A robot said that its schedule changed.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// Robot.
    pub robot_id: String,
    /// State of its machine.
    pub fsm_state: String,
    /// Area.
    pub area: String,
    /// Skill.
    pub skill: String,
    /// Where it believed to be.
    pub x_m: f64,
    /// Where it believed to be.
    pub y_m: f64,
}

/// Hears all robots under one key prefix.
pub struct Listener {
    shared: Arc<Mutex<Shared>>,
    endpoint: String,
    _subscriber: Subscriber<()>,
    _session: zenoh::Session,
}

impl Listener {
    /// Opens an endpoint of its own on the loopback, to which robots connect.
    ///
    /// # Errors
    /// A sentence when the network cannot be opened.
    pub fn open(key_prefix: &str) -> Result<Self, String> {
        let (session, endpoint) = open_session()?;
        let text =
            |error: zenoh::Error| format!("the listener's network cannot be opened: {error}");
        let shared = Arc::<Mutex<Shared>>::default();
        let ear = Arc::clone(&shared);
        let key = keys::all_states(key_prefix).map_err(|error| error.to_string())?;
        let subscriber = session
            .declare_subscriber(key)
            .callback(move |sample| hear(&mut lock(&ear), &sample.payload().to_bytes()))
            .wait()
            .map_err(text)?;
        Ok(Self {
            shared,
            endpoint,
            _subscriber: subscriber,
            _session: session,
        })
    }

    /// Where robots find it.
    #[must_use]
    pub fn endpoint(&self) -> &str {
        &self.endpoint
    }

    /// The last that was heard of a robot.
    #[must_use]
    pub fn heard(&self, robot_id: &str) -> Option<Heard> {
        lock(&self.shared).robots.get(robot_id).cloned()
    }

    /// Every change of schedule that was heard.
    #[must_use]
    pub fn changes(&self) -> Vec<Change> {
        lock(&self.shared).changes.clone()
    }

    /// Messages that were none.
    #[must_use]
    pub fn malformed(&self) -> u64 {
        lock(&self.shared).malformed
    }
}

/// A free port on the loopback, as the system picks it; another program could take it before it is used.
pub(crate) fn free_endpoint() -> Result<String, String> {
    let port = TcpListener::bind("127.0.0.1:0")
        .and_then(|socket| socket.local_addr())
        .map_err(|error| format!("no free port: {error}"))?
        .port();
    Ok(format!("tcp/127.0.0.1:{port}"))
}

/// A session that listens on the loopback, and where.
pub(crate) fn open_session() -> Result<(zenoh::Session, String), String> {
    let endpoint = free_endpoint()?;
    let settings = NetworkSettings {
        listen: vec![endpoint.clone()],
        ..NetworkSettings::default()
    };
    let session = { settings.open() }
        .map_err(|error| format!("the listener's network cannot be opened: {error}"))?;
    Ok((session, endpoint))
}

fn lock(shared: &Mutex<Shared>) -> MutexGuard<'_, Shared> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

fn hear(shared: &mut Shared, payload: &[u8]) {
    let Ok(state) = decode::<RobotState>(payload) else {
        shared.malformed += 1;
        return;
    };
    let before = shared.robots.get(&state.robot_id);
    // Levels: an older message of the same start of the robot says nothing new.
    if before.is_some_and(|heard| {
        heard.state.boot_epoch == state.boot_epoch && heard.state.sequence >= state.sequence
    }) {
        return;
    }
    if before.is_none_or(|heard| {
        heard.state.skill != state.skill || heard.state.fsm_state != state.fsm_state
    }) && !state.skill.is_empty()
    {
        let pose = state.pose.unwrap_or_default();
        shared.changes.push(Change {
            robot_id: state.robot_id.clone(),
            fsm_state: state.fsm_state.clone(),
            area: state.area.clone(),
            skill: state.skill.clone(),
            x_m: pose.x_m,
            y_m: pose.y_m,
        });
    }
    let messages = before.map_or(0, |heard| heard.messages) + 1;
    shared.robots.insert(
        state.robot_id.clone(),
        Heard {
            state,
            at: Instant::now(),
            messages,
        },
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use contract::Message;

    fn state(sequence: u64, skill: &str) -> Vec<u8> {
        RobotState {
            robot_id: "a".into(),
            sequence,
            skill: skill.into(),
            ..RobotState::default()
        }
        .encode_to_vec()
    }

    #[test]
    fn old_and_malformed_messages_change_nothing() {
        let mut shared = Shared::default();
        hear(&mut shared, &state(2, "follow"));
        hear(&mut shared, &state(1, "stop"));
        hear(&mut shared, &[0xff]);
        assert_eq!(shared.robots["a"].state.skill, "follow");
        assert_eq!((shared.changes.len(), shared.malformed), (1, 1));
        hear(&mut shared, &state(3, "stop"));
        assert_eq!(shared.changes.len(), 2);
    }
}
