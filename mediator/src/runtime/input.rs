//! What management takes in, and how whoever has asked a question gives it up.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Receiver;
use std::time::Duration;

use contract::wire::RobotReport;

use super::question::{Answer, Question};

/// Where the answer to a question goes.
pub type Reply = Box<dyn FnOnce(Answer) + Send>;

/// What management takes in.
pub enum Input {
    /// A robot's report.
    Report(Box<RobotReport>),
    /// A question of an operator.
    Question(Asked),
}

/// Who asks, and when by this computer's clock: for people, nothing is decided by it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Asker {
    /// Such as `operator anna` or `user 1000`.
    pub who: String,
    /// As RFC 3339 writes it.
    pub at: String,
}

/// A question, and where its answer goes. Whoever has asked may give it up: then it is not carried out any more.
pub struct Asked {
    question: Question,
    asker: Asker,
    reply: Reply,
    taken: Arc<AtomicBool>,
}

impl Asked {
    /// A question.
    #[must_use]
    pub fn new(question: Question, asker: Asker, reply: Reply) -> Self {
        Self {
            question,
            asker,
            reply,
            taken: Arc::default(),
        }
    }

    /// The question, who asks, and the reply, unless it was given up.
    pub(super) fn take(self) -> Option<(Question, Asker, Reply)> {
        let given_up = self.taken.swap(true, Ordering::AcqRel);
        (!given_up).then_some((self.question, self.asker, self.reply))
    }

    /// By which it is given up.
    #[must_use]
    pub fn ticket(&self) -> Ticket {
        Ticket {
            taken: Arc::clone(&self.taken),
            is_order: self.question.is_order(),
        }
    }
}

/// Of a question that waits.
pub struct Ticket {
    taken: Arc<AtomicBool>,
    is_order: bool,
}

impl Ticket {
    /// Gives the question up. Returns whether it is not carried out: else it is, and is answered soon.
    #[must_use]
    pub fn give_up(&self) -> bool {
        !self.taken.swap(true, Ordering::AcqRel)
    }

    /// Waits for the answer, and then gives the question up. One that is being carried out by then is waited for as long again; an
    /// order that is not answered even then takes effect all the same, when its journal can be written.
    #[must_use]
    pub fn wait_for(self, answer: &Receiver<Answer>, patience: Duration) -> Answer {
        let in_time = answer.recv_timeout(patience).ok();
        let given_up = in_time.is_none() && self.give_up();
        let told = in_time.or_else(|| {
            { !given_up }
                .then(|| answer.recv_timeout(patience).ok())
                .flatten()
        });
        told.unwrap_or_else(|| match given_up || !self.is_order {
            true => Answer::Refused(
                "the mediator is stopping, or its journal's disk is slow or full: its log says which"
                    .to_owned(),
            ),
            false => Answer::Underway(
                "the order is being carried out, and takes effect once the journal can be written, unless the mediator stops before: its log says what is wrong with the disk, and `mediator orders` then what became of the order"
                    .to_owned(),
            ),
        })
    }
}
