//! The area management activity: reports in, journal, messages out.

use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender};
use std::time::Duration;

use super::question::{Answer, Question};
use super::shared::Shared;
use crate::journal::{Entry, Store};
use crate::manager::Manager;
use contract::wire::{MediatorReport, RobotReport};
use tokio::sync::mpsc::Sender;
use tokio::sync::mpsc::error::TrySendError;

/// Time passes for the manager at least this often.
const TICK: Duration = Duration::from_millis(20);
/// At most this many inputs are taken in before the journal is written: one commit for all of them.
const BATCH: usize = 256;

/// What management takes in.
pub(super) enum Input {
    Report(Box<RobotReport>),
    Question(Question, SyncSender<Answer>),
}

/// Runs until it is told to stop, or the journal fails: nothing is granted that is not written down first.
pub(super) fn run(
    mut manager: Manager,
    store: &Store,
    inbox: &Receiver<Input>,
    outbox: &Sender<MediatorReport>,
    shared: &Shared,
) -> Result<(), String> {
    let outcome = run_until_stopped(&mut manager, store, inbox, outbox, shared);
    shared.stop();
    outcome
}

fn run_until_stopped(
    manager: &mut Manager,
    store: &Store,
    inbox: &Receiver<Input>,
    outbox: &Sender<MediatorReport>,
    shared: &Shared,
) -> Result<(), String> {
    // The new epoch is in the journal before anybody hears of it.
    let mut entries: Vec<Entry> = manager.entries().collect();
    store.write(&entries).map_err(|error| error.to_string())?;
    let mut next_tick_ns = 0;
    let mut overflows = Overflows::default();
    let mut answers = Vec::new();
    while !shared.is_stopping() {
        match inbox.recv_timeout(TICK) {
            Ok(input) => {
                take_in(manager, input, &mut answers, shared);
                for input in inbox.try_iter().take(BATCH - 1) {
                    take_in(manager, input, &mut answers, shared);
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        let now_ns = shared.now_ns();
        if now_ns >= next_tick_ns {
            manager.tick(now_ns);
            overflows.tell(shared, now_ns);
            next_tick_ns = now_ns + TICK.as_nanos() as u64;
        }
        entries.clear();
        entries.extend(manager.entries());
        store.write(&entries).map_err(|error| error.to_string())?;
        for alarm in manager.alarms() {
            tracing::warn!("{alarm}");
        }
        while let Some(message) = manager.next_message(now_ns) {
            match outbox.try_send(message) {
                Ok(()) => {}
                Err(TrySendError::Full(_)) => {
                    shared.dropped_outputs.fetch_add(1, Ordering::Relaxed);
                }
                Err(TrySendError::Closed(_)) => return Ok(()),
            }
        }
        for (reply, answer) in answers.drain(..) {
            let reply: SyncSender<Answer> = reply;
            // The client may have gone.
            let _ = reply.try_send(answer);
        }
    }
    Ok(())
}

/// What was dropped because a queue was full; logged at most once a second.
#[derive(Default)]
struct Overflows {
    told: [u64; 2],
    again_ns: u64,
}

impl Overflows {
    fn tell(&mut self, shared: &Shared, now_ns: u64) {
        let dropped = [&shared.dropped_inputs, &shared.dropped_outputs];
        let dropped = dropped.map(|count| count.load(Ordering::Relaxed));
        if dropped == self.told || now_ns < self.again_ns {
            return;
        }
        let [reports, messages] = dropped;
        tracing::warn!(
            "overload: {reports} reports and {messages} messages dropped since the start; each is sent again with the next level: \
             let robots report less often, or use a faster machine"
        );
        self.told = dropped;
        self.again_ns = now_ns + 1_000_000_000;
    }
}

fn take_in(
    manager: &mut Manager,
    input: Input,
    answers: &mut Vec<(SyncSender<Answer>, Answer)>,
    shared: &Shared,
) {
    let now_ns = shared.now_ns();
    match input {
        Input::Report(report) => manager.report(&report, now_ns),
        Input::Question(question, reply) => {
            let answer = match question {
                Question::Status => Answer::Status(Box::new(manager.status(now_ns))),
                Question::Why { robot } => match manager.why(&robot, now_ns) {
                    Ok(text) => Answer::Done(text),
                    Err(error) => Answer::Refused(error.to_string()),
                },
                Question::Clear { area } => match manager.clear(&area, now_ns) {
                    Ok(robots) if robots.is_empty() => {
                        Answer::Done(format!("area `{area}` was free already"))
                    }
                    Ok(robots) => {
                        tracing::warn!(
                            "an operator cleared area `{area}` of {}",
                            robots.join(", ")
                        );
                        Answer::Done(format!("area `{area}` is free of {}", robots.join(", ")))
                    }
                    Err(error) => Answer::Refused(error.to_string()),
                },
            };
            answers.push((reply, answer));
        }
    }
}
