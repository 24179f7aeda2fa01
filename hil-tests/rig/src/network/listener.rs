//! An independent listener on the network: records all that robots and mediator say.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use config::{NetConfig, SiteConfig};
use contract::{Message, decode, keys};
use sim::rt::monotonic_ns;
use zenoh::Wait;
use zenoh::pubsub::Subscriber;

use super::endpoint::open_session;
use super::observations::Observations;

/// Hears all robots and the mediator under one key prefix.
pub struct Listener {
    observations: Arc<Mutex<Observations>>,
    endpoint: String,
    _subscribers: Vec<Subscriber<()>>,
    _session: zenoh::Session,
}

impl Listener {
    /// Opens an endpoint of its own on the loopback, to which robots and mediator connect.
    ///
    /// # Errors
    /// A sentence when the network cannot be opened.
    pub fn open(key_prefix: &str, site: &SiteConfig, nets: &[NetConfig]) -> Result<Self, String> {
        let (session, endpoint) = open_session()?;
        let observations = Arc::new(Mutex::new(Observations::new(site, nets)));
        let key = |key: Result<String, keys::InvalidName>| key.map_err(|error| error.to_string());
        let subscribers = vec![
            subscribe(
                &session,
                key(keys::all_states(key_prefix))?,
                &observations,
                Observations::state,
            )?,
            subscribe(
                &session,
                key(keys::all_reports(key_prefix))?,
                &observations,
                |observations, report, at_ns| observations.report(&report, at_ns),
            )?,
            subscribe(
                &session,
                key(keys::to_all_robots(key_prefix))?,
                &observations,
                |observations, answer, at_ns| observations.answer(&answer, at_ns),
            )?,
        ];
        Ok(Self {
            observations,
            endpoint,
            _subscribers: subscribers,
            _session: session,
        })
    }

    /// Where robots and mediator find it.
    #[must_use]
    pub fn endpoint(&self) -> &str {
        &self.endpoint
    }

    /// All that was heard. Hold the guard only briefly: messages wait for it.
    pub fn observations(&self) -> MutexGuard<'_, Observations> {
        self.observations
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

fn subscribe<M: Message + Default + 'static>(
    session: &zenoh::Session,
    key: String,
    observations: &Arc<Mutex<Observations>>,
    take: impl Fn(&mut Observations, M, u64) + Send + Sync + 'static,
) -> Result<Subscriber<()>, String> {
    let observations = Arc::clone(observations);
    session
        .declare_subscriber(key)
        .callback(move |sample| {
            let at_ns = monotonic_ns();
            let message = decode::<M>(&sample.payload().to_bytes());
            let mut observations = observations.lock().unwrap_or_else(PoisonError::into_inner);
            match message {
                Ok(message) => take(&mut observations, message, at_ns),
                Err(_) => observations.note_malformed(at_ns),
            }
        })
        .wait()
        .map_err(|error| format!("the listener cannot subscribe: {error}"))
}
