//! The communication activity: the fleet's network and the control socket, on one asynchronous thread.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::time::{Duration, Instant};

use contract::private;
use contract::wire::MediatorReport;
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;
use tokio::io::{AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::net::{UnixListener, UnixStream};
use tokio::sync::mpsc::{Receiver, channel};
use zenoh::query::Query;

use super::files::Files;
use super::folder::Folder;
use super::inbox::Inbox;
use super::input::{Asked, Asker};
use super::network::{Ears, Network, Settings};
use super::question::{Answer, Question};
use super::shared::Shared;

/// The longest question.
const LONGEST_LINE: u64 = 4096;
/// Questions from afar that may wait.
const QUESTIONS: usize = 16;
/// Timeout of a client of the control socket, for its question and for each of the two waits for the answer.
const PATIENCE: Duration = Duration::from_secs(2);
/// How often the stop flag is looked at.
const STOP_CHECK: Duration = Duration::from_millis(20);
/// After a client that could not be taken in the next one waits for so long.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);
/// How often that is said.
const WARN_PAUSE: Duration = Duration::from_secs(60);
/// How often the list of identities and the files that are left are looked at, and a network that cannot be opened is tried again.
const KEYS_CHECK: Duration = Duration::from_secs(1);

/// What is opened before any thread starts, so that failures are reported at once.
pub(super) struct Opened {
    settings: Settings,
    ears: Ears,
    network: Network,
    questions: Receiver<(String, Query)>,
    listener: std::os::unix::net::UnixListener,
    socket: PathBuf,
    files: Files,
}

pub(super) fn open(
    settings: Settings,
    folder: &Folder,
    inbox: &Arc<Inbox>,
    shared: &Arc<Shared>,
    instance: u64,
) -> Result<Opened, String> {
    // Before a link comes.
    let files = Files::allow_many(inbox.robots(), settings.keys.is_some());
    let listener = folder.listen()?;
    let (asked, questions) = channel(QUESTIONS);
    let ears = Ears {
        inbox: Arc::clone(inbox),
        shared: Arc::clone(shared),
        questions: asked,
        instance,
    };
    Ok(Opened {
        network: Network::open(&settings, &ears)?,
        settings,
        ears,
        questions,
        listener,
        socket: folder.socket(),
        files,
    })
}

pub(super) fn run(
    opened: Opened,
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
        .and_then(|runtime| runtime.block_on(talk(opened, inbox, outputs, shared)));
    shared.stop();
    // It may be gone already.
    let _ = std::fs::remove_file(socket);
    outcome
}

async fn talk(
    opened: Opened,
    inbox: Arc<Inbox>,
    mut outputs: Receiver<MediatorReport>,
    shared: &Arc<Shared>,
) -> Result<(), String> {
    let Opened {
        settings,
        ears,
        network,
        mut questions,
        listener,
        mut files,
        ..
    } = opened;
    let mut network = Some(network);
    let listener =
        UnixListener::from_std(listener).map_err(|error| format!("control socket: {error}"))?;
    let mut stop_check = tokio::time::interval(STOP_CHECK);
    let mut keys_check = tokio::time::interval(KEYS_CHECK);
    let (mut accepts_again, mut warns_again) = (Instant::now(), Instant::now());
    let mut unsent = Unsent::default();
    loop {
        tokio::select! {
            message = outputs.recv() => {
                let Some(message) = message else { return Ok(()) };
                let known = inbox.knows(&message.robot_id);
                // Without a network it is lost, like on the way.
                if let Some(network) = &mut network
                    && let Err(error) = network.send(message, known).await
                {
                    unsent.note(&error.to_string(), Instant::now());
                }
            }
            client = listener.accept(), if Instant::now() >= accepts_again => match client {
                Ok((stream, _)) => {
                    let inbox = Arc::clone(&inbox);
                    tokio::spawn(async move {
                        if let Err(error) = serve(stream, &inbox, PATIENCE).await {
                            tracing::debug!("control socket: {error}");
                        }
                    });
                }
                Err(error) => {
                    // As when no descriptor is left: the next try would find the same. Messages go on meanwhile.
                    let now = Instant::now();
                    if now >= warns_again {
                        tracing::warn!("control socket: {error}; operators get no answers until that is over");
                        warns_again = now + WARN_PAUSE;
                    }
                    accepts_again = now + ACCEPT_PAUSE;
                }
            },
            Some((operator, query)) = questions.recv() => {
                tokio::spawn(serve_from_afar(operator, query, Arc::clone(&inbox)));
            }
            _ = keys_check.tick() => {
                shared.count_mediators();
                let is_stuck = files.look(Instant::now());
                network = keep_up(network, is_stuck, &settings, &ears).await;
            }
            _ = stop_check.tick() => if shared.is_stopping() { return Ok(()) },
        }
    }
}

/// Messages that could not be sent: there may be thousands in a second.
#[derive(Debug, Default)]
struct Unsent {
    /// Since the last line that said so.
    count: u64,
    warned: Option<Instant>,
}

impl Unsent {
    fn note(&mut self, error: &str, now: Instant) {
        self.count += 1;
        if self.warned.is_none_or(|warned| now >= warned + WARN_PAUSE) {
            let messages = match std::mem::take(&mut self.count) {
                1 => "a message".to_owned(),
                count => format!("{count} messages"),
            };
            tracing::warn!("{messages} could not be sent: {error}");
            self.warned = Some(now);
        }
    }
}

/// The network, opened anew where that is due.
async fn keep_up(
    network: Option<Network>,
    is_stuck: bool,
    settings: &Settings,
    ears: &Ears,
) -> Option<Network> {
    if let Some(network) = network {
        match network.is_outdated() {
            _ if is_stuck => {
                tracing::warn!("the fleet network is opened anew: no file was left for long");
                network.close().await;
            }
            Ok(false) => return Some(network),
            Ok(true) => {
                tracing::info!("certificates have changed: the fleet network is opened anew");
                network.close().await;
            }
            Err(error) => {
                ears.shared.note_keys(&error);
                return Some(network);
            }
        }
    }
    match Network::open(settings, ears) {
        Ok(network) => {
            ears.shared.forget_keys();
            Some(network)
        }
        Err(error) => {
            ears.shared.note_keys(&error);
            None
        }
    }
}

/// Serves a client, and gives it up when the last answer that [`Ticket::wait_for`](super::input::Ticket::wait_for) may give is over.
async fn serve(stream: UnixStream, inbox: &Inbox, patience: Duration) -> std::io::Result<()> {
    tokio::time::timeout(3 * patience, talk_to(stream, inbox, patience)).await?
}

async fn talk_to(mut stream: UnixStream, inbox: &Inbox, patience: Duration) -> std::io::Result<()> {
    let who = format!("user {}", stream.peer_cred()?.uid());
    let stranger = private::peer(&stream).err();
    let mut line = String::new();
    let (read, mut write) = stream.split();
    BufReader::new(read.take(LONGEST_LINE))
        .read_line(&mut line)
        .await?;
    let text = match stranger {
        Some(why) => as_line(&Answer::Refused(why.to_string())),
        None => answer(line.trim().as_bytes(), who, inbox, patience).await,
    };
    write.write_all((text + "\n").as_bytes()).await
}

async fn serve_from_afar(operator: String, query: Query, inbox: Arc<Inbox>) {
    let payload = query.payload().map(zenoh::bytes::ZBytes::to_bytes);
    let line = payload.unwrap_or_default();
    let answer = if line.len() as u64 > LONGEST_LINE {
        as_line(&Answer::Refused(format!(
            "expected at most {LONGEST_LINE} bytes"
        )))
    } else {
        answer(&line, format!("operator {operator}"), &inbox, PATIENCE).await
    };
    if let Err(error) = query.reply(query.key_expr(), answer).await {
        tracing::debug!("a question of operator {operator}: {error}");
    }
}

/// The answer to a line, as a line.
async fn answer(line: &[u8], who: String, inbox: &Inbox, patience: Duration) -> String {
    let answer = match serde_json::from_slice::<Question>(line) {
        Ok(question) => put(question, who, inbox, patience).await,
        Err(error) => {
            let line = String::from_utf8_lossy(line);
            Answer::Refused(format!("unknown question `{line}`: {error}"))
        }
    };
    as_line(&answer)
}

fn as_line(answer: &Answer) -> String {
    serde_json::to_string(answer).expect("an answer is always JSON")
}

/// Has management answer. A question that is given up is not carried out later; what is being carried out then says so.
async fn put(question: Question, who: String, inbox: &Inbox, patience: Duration) -> Answer {
    let (reply, answer) = sync_channel(1);
    // The client may have gone.
    let reply = Box::new(move |answer| drop(reply.try_send(answer)));
    // RFC 3339 ends in the year 9999.
    let at = OffsetDateTime::now_utc()
        .format(&Rfc3339)
        .unwrap_or_default();
    let asked = Asked::new(question, Asker { who, at }, reply);
    let ticket = asked.ticket();
    if !inbox.ask(asked) {
        return Answer::Refused("the mediator is overloaded; ask again".to_owned());
    }
    let waited = tokio::task::spawn_blocking(move || ticket.wait_for(&answer, patience));
    { waited.await }.unwrap_or_else(|_| Answer::Refused("the mediator is stopping".to_owned()))
}

#[cfg(test)]
mod tests {
    use std::io::{BufRead, BufReader, Write};

    use super::super::input::Input;
    use super::super::waiting::Waiting;
    use super::*;

    /// It says its question after a while, and the journal cannot be written.
    #[test]
    fn an_order_that_is_being_carried_out_is_said_to_be_so() {
        const PATIENCE: Duration = Duration::from_secs(3);
        let inbox = Arc::new(Inbox::new(Waiting::new([])));
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .enable_all()
            .build()
            .expect("a runtime");
        let (mut client, server) = std::os::unix::net::UnixStream::pair().expect("a pair");
        server.set_nonblocking(true).expect("a socket");
        let serving = Arc::clone(&inbox);
        runtime.spawn(async move {
            let server = UnixStream::from_std(server).expect("a socket");
            serve(server, &serving, PATIENCE).await
        });
        std::thread::sleep(PATIENCE / 4);
        writeln!(client, r#"{{"open":{{"area":"gate"}}}}"#).expect("it is served");
        let inputs = inbox.take(PATIENCE);
        let taken = inputs.into_iter().find_map(|input| match input {
            Input::Question(asked) => asked.take(),
            Input::Report(_) => None,
        });
        assert!(taken.is_some(), "the order is being carried out");
        let mut text = String::new();
        BufReader::new(client)
            .read_line(&mut text)
            .expect("it is served");
        let answer = serde_json::from_str::<Answer>(&text);
        assert!(matches!(answer, Ok(Answer::Underway(_))), "{text}");
    }
}
