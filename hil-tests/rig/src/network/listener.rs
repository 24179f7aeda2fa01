//! An independent ear on the network of a fleet: it writes down all that robots and mediator say.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use config::{NetConfig, SiteConfig};
use contract::{Message, decode, keys};
use sim::rt::monotonic_ns;
use zenoh::Wait;
use zenoh::pubsub::Subscriber;

use super::observations::Book;
use crate::one_robot::listener::open_session;

/// Hears all robots and the mediator under one key prefix.
pub struct FleetListener {
    book: Arc<Mutex<Book>>,
    endpoint: String,
    _subscribers: Vec<Subscriber<()>>,
    _session: zenoh::Session,
}

impl FleetListener {
    /// Opens an endpoint of its own on the loopback, to which robots and mediator connect.
    ///
    /// # Errors
    /// A sentence when the network cannot be opened.
    pub fn open(key_prefix: &str, site: &SiteConfig, nets: &[NetConfig]) -> Result<Self, String> {
        let (session, endpoint) = open_session()?;
        let book = Arc::new(Mutex::new(Book::new(site, nets)));
        let key = |key: Result<String, keys::InvalidName>| key.map_err(|error| error.to_string());
        let subscribers = vec![
            subscribe(
                &session,
                key(keys::all_states(key_prefix))?,
                &book,
                Book::state,
            )?,
            subscribe(
                &session,
                key(keys::all_reports(key_prefix))?,
                &book,
                |book, report, at_ns| book.report(&report, at_ns),
            )?,
            subscribe(
                &session,
                key(keys::to_all_robots(key_prefix))?,
                &book,
                |book, answer, at_ns| book.answer(&answer, at_ns),
            )?,
        ];
        Ok(Self {
            book,
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

    /// All that was heard; keep the guard for a short time, messages wait.
    pub fn book(&self) -> MutexGuard<'_, Book> {
        self.book.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn subscribe<M: Message + Default + 'static>(
    session: &zenoh::Session,
    key: String,
    book: &Arc<Mutex<Book>>,
    take: impl Fn(&mut Book, M, u64) + Send + Sync + 'static,
) -> Result<Subscriber<()>, String> {
    let book = Arc::clone(book);
    session
        .declare_subscriber(key)
        .callback(move |sample| {
            let at_ns = monotonic_ns();
            let message = decode::<M>(&sample.payload().to_bytes());
            let mut book = book.lock().unwrap_or_else(PoisonError::into_inner);
            match message {
                Ok(message) => take(&mut book, message, at_ns),
                Err(_) => book.malformed(),
            }
        })
        .wait()
        .map_err(|error| format!("the listener cannot subscribe: {error}"))
}
