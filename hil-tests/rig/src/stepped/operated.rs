//! What operators ask of a stepped robot, and what becomes of it.

use onboard::process::ctl::{Reply, Request};

use super::robot::SteppedRobot;

impl SteppedRobot {
    /// A request of an operator, which the supervisor serves when it looks next.
    pub fn ask(&mut self, request: Request) {
        self.requests.ask(request);
    }

    /// A request of an operator at a bad moment, which may be refused for that.
    pub(super) fn ask_unwanted(&mut self, request: Request) {
        self.requests.ask_unwanted(request);
    }

    /// An operator waits for an answer.
    pub fn owes_an_answer(&self) -> bool {
        self.requests.owes_an_answer()
    }

    /// How often operators have asked for something.
    pub(super) fn times_asked(&self) -> usize {
        self.requests.times_asked()
    }

    /// How often for a reset.
    pub(super) fn resets_asked(&self) -> usize {
        self.requests.resets_asked()
    }

    /// An operator who has asked for a reset waits for an answer.
    pub(super) fn owes_an_answer_to_a_reset(&self) -> bool {
        self.requests.owes_an_answer_to_a_reset()
    }

    /// What operators were refused; not what they ask for again.
    #[must_use]
    pub fn refused(&self) -> Vec<String> {
        self.requests.refused()
    }

    /// What operators were answered, in order: the name of the request, and the reply.
    #[must_use]
    pub fn replies(&self) -> Vec<(&'static str, Reply)> {
        self.requests.replies()
    }
}
