//! The session on zenoh.

use contract::keys;
use zenoh::Wait;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::CongestionControl;

use super::mailbox::Inbox;
use super::session::{OpenSession, Session};
use super::settings::Settings;

/// An open session.
struct ZenohSession {
    state: Publisher<'static>,
    report: Option<Publisher<'static>>,
    _from_mediator: Option<Subscriber<()>>,
    _alive: LivelinessToken,
    // Last, so that what was declared on it goes first.
    session: zenoh::Session,
}

/// How a robot opens its session on zenoh.
#[must_use]
pub fn zenoh_session(settings: Settings) -> OpenSession {
    Box::new(move |inbox| Ok(Box::new(ZenohSession::open(&settings, inbox)?)))
}

impl ZenohSession {
    /// Opens the session and declares everything on it.
    fn open(settings: &Settings, inbox: Option<Inbox>) -> Result<Self, String> {
        let Settings {
            robot_id,
            key_prefix,
            network,
            ..
        } = settings;
        let name = |error: keys::InvalidName| error.to_string();
        let text = |error: zenoh::Error| error.to_string();
        let state_key = keys::state(key_prefix, robot_id).map_err(name)?;
        let alive_key = keys::alive(key_prefix, robot_id).map_err(name)?;
        let report_key = keys::report(key_prefix, robot_id).map_err(name)?;
        let mediator_key = keys::to_robot(key_prefix, robot_id).map_err(name)?;
        let session = network.open()?;
        let publisher = |key: String| {
            session
                .declare_publisher(key)
                .congestion_control(CongestionControl::Drop)
                .express(true)
                .wait()
                .map_err(text)
        };
        let state = publisher(state_key)?;
        let report = inbox.as_ref().map(|_| publisher(report_key)).transpose()?;
        let from_mediator = inbox
            .map(|inbox| {
                let take = move |sample: zenoh::sample::Sample| {
                    inbox.put(sample.payload().to_bytes().into_owned());
                };
                let subscriber = session.declare_subscriber(mediator_key).callback(take);
                subscriber.wait().map_err(text)
            })
            .transpose()?;
        let alive = session
            .liveliness()
            .declare_token(alive_key)
            .wait()
            .map_err(text)?;
        Ok(Self {
            state,
            report,
            _from_mediator: from_mediator,
            _alive: alive,
            session,
        })
    }
}

impl Session for ZenohSession {
    fn id(&self) -> String {
        self.session.zid().to_string()
    }

    fn send_state(&self, message: Vec<u8>) -> Result<(), String> {
        put(&self.state, message)
    }

    fn send_report(&self, message: Vec<u8>) -> Result<(), String> {
        match &self.report {
            Some(report) => put(report, message),
            None => Ok(()),
        }
    }
}

fn put(publisher: &Publisher<'static>, message: Vec<u8>) -> Result<(), String> {
    { publisher.put(message).wait() }.map_err(|error| error.to_string())
}
