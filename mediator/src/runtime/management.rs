//! The area management activity: reports in, journal, messages out. Whoever runs it hands in the time.

use super::question::{Answer, Question};
use crate::journal::{Entry, Store, StoreError};
use crate::manager::Manager;
use contract::wire::{MediatorReport, RobotReport};

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
            Question::Clear { area } => match manager.clear(&area, now_ns) {
                Ok(robots) if robots.is_empty() => {
                    Answer::Done(format!("area `{area}` was free already"))
                }
                Ok(robots) => {
                    let robots = robots.join(", ");
                    tracing::warn!("an operator cleared area `{area}` of {robots}");
                    Answer::Done(format!("area `{area}` is free of {robots}"))
                }
                Err(error) => Answer::Refused(error.to_string()),
            },
        }
    }
}
