//! The mediator's session on the fleet's network, and all that it hears and says there. Where the site has keys, the session is
//! opened anew when the list of identities changes, and long before its own certificate ends: a link is cut for a moment, and
//! made again by its other end.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use contract::network::{LONGEST_MESSAGE, NetworkSettings};
use contract::wire::{CertificateRequest, MediatorReport};
use contract::{Message, decode, keys};
use rustix::time::{ClockId, clock_gettime};
use tokio::sync::mpsc::Sender;
use zenoh::Wait;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::CongestionControl;
use zenoh::query::{Query, Queryable};
use zenoh::sample::SampleKind;

use super::checked::{part_before_last, report_in};
use super::inbox::Inbox;
use super::shared::Shared;
use crate::keys::{Keys, Registry, Renewals};

/// How the mediator takes part in the fleet.
#[derive(Clone, Debug)]
pub struct Settings {
    /// First part of every key.
    pub key_prefix: String,
    /// The network, without who is who.
    pub network: NetworkSettings,
    /// Who is who; `None`: everybody on the network may say what they like.
    pub keys: Option<Keys>,
}

/// Where the network puts what it hears.
#[derive(Clone)]
pub(super) struct Ears {
    pub(super) inbox: Arc<Inbox>,
    pub(super) shared: Arc<Shared>,
    /// Questions of operators, and who they are.
    pub(super) questions: Sender<(String, Query)>,
    /// Of this process.
    pub(super) instance: u64,
}

/// An open session, and everything declared on it.
pub(super) struct Network {
    key_prefix: String,
    publishers: HashMap<String, Publisher<'static>>,
    protection: Option<Protection>,
    // In this order they are dropped.
    _alive: [LivelinessToken; 2],
    _others: Subscriber<()>,
    _reports: Subscriber<()>,
    _asked: Vec<Queryable<()>>,
    session: zenoh::Session,
}

/// By what the session's certificates were made.
struct Protection {
    keys: Keys,
    registry: Registry,
    /// When the mediator's own is half over, on [`clock`].
    renew_at: Duration,
}

/// Time since the computer was switched on, while it slept too: a certificate grows old meanwhile.
fn clock() -> Duration {
    let now = clock_gettime(ClockId::Boottime);
    Duration::try_from(now).unwrap_or_default()
}

impl Protection {
    fn is_over(&self) -> Result<bool, String> {
        Ok(clock() >= self.renew_at || self.keys.registry()? != self.registry)
    }
}

impl Network {
    /// Opens the session and declares everything on it.
    pub(super) fn open(settings: &Settings, ears: &Ears) -> Result<Self, String> {
        let text = |error: zenoh::Error| error.to_string();
        let name = |error: keys::InvalidName| error.to_string();
        let prefix = &settings.key_prefix;
        let alive_keys = [
            keys::mediator_alive(prefix).map_err(name)?,
            keys::mediator_instance(prefix, ears.instance).map_err(name)?,
        ];
        let mediators = keys::all_mediator_instances(prefix).map_err(name)?;
        let reports = keys::all_reports(prefix).map_err(name)?;
        let mut network = settings.network.clone();
        let snapshot = { settings.keys.as_ref() }
            .map(|keys| Ok::<_, String>((keys, keys.snapshot()?)))
            .transpose()?;
        if let Some((_, snapshot)) = &snapshot {
            network.security = Some(snapshot.security(prefix)?);
        }
        let session = network
            .open()
            .map_err(|error| format!("the fleet network cannot be opened: {error}"))?;
        let own = ears.clone();
        let subscriber = session
            .declare_subscriber(reports)
            .callback(move |sample| own.hear(sample.key_expr().as_str(), sample.payload()))
            .wait()
            .map_err(text)?;
        let (mut asked, mut protection) = (Vec::new(), None);
        if let Some((keys_of_site, snapshot)) = snapshot {
            let registry = snapshot.registry().clone();
            let half = Duration::from_secs_f64(registry.days * 43_200.0);
            protection = Some(Protection {
                keys: keys_of_site.clone(),
                registry,
                renew_at: clock() + half,
            });
            let certificates = keys::all_certificates(prefix).map_err(name)?;
            let renewals = Mutex::new(Renewals::new(snapshot));
            let renew = move |query: Query| answer_renewal(&renewals, &query);
            asked.push(
                { session.declare_queryable(certificates).callback(renew) }
                    .wait()
                    .map_err(text)?,
            );
            let questions = keys::all_questions(prefix).map_err(name)?;
            let to = ears.questions.clone();
            let ask = move |query: Query| {
                if let Some(operator) = part_before_last(query.key_expr().as_str()) {
                    // When too many wait, this one gets no answer.
                    let _ = to.try_send((operator.to_owned(), query));
                }
            };
            asked.push(
                { session.declare_queryable(questions).callback(ask) }
                    .wait()
                    .map_err(text)?,
            );
        }
        let own = ears.clone();
        let others = session
            .liveliness()
            .declare_subscriber(mediators)
            .history(true)
            .callback(move |sample| {
                let is_there = sample.kind() == SampleKind::Put;
                own.see_mediator(sample.key_expr().as_str(), is_there);
            })
            .wait()
            .map_err(text)?;
        let [alive, own] =
            alive_keys.map(|key| session.liveliness().declare_token(key).wait().map_err(text));
        let alive = [alive?, own?];
        tracing::info!("fleet network is open, session {}", session.zid());
        Ok(Self {
            key_prefix: prefix.clone(),
            publishers: HashMap::new(),
            protection,
            _alive: alive,
            _others: others,
            _reports: subscriber,
            _asked: asked,
            session,
        })
    }

    /// Whether it is to be opened anew, since who may take part has changed, or its certificate is half over.
    ///
    /// # Errors
    /// A sentence: the list cannot be read.
    pub(super) fn is_outdated(&self) -> Result<bool, String> {
        self.protection
            .as_ref()
            .map_or(Ok(false), Protection::is_over)
    }

    /// Ends the session. Its port is free afterwards.
    pub(super) async fn close(self) {
        let session = self.session.clone();
        drop(self);
        if let Err(error) = session.close().await {
            tracing::warn!("fleet network: {error}");
        }
    }

    /// Sends a message to its robot. `known`: to one of the site, which others are not.
    pub(super) async fn send(
        &mut self,
        message: MediatorReport,
        known: bool,
    ) -> Result<(), String> {
        let text = |error: zenoh::Error| error.to_string();
        let key =
            |id: &str| keys::to_robot(&self.key_prefix, id).map_err(|error| error.to_string());
        if !known {
            // A refusal. There may be any number of such names.
            let key = key(&message.robot_id)?;
            let put = self.session.put(key, message.encode_to_vec());
            return { put.congestion_control(CongestionControl::Drop).await }.map_err(text);
        }
        if !self.publishers.contains_key(&message.robot_id) {
            let publisher = self
                .session
                .declare_publisher(key(&message.robot_id)?)
                .congestion_control(CongestionControl::Drop)
                .express(true)
                .await
                .map_err(text)?;
            self.publishers.insert(message.robot_id.clone(), publisher);
        }
        {
            self.publishers[&message.robot_id]
                .put(message.encode_to_vec())
                .await
        }
        .map_err(text)
    }
}

impl Ears {
    /// A token of a mediator's process has come or gone.
    fn see_mediator(&self, key: &str, is_there: bool) {
        if let Some(instance) = keys::instance_in(key).filter(|&own| own != self.instance) {
            self.shared.note_mediator(instance, is_there);
        }
    }

    fn hear(&self, key: &str, payload: &zenoh::bytes::ZBytes) {
        let report = if payload.len() > LONGEST_MESSAGE {
            Err(format!("one has {} bytes", payload.len()))
        } else {
            report_in(key, &payload.to_bytes())
        };
        match report {
            Ok(report) => self.inbox.report(Box::new(report)),
            Err(why) => self.shared.note_no_report(why),
        }
    }
}

fn answer_renewal(renewals: &Mutex<Renewals>, query: &Query) {
    let bytes = query
        .payload()
        .map(|payload| payload.to_bytes().into_owned());
    let request = bytes.and_then(|bytes| decode::<CertificateRequest>(&bytes).ok());
    let robot = part_before_last(query.key_expr().as_str());
    let (Some(robot), Some(request)) = (robot, request) else {
        return;
    };
    let mut renewals = renewals.lock().unwrap_or_else(PoisonError::into_inner);
    let answer = renewals.answer(robot, &request);
    if answer.refusal.is_empty() && renewals.is_news(robot) {
        tracing::info!("robot `{robot}` gets a new certificate");
    }
    // One that has gone asks again.
    let _ = query.reply(query.key_expr(), answer.encode_to_vec()).wait();
}
