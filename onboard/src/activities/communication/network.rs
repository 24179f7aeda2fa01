//! The robot's session on the fleet's network: what it publishes, and the box that the mediator's messages wait in. Whatever
//! carries it is a [`Session`]; the product's is zenoh.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use contract::keys;
use zenoh::Wait;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::CongestionControl;

use super::credentials::{Attention, Credentials, Renewal};
use super::settings::Settings;
use crate::activities::news::News;

/// Messages that may wait. Each carries the whole state, so a full box drops the oldest.
const WAITING: usize = 16;

/// Messages of the mediator on their way from the network's threads to ours.
#[derive(Clone, Debug, Default)]
pub(super) struct Mailbox(Arc<Mutex<Letters>>);

#[derive(Debug, Default)]
struct Letters {
    waiting: VecDeque<Vec<u8>>,
    dropped: u64,
}

impl Mailbox {
    pub(super) fn put(&self, letter: Vec<u8>) {
        let mut letters = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if letters.waiting.len() == WAITING {
            letters.waiting.pop_front();
            letters.dropped += 1;
        }
        letters.waiting.push_back(letter);
    }

    pub(super) fn take(&self) -> Option<Vec<u8>> {
        let mut letters = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        letters.waiting.pop_front()
    }

    /// Messages dropped so far.
    pub(super) fn dropped(&self) -> u64 {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .dropped
    }
}

/// Where a session on the network puts the mediator's messages.
#[derive(Clone, Debug)]
pub struct Inbox {
    pub(super) mailbox: Mailbox,
    pub(super) news: News,
}

impl Inbox {
    /// Puts a message in, and wakes the activity. From any thread that may take a lock.
    pub fn put(&self, message: Vec<u8>) {
        self.mailbox.put(message);
        self.news.tell();
    }
}

/// An open session, on which the robot is alive; closes when it is dropped.
pub trait Session: Send {
    /// The session's own name.
    fn id(&self) -> String;

    /// Sends the robot's state to everybody. Does not wait.
    ///
    /// # Errors
    /// A sentence.
    fn send_state(&self, message: Vec<u8>) -> Result<(), String>;

    /// Sends a report to the mediator. Does not wait.
    ///
    /// # Errors
    /// A sentence.
    fn send_report(&self, message: Vec<u8>) -> Result<(), String>;

    /// Whether anybody is at its other end.
    fn is_linked(&self) -> bool {
        true
    }

    /// Looks after its certificate, if it has one. Does not wait.
    fn attend(&mut self, _now_ns: u64) -> Attention {
        Attention::None
    }
}

/// Opens a session, at first and after each failure. On a managed site the inbox takes the mediator's messages.
pub type OpenSession = Box<dyn FnMut(Option<Inbox>) -> Result<Box<dyn Session>, String> + Send>;

/// A session on zenoh.
struct ZenohSession {
    state: Publisher<'static>,
    report: Option<Publisher<'static>>,
    _from_mediator: Option<Subscriber<()>>,
    _alive: LivelinessToken,
    renewal: Option<Renewal>,
    // Last, so that what was declared on it goes first.
    session: zenoh::Session,
}

/// How a robot opens its session on zenoh.
#[must_use]
pub fn zenoh_session(settings: Settings) -> OpenSession {
    let credentials = { settings.keys.as_ref() }
        .map(|path| Credentials::new(path.into(), settings.robot_id.clone()));
    Box::new(move |inbox| {
        let session = ZenohSession::open(&settings, credentials.clone(), inbox)?;
        Ok(Box::new(session))
    })
}

impl ZenohSession {
    /// Opens the session and declares everything on it.
    fn open(
        settings: &Settings,
        credentials: Option<Credentials>,
        inbox: Option<Inbox>,
    ) -> Result<Self, String> {
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
        let (mut network, mut renewal) = (network.clone(), None);
        if let Some(credentials) = credentials {
            network.security = Some(credentials.security()?);
            renewal = Some(Renewal::new(credentials, key_prefix, robot_id)?);
        }
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
            renewal,
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

    fn is_linked(&self) -> bool {
        self.session.info().peers_zid().wait().next().is_some()
    }

    fn attend(&mut self, now_ns: u64) -> Attention {
        match &mut self.renewal {
            Some(renewal) => renewal.attend(&self.session, now_ns),
            None => Attention::None,
        }
    }
}

fn put(publisher: &Publisher<'static>, message: Vec<u8>) -> Result<(), String> {
    { publisher.put(message).wait() }.map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_mailbox_lets_the_oldest_go_and_counts_it() {
        let mailbox = Mailbox::default();
        for number in 0..=WAITING {
            mailbox.put(vec![u8::try_from(number).expect("small")]);
        }
        assert_eq!(mailbox.dropped(), 1);
        assert_eq!(mailbox.take(), Some(vec![1]));
        assert_eq!(std::iter::from_fn(|| mailbox.take()).count(), WAITING - 1);
    }
}
