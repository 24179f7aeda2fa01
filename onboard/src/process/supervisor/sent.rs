//! An event from outside for the robot's machine, until navigation says what became of it.

use coordination::fsm::{Machine, StateId};
use description::site::FsmConfig;
use skills::navigator::Instructed;

use crate::process::ctl::{Done, Pending, Refusal, Reply, quoted};
use crate::realtime::clock::SECOND_NS;

/// How long navigation may take to say what became of an event.
const ANSWER_NS: u64 = SECOND_NS;

/// An event that was sent to the robot's machine and waits for its answer.
pub(super) struct Sent {
    pub(super) event: String,
    pub(super) pending: Pending,
    pub(super) since_ns: u64,
}

impl Sent {
    /// Navigation had its time to answer.
    pub(super) fn is_late(&self, now_ns: u64) -> bool {
        now_ns > self.since_ns + ANSWER_NS
    }

    /// Answers who sent it; `fsm` is the machine that it was for.
    pub(super) fn answer(self, what: Instructed, machine: &Machine, fsm: &FsmConfig) {
        let event = self.event;
        let name = |state: StateId| machine.state_name(state).to_owned();
        let reply = match what {
            Instructed::Taken { from, to, hold } => Ok(Done::Sent {
                event,
                from: name(from),
                to: name(to),
                hold,
            }),
            Instructed::Ignored { state } => {
                let state = name(state);
                let accepted = { fsm.transitions.iter() }
                    .filter(|one| one.from == state && fsm.external.contains(&one.on));
                Err(Refusal::Ignored {
                    known: quoted(accepted.map(|one| &one.on)),
                    state,
                    event,
                })
            }
            Instructed::Refused(error) => Err(error.into()),
            Instructed::NotReady => Err(Refusal::NotReady),
        };
        answer(self.pending, &reply);
    }
}

/// Answers a request, and says so in the log.
pub(super) fn answer(pending: Pending, reply: &Reply) {
    let request = pending.request.name();
    match reply {
        Ok(done) => tracing::info!("operator: {request}: {done}"),
        Err(why) => tracing::info!("operator: {request}: refused: {why}"),
    }
    pending.answer(reply);
}
