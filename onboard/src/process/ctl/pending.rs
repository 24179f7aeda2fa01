//! A request on its way through the supervisor.

use super::reply::Reply;
use super::request::Request;

/// A request that waits for its answer.
pub struct Pending {
    /// What is asked.
    pub request: Request,
    answer: Box<dyn FnOnce(&Reply) + Send>,
}

impl Pending {
    /// A request; `answer` is told the reply.
    #[must_use]
    pub fn new(request: Request, answer: impl FnOnce(&Reply) + Send + 'static) -> Self {
        let answer = Box::new(answer);
        Self { request, answer }
    }

    /// Answers.
    pub fn answer(self, reply: &Reply) {
        (self.answer)(reply);
    }
}
