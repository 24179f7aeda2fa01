//! Robots get out of the way, and are let go.

use super::instance::{Instance, Phase, Stepped};
use super::participant::Participant;
use contract::protocols::{ACQUIRE, RELEASE};
use coordination::protocol::{FlagId, Party, Position, Side};

impl Instance {
    /// Acquires every robot, and tells it to get out of the way.
    pub(super) fn step_yielding(&mut self, stepped: &mut Stepped) {
        for participant in self.participants_mut() {
            let release = participant.protocol().flag(RELEASE);
            while participant.poll().is_some() {
                stepped.changed = true;
            }
            let Some(flag) = participant
                .next_of_mediator()
                .filter(|&next| Some(next) != release)
            else {
                continue;
            };
            stepped.changed |= participant.set(flag).is_ok();
        }
    }

    /// The robot of a role has read that it is to get out of the way, and waits for its release.
    pub(crate) fn has_read_halt(&self, role: usize) -> bool {
        let participant = &self.participants()[role];
        let release = participant.protocol().flag(RELEASE);
        matches!(self.phase, Phase::Yielding(_))
            && (participant.is_over()
                || (release.is_some() && participant.next_of_mediator() == release))
    }

    /// The robot of a role has set a flag, so that it knows of this coordination until it is over.
    pub(crate) fn is_known_to(&self, role: usize) -> bool {
        let participant = &self.participants()[role];
        let protocol = participant.protocol();
        { protocol.set_flags(participant.read_to()) }
            .any(|(flag, _)| protocol.owner(flag) == Some(Party::First))
    }

    /// Some robot is being released after yielding, as all are then: there is no way back.
    pub(crate) fn releases(&self) -> bool {
        matches!(self.phase, Phase::Yielding(_)) && { self.participants().iter() }.any(
            |participant| {
                let release = participant.protocol().flag(RELEASE);
                let mut set = participant.protocol().set_flags(participant.read_to());
                set.any(|(flag, _)| Some(flag) == release)
            },
        )
    }

    /// Gives all robots that have yielded their control back.
    pub(crate) fn release(&mut self, now_ns: u64) -> bool {
        let mut changed = false;
        for participant in self.participants_mut() {
            let release = participant.protocol().flag(RELEASE);
            if let Some(flag) = participant
                .next_of_mediator()
                .filter(|&next| Some(next) == release)
            {
                changed |= participant.set(flag).is_ok();
            }
        }
        if changed {
            self.progress_ns = now_ns;
        }
        changed
    }
}

impl Participant {
    /// The mediator's next flag, if it is its turn and there is no choice.
    fn next_of_mediator(&self) -> Option<FlagId> {
        let protocol = self.protocol();
        let (flag, _) = protocol.next(self.read_to()).next()?;
        let acquire = protocol.flag(ACQUIRE);
        let begins = self.read_to() == Position::START;
        (protocol.owner(flag) == Some(Party::Second)
            && !self.has_unread()
            && !self.is_over()
            && (!begins || Some(flag) == acquire))
            .then_some(flag)
    }
}
