//! What management takes in, and how whoever has asked a question gives it up.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

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
        Ticket(Arc::clone(&self.taken))
    }
}

/// Of a question that waits.
pub struct Ticket(Arc<AtomicBool>);

impl Ticket {
    /// Gives the question up. Returns whether it is not carried out: else it is, and is answered soon.
    #[must_use]
    pub fn give_up(&self) -> bool {
        !self.0.swap(true, Ordering::AcqRel)
    }
}
