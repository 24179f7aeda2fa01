//! The communication activity: the fleet's network and the control socket, on one asynchronous thread.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::time::Duration;

use super::folder::Folder;
use super::management::Input;
use super::question::{Answer, Question};
use super::shared::Shared;
use contract::network::NetworkSettings;
use contract::wire::{MediatorReport, RobotReport};
use contract::{Message, decode, keys};
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
    inputs: SyncSender<Input>,
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
        .and_then(|runtime| runtime.block_on(talk(opened, settings, inputs, outputs, shared)));
    shared.stop();
    // It may be gone already.
    let _ = std::fs::remove_file(socket);
    outcome
}

async fn talk(
    opened: Opened,
    settings: &Settings,
    inputs: SyncSender<Input>,
    mut outputs: Receiver<MediatorReport>,
    shared: &Arc<Shared>,
) -> Result<(), String> {
    let text = |error: zenoh::Error| error.to_string();
    let reports = keys::all_reports(&settings.key_prefix).map_err(|error| error.to_string())?;
    let (to_management, counts) = (inputs.clone(), Arc::clone(shared));
    let _subscriber = opened
        .session
        .declare_subscriber(reports)
        .callback(move |sample| {
            let key = sample.key_expr().as_str();
            let input = match report_in(key, &sample.payload().to_bytes()) {
                Ok(report) => Input::Report(Box::new(report)),
                Err(why) => return tracing::warn!("{why}; ignored"),
            };
            if let Err(TrySendError::Full(_)) = to_management.try_send(input) {
                counts.dropped_inputs.fetch_add(1, Ordering::Relaxed);
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
                if let Err(error) = send(&opened.session, &mut publishers, settings, message).await {
                    tracing::warn!("a message could not be sent: {error}");
                }
            }
            client = listener.accept() => match client {
                Ok((stream, _)) => {
                    let inputs = inputs.clone();
                    tokio::spawn(async move {
                        let served = tokio::time::timeout(PATIENCE, serve(stream, inputs)).await;
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
) -> Result<(), String> {
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

async fn serve(mut stream: UnixStream, inputs: SyncSender<Input>) -> std::io::Result<()> {
    let mut line = String::new();
    let (read, mut write) = stream.split();
    BufReader::new(read.take(LONGEST_LINE))
        .read_line(&mut line)
        .await?;
    let answer = match serde_json::from_str::<Question>(&line) {
        Ok(question) => put(question, inputs).await,
        Err(error) => Answer::Refused(format!("unknown question `{}`: {error}", line.trim())),
    };
    let mut text = serde_json::to_string(&answer).expect("an answer is always JSON");
    text.push('\n');
    write.write_all(text.as_bytes()).await
}

async fn put(question: Question, inputs: SyncSender<Input>) -> Answer {
    let (reply, answer) = sync_channel(1);
    // The client may have gone.
    let reply = Box::new(move |answer| drop(reply.try_send(answer)));
    if inputs.try_send(Input::Question(question, reply)).is_err() {
        return Answer::Refused("the mediator is overloaded; ask again".to_owned());
    }
    let waited = tokio::task::spawn_blocking(move || answer.recv_timeout(PATIENCE)).await;
    match waited {
        Ok(Ok(answer)) => answer,
        _ => Answer::Refused("the mediator is stopping, or overloaded".to_owned()),
    }
}
