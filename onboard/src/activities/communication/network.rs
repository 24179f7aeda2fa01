//! The robot's session on the fleet's network: what it publishes, and the box that the mediator's messages wait in.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use contract::keys;
use zenoh::Wait;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::CongestionControl;

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

/// An open network; closes when it is dropped.
pub(super) struct Network {
    state: Publisher<'static>,
    report: Option<Publisher<'static>>,
    _from_mediator: Option<Subscriber<()>>,
    _alive: LivelinessToken,
    // Last, so that what was declared on it goes first.
    session: zenoh::Session,
}

impl Network {
    /// Opens the session and declares everything on it. `mediator` is the box for the mediator's messages and what they
    /// wake, on a managed site.
    ///
    /// # Errors
    /// A sentence.
    pub(super) fn open(
        settings: &Settings,
        mediator: Option<(Mailbox, News)>,
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
        let report = mediator
            .as_ref()
            .map(|_| publisher(report_key))
            .transpose()?;
        let from_mediator = mediator
            .map(|(mailbox, news)| {
                let take = move |sample: zenoh::sample::Sample| {
                    mailbox.put(sample.payload().to_bytes().into_owned());
                    news.tell();
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

    /// The session's own name.
    pub(super) fn id(&self) -> String {
        self.session.zid().to_string()
    }

    /// Sends the robot's state to everybody.
    pub(super) fn send_state(&self, message: Vec<u8>) -> Result<(), String> {
        put(&self.state, message)
    }

    /// Sends a report to the mediator.
    pub(super) fn send_report(&self, message: Vec<u8>) -> Result<(), String> {
        match &self.report {
            Some(report) => put(report, message),
            None => Ok(()),
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
