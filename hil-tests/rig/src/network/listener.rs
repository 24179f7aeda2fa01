//! An independent listener on the network: records all that robots and mediator say.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use config::{NetConfig, SiteConfig};
use contract::network::{Access, Identity, NetworkSettings, Security};
use contract::{Message, decode, keys};
use sim::rt::monotonic_ns;
use zenoh::Wait;
use zenoh::pubsub::Subscriber;

use super::endpoint::open_session;
use super::observations::Observations;

/// A mediator is there after this time.
const PATIENCE: Duration = Duration::from_secs(15);

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
        Self::on(session, endpoint, key_prefix, site, nets)
    }

    /// Hears everybody through the mediator, as an operator. Waits until the mediator is there.
    ///
    /// # Errors
    /// A sentence when it does not come.
    pub fn through(
        mediator: &str,
        operator: Identity,
        key_prefix: &str,
        site: &SiteConfig,
        nets: &[NetConfig],
    ) -> Result<Self, String> {
        let settings = NetworkSettings {
            connect: vec![mediator.to_owned()],
            security: Some(Security {
                identity: operator,
                access: Access::MediatorOnly,
            }),
            client: true,
            ..NetworkSettings::default()
        };
        let until = Instant::now() + PATIENCE;
        let session = loop {
            match settings.open() {
                Ok(session) => break session,
                Err(error) if Instant::now() >= until => {
                    return Err(format!("the listener cannot reach the mediator: {error}"));
                }
                Err(_) => {}
            }
        };
        Self::on(session, mediator.to_owned(), key_prefix, site, nets)
    }

    fn on(
        session: zenoh::Session,
        endpoint: String,
        key_prefix: &str,
        site: &SiteConfig,
        nets: &[NetConfig],
    ) -> Result<Self, String> {
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
