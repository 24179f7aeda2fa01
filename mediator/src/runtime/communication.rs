//! The communication activity: the fleet's network and the control socket, on one asynchronous thread.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::time::Duration;

use super::folder::Folder;
use super::inbox::Inbox;
use super::input::Asked;
use super::question::{Answer, Question};
use super::shared::Shared;
use contract::network::{LONGEST_MESSAGE, NetworkSettings};
use contract::wire::{MediatorReport, RobotReport};
use contract::{Message, decode, keys, private};
use tokio::io::{AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::net::{UnixListener, UnixStream};
use tokio::sync::mpsc::Receiver;
use zenoh::Wait;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;

/// The longest question.
const LONGEST_LINE: u64 = 4096;
/// Timeout of a client of the control socket.
const PATIENCE: Duration = Duration::from_secs(2);
/// How often the stop flag is looked at.
const STOP_CHECK: Duration = Duration::from_millis(20);

/// How the mediator takes part in the fleet.
#[derive(Clone, Debug)]
pub struct Settings {
    /// First part of every key.
    pub key_prefix: String,
    /// The network.
    pub network: NetworkSettings,
}

/// What is opened before any thread starts, so that failures are reported at once.
pub(super) struct Opened {
    // Declared before the session, so that it is dropped first.
    _alive: LivelinessToken,
    session: zenoh::Session,
    listener: std::os::unix::net::UnixListener,
    socket: PathBuf,
}

pub(super) fn open(settings: &Settings, folder: &Folder) -> Result<Opened, String> {
    let listener = folder.listen()?;
    let alive_key =
        keys::mediator_alive(&settings.key_prefix).map_err(|error| error.to_string())?;
    let session = settings
        .network
        .open()
        .map_err(|error| format!("the fleet network cannot be opened: {error}"))?;
    let alive = session
        .liveliness()
        .declare_token(alive_key)
        .wait()
        .map_err(|error| error.to_string())?;
    tracing::info!("fleet network is open, session {}", session.zid());
    Ok(Opened {
        _alive: alive,
        session,
        listener,
        socket: folder.socket(),
    })
}

pub(super) fn run(
    opened: Opened,
    settings: &Settings,
    inbox: Arc<Inbox>,
    outputs: Receiver<MediatorReport>,
    shared: &Arc<Shared>,
) -> Result<(), String> {
    let socket = opened.socket.clone();
    let outcome = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .enable_io()
        .enable_time()
        .build()
        .map_err(|error| format!("no asynchronous runtime: {error}"))
        .and_then(|runtime| runtime.block_on(talk(opened, settings, inbox, outputs, shared)));
    shared.stop();
    // It may be gone already.
    let _ = std::fs::remove_file(socket);
    outcome
}

async fn talk(
    opened: Opened,
    settings: &Settings,
    inbox: Arc<Inbox>,
    mut outputs: Receiver<MediatorReport>,
    shared: &Arc<Shared>,
) -> Result<(), String> {
    let text = |error: zenoh::Error| error.to_string();
    let reports = keys::all_reports(&settings.key_prefix).map_err(|error| error.to_string())?;
    let (to_management, counts) = (Arc::clone(&inbox), Arc::clone(shared));
    let _subscriber = opened
        .session
        .declare_subscriber(reports)
        .callback(move |sample| {
            let (key, payload) = (sample.key_expr().as_str(), sample.payload());
            let report = if payload.len() > LONGEST_MESSAGE {
                Err(format!("{key} carries {} bytes", payload.len()))
            } else {
                report_in(key, &payload.to_bytes())
            };
            match report {
                Ok(report) => to_management.report(Box::new(report)),
                Err(why) => counts.note_no_report(why),
            }
        })
        .await
        .map_err(text)?;
    let listener = UnixListener::from_std(opened.listener)
        .map_err(|error| format!("control socket: {error}"))?;
    let mut publishers: HashMap<String, Publisher<'_>> = HashMap::new();
    let mut stop_check = tokio::time::interval(STOP_CHECK);
    loop {
        tokio::select! {
            message = outputs.recv() => {
                let Some(message) = message else { return Ok(()) };
                let known = inbox.knows(&message.robot_id);
                if let Err(error) = send(&opened.session, &mut publishers, settings, message, known).await {
                    tracing::warn!("a message could not be sent: {error}");
                }
            }
            client = listener.accept() => match client {
                Ok((stream, _)) => {
                    let inbox = Arc::clone(&inbox);
                    tokio::spawn(async move {
                        let served = tokio::time::timeout(2 * PATIENCE, serve(stream, inbox)).await;
                        if let Ok(Err(error)) = served {
                            tracing::debug!("control socket: {error}");
                        }
                    });
                }
                Err(error) => tracing::warn!("control socket: {error}"),
            },
            _ = stop_check.tick() => if shared.is_stopping() { return Ok(()) },
        }
    }
}

/// The report in a message, which must be of the robot that its key names.
///
/// # Errors
/// A sentence.
pub fn report_in(key: &str, message: &[u8]) -> Result<RobotReport, String> {
    let report = decode::<RobotReport>(message).map_err(|_| format!("{key} carries no report"))?;
    if key.rsplit('/').nth(1) == Some(report.robot_id.as_str()) {
        Ok(report)
    } else {
        Err(format!("{key} carries a report of `{}`", report.robot_id))
    }
}

async fn send<'a>(
    session: &'a zenoh::Session,
    publishers: &mut HashMap<String, Publisher<'a>>,
    settings: &Settings,
    message: MediatorReport,
    known: bool,
) -> Result<(), String> {
    if !known {
        // A refusal. There may be any number of such names.
        let key = keys::to_robot(&settings.key_prefix, &message.robot_id)
            .map_err(|error| error.to_string())?;
        let put = session.put(key, message.encode_to_vec());
        return { put.congestion_control(CongestionControl::Drop).await }
            .map_err(|error| error.to_string());
    }
    if !publishers.contains_key(&message.robot_id) {
        let key = keys::to_robot(&settings.key_prefix, &message.robot_id)
            .map_err(|error| error.to_string())?;
        let publisher = session
            .declare_publisher(key)
            .congestion_control(CongestionControl::Drop)
            .express(true)
            .await
            .map_err(|error| error.to_string())?;
        publishers.insert(message.robot_id.clone(), publisher);
    }
    publishers[&message.robot_id]
        .put(message.encode_to_vec())
        .await
        .map_err(|error| error.to_string())
}

async fn serve(mut stream: UnixStream, inbox: Arc<Inbox>) -> std::io::Result<()> {
    let mut line = String::new();
    let stranger = private::peer(&stream).err();
    let (read, mut write) = stream.split();
    BufReader::new(read.take(LONGEST_LINE))
        .read_line(&mut line)
        .await?;
    let answer = match (stranger, serde_json::from_str::<Question>(&line)) {
        (Some(why), _) => Answer::Refused(why.to_string()),
        (None, Ok(question)) => put(question, &inbox).await,
        (None, Err(error)) => {
            Answer::Refused(format!("unknown question `{}`: {error}", line.trim()))
        }
    };
    let mut text = serde_json::to_string(&answer).expect("an answer is always JSON");
    text.push('\n');
    write.write_all(text.as_bytes()).await
}

/// Has management answer. A question that is given up is not carried out later.
async fn put(question: Question, inbox: &Inbox) -> Answer {
    let (reply, answer) = sync_channel(1);
    // The client may have gone.
    let reply = Box::new(move |answer| drop(reply.try_send(answer)));
    let asked = Asked::new(question, reply);
    let ticket = asked.ticket();
    if !inbox.ask(asked) {
        return Answer::Refused("the mediator is overloaded; ask again".to_owned());
    }
    let waited = tokio::task::spawn_blocking(move || {
        let in_time = answer.recv_timeout(PATIENCE).ok();
        if in_time.is_some() || ticket.give_up() {
            return in_time;
        }
        // It is being carried out.
        answer.recv_timeout(PATIENCE).ok()
    });
    waited.await.ok().flatten().unwrap_or_else(|| {
        Answer::Refused(
            "the mediator is stopping, or its journal's disk is slow or full: its log says which"
                .to_owned(),
        )
    })
}
