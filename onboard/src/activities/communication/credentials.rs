//! The robot's certificate: read from its file, renewed by the mediator long before it ends, and taken anew when somebody puts
//! another file in its place.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use contract::network::{Access, Identity, Party, Request, Security};
use contract::wire::{CertificateAnswer, CertificateRequest};
use contract::{Message, decode, keys, private};
use zenoh::Wait;
use zenoh::handlers::FifoChannelHandler;
use zenoh::query::Reply;

use crate::realtime::clock::SECOND_NS;

/// After the first session has opened: its link is up by then.
const FIRST_REQUEST_NS: u64 = 5 * SECOND_NS;
/// Between a request that was not answered and the next.
const RETRY_NS: u64 = 60 * SECOND_NS;
/// Between two looks at the file.
const LOOK_NS: u64 = 5 * SECOND_NS;
/// Timeout of an answer.
const PATIENCE: std::time::Duration = std::time::Duration::from_secs(10);

/// What a session is to do about its certificate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Attention {
    /// Nothing.
    None,
    /// Something is wrong with it, and it goes on.
    Complain(String),
    /// There is another one: another session is to take over.
    Replace(&'static str),
}

/// Reads the robot's file.
///
/// # Errors
/// A sentence: it cannot be read, or is not of this robot.
pub fn read_identity(path: &Path, robot_id: &str) -> Result<Identity, String> {
    let identity = Identity::load(path).map_err(|error| format!("`fleet.keys`: {error}"))?;
    match &identity.name().party {
        Party::Robot(id) if id == robot_id => Ok(identity),
        _ => Err(format!(
            "`fleet.keys`: {} is of {}, expected robot `{robot_id}`",
            path.display(),
            identity.name()
        )),
    }
}

/// The robot's certificate, which outlasts sessions.
#[derive(Clone)]
pub(super) struct Credentials(Arc<Mutex<Held>>);

struct Held {
    path: PathBuf,
    robot_id: String,
    /// `None` until the first session.
    identity: Option<Identity>,
    /// What the file had when it was read or written last.
    stored: Option<Identity>,
    request_at_ns: Option<u64>,
    look_at_ns: u64,
}

impl Credentials {
    pub(super) fn new(path: PathBuf, robot_id: String) -> Self {
        Self(Arc::new(Mutex::new(Held {
            path,
            robot_id,
            identity: None,
            stored: None,
            request_at_ns: None,
            look_at_ns: 0,
        })))
    }

    fn held(&self) -> MutexGuard<'_, Held> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// How a session shows who it is. It deals with nobody but the mediator.
    pub(super) fn security(&self) -> Result<Security, String> {
        let mut held = self.held();
        if held.identity.is_none() {
            held.read()?;
        }
        let identity = { held.identity.clone() }.ok_or("there is no identity")?;
        Ok(Security {
            identity,
            access: Access::MediatorOnly,
        })
    }
}

impl Held {
    /// Takes over the file, if it differs. Returns whether it does.
    fn read(&mut self) -> Result<bool, String> {
        let found = Some(read_identity(&self.path, &self.robot_id)?);
        if found == self.stored {
            return Ok(false);
        }
        (self.identity, self.stored) = (found.clone(), found);
        Ok(true)
    }

    /// Takes over a new certificate. One that cannot be stored is of use until the end of this process.
    fn renew(&mut self, identity: Identity) -> Result<(), String> {
        self.identity = Some(identity.clone());
        private::replace(&self.path, identity.to_pem().as_bytes())
            .map_err(|error| format!("the new certificate cannot be stored: {error}"))?;
        self.stored = Some(identity);
        Ok(())
    }
}

/// Looks after the certificate of one session.
pub(super) struct Renewal {
    credentials: Credentials,
    /// Where it is asked for.
    key: String,
    asked: Option<(Request, FifoChannelHandler<Reply>)>,
}

impl Renewal {
    pub(super) fn new(
        credentials: Credentials,
        key_prefix: &str,
        robot_id: &str,
    ) -> Result<Self, String> {
        Ok(Self {
            credentials,
            key: keys::certificate(key_prefix, robot_id).map_err(|error| error.to_string())?,
            asked: None,
        })
    }

    pub(super) fn attend(&mut self, session: &zenoh::Session, now_ns: u64) -> Attention {
        match self.try_to_attend(session, now_ns) {
            Ok(attention) => attention,
            Err(why) => Attention::Complain(why),
        }
    }

    fn try_to_attend(
        &mut self,
        session: &zenoh::Session,
        now_ns: u64,
    ) -> Result<Attention, String> {
        let credentials = self.credentials.clone();
        let mut held = credentials.held();
        if now_ns >= held.look_at_ns {
            held.look_at_ns = now_ns.saturating_add(LOOK_NS);
            if held.read()? {
                return Ok(Attention::Replace("its file has another certificate"));
            }
        }
        if let Some((request, replies)) = self.asked.take() {
            return self.take_answer(&mut held, request, replies, now_ns);
        }
        let request_at_ns = *held
            .request_at_ns
            .get_or_insert(now_ns.saturating_add(FIRST_REQUEST_NS));
        if now_ns >= request_at_ns
            && let Some(identity) = &held.identity
        {
            let request = identity.request()?;
            let message = CertificateRequest {
                request_pem: request.pem().to_owned(),
            };
            held.request_at_ns = Some(now_ns.saturating_add(RETRY_NS));
            let get = session.get(&self.key).payload(message.encode_to_vec());
            let replies = get
                .timeout(PATIENCE)
                .wait()
                .map_err(|error| error.to_string())?;
            self.asked = Some((request, replies));
        }
        Ok(Attention::None)
    }

    fn take_answer(
        &mut self,
        held: &mut Held,
        request: Request,
        replies: FifoChannelHandler<Reply>,
        now_ns: u64,
    ) -> Result<Attention, String> {
        let reply = match replies.try_recv() {
            Ok(Some(reply)) => reply,
            Ok(None) => {
                self.asked = Some((request, replies));
                return Ok(Attention::None);
            }
            // Asked again later: the mediator may be away.
            Err(_) => return Ok(Attention::None),
        };
        let Ok(sample) = reply.into_result() else {
            return Ok(Attention::None);
        };
        let answer: CertificateAnswer = decode(&sample.payload().to_bytes()).map_err(|_| {
            "the mediator's answer to a request for a certificate is none".to_owned()
        })?;
        if !answer.refusal.is_empty() {
            return Err(format!(
                "the mediator makes no new certificate: {}",
                answer.refusal
            ));
        }
        let identity = request
            .answered(&answer.certificate_pem)
            .map_err(|error| format!("the mediator's new certificate is refused: {error}"))?;
        let after_ns = u64::from(answer.renew_after_s.max(1)) * SECOND_NS;
        held.request_at_ns = Some(now_ns.saturating_add(after_ns));
        held.renew(identity)?;
        Ok(Attention::Replace(
            "the mediator has renewed its certificate",
        ))
    }
}
