//! The area management activity: reports in, journal, messages out; its step, which is handed the time, and its thread.

use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use super::question::{Answer, Question};
use super::shared::Shared;
use crate::journal::{Entry, Store, StoreError};
use crate::manager::Manager;
use contract::wire::{MediatorReport, RobotReport};
use tokio::sync::mpsc::Sender;
use tokio::sync::mpsc::error::TrySendError;

/// Time passes for the manager at least this often.
pub const TICK_NS: u64 = 20_000_000;
/// At most this many inputs are taken in before the journal is written: one commit for all of them.
pub const BATCH: usize = 256;

/// Where the answer to a question goes.
pub type Reply = Box<dyn FnOnce(Answer) + Send>;

/// What management takes in.
pub enum Input {
    /// A robot's report.
    Report(Box<RobotReport>),
    /// A question of an operator, and where its answer goes.
    Question(Question, Reply),
}

/// Manager and journal, and what waits for the journal before it leaves.
pub struct Management {
    manager: Manager,
    store: Store,
    entries: Vec<Entry>,
    answers: Vec<(Reply, Answer)>,
    next_tick_ns: u64,
}

impl Management {
    /// Writes the new epoch to the journal before anybody hears of it.
    ///
    /// # Errors
    /// [`StoreError`] when the journal cannot be written.
    pub fn start(mut manager: Manager, store: Store) -> Result<Self, StoreError> {
        let entries: Vec<Entry> = manager.entries().collect();
        store.write(&entries)?;
        Ok(Self {
            manager,
            store,
            entries,
            answers: Vec::new(),
            next_tick_ns: 0,
        })
    }

    /// Takes in inputs, at most [`BATCH`], lets time pass, and writes the journal. What [`next_message`](Self::next_message)
    /// and [`answer`](Self::answer) give afterwards may leave.
    ///
    /// # Errors
    /// [`StoreError`] when the journal cannot be written: nothing may leave any more.
    pub fn turn(
        &mut self,
        inputs: impl Iterator<Item = Input>,
        now_ns: u64,
    ) -> Result<(), StoreError> {
        for input in inputs.take(BATCH) {
            match input {
                Input::Report(report) => self.manager.report(&report, now_ns),
                Input::Question(question, reply) => {
                    let answer = self.reply_to(question, now_ns);
                    self.answers.push((reply, answer));
                }
            }
        }
        if now_ns >= self.next_tick_ns {
            self.manager.tick(now_ns);
            self.next_tick_ns = now_ns + TICK_NS;
        }
        self.entries.clear();
        self.entries.extend(self.manager.entries());
        self.store.write(&self.entries)?;
        for alarm in self.manager.alarms() {
            tracing::warn!("{alarm}");
        }
        Ok(())
    }

    /// The next message to a robot.
    pub fn next_message(&mut self, now_ns: u64) -> Option<MediatorReport> {
        self.manager.next_message(now_ns)
    }

    /// Answers the operators.
    pub fn answer(&mut self) {
        for (reply, answer) in self.answers.drain(..) {
            reply(answer);
        }
    }

    fn reply_to(&mut self, question: Question, now_ns: u64) -> Answer {
        let manager = &mut self.manager;
        match question {
            Question::Status => Answer::Status(Box::new(manager.status(now_ns))),
            Question::Why { robot } => match manager.why(&robot, now_ns) {
                Ok(text) => Answer::Done(text),
                Err(error) => Answer::Refused(error.to_string()),
            },
            Question::Clear { area, taken_away } => {
                match manager.clear(&area, taken_away, now_ns) {
                    Ok(robots) if robots.is_empty() => {
                        Answer::Done(format!("area `{area}` was free already"))
                    }
                    Ok(robots) => {
                        let robots = robots.join(", ");
                        tracing::warn!("an operator cleared area `{area}` of {robots}");
                        Answer::Done(format!("area `{area}` is free of {robots}"))
                    }
                    Err(error) => Answer::Refused(error.to_string()),
                }
            }
            Question::End { coordination } => match manager.end(&coordination, now_ns) {
                Ok((name, let_go)) => {
                    let done = if let_go {
                        "its robots are let go as they are"
                    } else {
                        "its robots are told to get out of the way; end it again to let them go as they are"
                    };
                    tracing::warn!("an operator ended coordination `{name}`: {done}");
                    Answer::Done(format!("coordination `{name}` has ended: {done}"))
                }
                Err(error) => Answer::Refused(error.to_string()),
            },
            Question::Absent { robot } => match manager.absent(&robot, now_ns) {
                Ok(areas) => {
                    let areas = if areas.is_empty() {
                        "nothing".to_owned()
                    } else {
                        areas.join(", ")
                    };
                    tracing::warn!(
                        "an operator said that robot `{robot}` is absent; it had {areas}"
                    );
                    Answer::Done(format!("robot `{robot}` is absent; it had {areas}"))
                }
                Err(error) => Answer::Refused(error.to_string()),
            },
        }
    }
}

/// Runs until it is told to stop, or the journal fails: nothing is granted that is not written down first.
pub(super) fn run(
    manager: Manager,
    store: Store,
    inbox: &Receiver<Input>,
    outbox: &Sender<MediatorReport>,
    shared: &Shared,
) -> Result<(), String> {
    let outcome = run_until_stopped(manager, store, inbox, outbox, shared);
    shared.stop();
    outcome
}

fn run_until_stopped(
    manager: Manager,
    store: Store,
    inbox: &Receiver<Input>,
    outbox: &Sender<MediatorReport>,
    shared: &Shared,
) -> Result<(), String> {
    let mut management = Management::start(manager, store).map_err(|error| error.to_string())?;
    let mut overflows = Overflows::default();
    while !shared.is_stopping() {
        let first = match inbox.recv_timeout(Duration::from_nanos(TICK_NS)) {
            Ok(input) => Some(input),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => break,
        };
        let now_ns = shared.now_ns();
        management
            .turn(first.into_iter().chain(inbox.try_iter()), now_ns)
            .map_err(|error| error.to_string())?;
        overflows.tell(shared, now_ns);
        while let Some(message) = management.next_message(now_ns) {
            match outbox.try_send(message) {
                Ok(()) => {}
                Err(TrySendError::Full(_)) => {
                    shared.dropped_outputs.fetch_add(1, Ordering::Relaxed);
                }
                Err(TrySendError::Closed(_)) => return Ok(()),
            }
        }
        management.answer();
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
