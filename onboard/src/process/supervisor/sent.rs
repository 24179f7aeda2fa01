//! An event from outside for the robot's machine, until navigation says what became of it.

use description::site::FsmConfig;

use crate::activities::machine_names::MachineNames;
use crate::activities::port::Instructed;
use crate::process::ctl::Pending;
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
    pub(super) fn answer(self, what: Instructed, names: &MachineNames, fsm: &FsmConfig) {
        let event = &self.event;
        let state = |number: u16| names.state(number);
        let result = match what {
            Instructed::Taken { from, to, hold } => {
                let stands = hold.map_or(String::new(), |hold| {
                    format!("; the robot stands: {}", hold.reason())
                });
                Ok(format!(
                    "`{event}`: state {} -> {}{stands}",
                    state(from),
                    state(to)
                ))
            }
            Instructed::Ignored { state: number } => {
                let accepted = fsm
                    .transitions
                    .iter()
                    .filter(|t| t.from == state(number) && fsm.external.contains(&t.on))
                    .map(|t| &t.on);
                Err(format!(
                    "state `{}` has no use for `{event}`; it takes {}",
                    state(number),
                    quoted(accepted)
                ))
            }
            Instructed::Refused(error) => Err(error.to_string()),
            Instructed::NotReady => Err("navigation does not run yet".to_owned()),
        };
        tracing::info!("operator: send {event}: {result:?}");
        self.pending.answer(&result);
    }
}

/// Names for people: "`a`, `b`", or "none".
pub(super) fn quoted<'a>(names: impl Iterator<Item = &'a String>) -> String {
    let names: Vec<String> = names.map(|name| format!("`{name}`")).collect();
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}
