//! What is said between the mediator and a robot whose discrete control it takes, and what that means for the robot.

use std::sync::Arc;

use contract::protocols::{MEDIATOR_PARTY, RELEASE, ROBOT_PARTY};
use coordination::protocol::{FlagId, Position, Protocol};

use super::state::{Areas, Controlled, Kept, join};
use super::tokens::Progress;
use super::words::Words;
use crate::nets::Script;

/// What a flag means.
pub(super) struct Meaning {
    /// Areas that are kept for the robot from then on.
    pub(super) enters: Areas,
    /// For its machine.
    pub(super) event: Option<u16>,
    /// The robot sets it when its machine puts this out; none: as soon as it is next.
    pub(super) on_output: Option<u16>,
    pub(super) by_mediator: bool,
}

/// The protocol with the robot of a role.
pub(super) struct Talk {
    pub(super) protocol: Arc<Protocol>,
    /// By flag.
    pub(super) flags: Vec<Meaning>,
    pub(super) release: Option<FlagId>,
}

impl Talk {
    pub(super) fn of(script: &Script, words: &Words<'_>) -> Self {
        let protocol = &script.protocol;
        let word = |word: &str| words.get(word).copied().filter(|_| !word.is_empty());
        let flags = { protocol.flags().zip(&script.flags) }.map(|((id, _, party), flag)| {
            let mut enters = Areas::new();
            let areas = script.enters[id.index()].iter();
            join(&mut enters, areas.map(|&area| area as u16));
            Meaning {
                enters,
                event: { flag.instruction.as_ref() }.and_then(|own| word(&own.event)),
                on_output: word(&flag.on_output),
                by_mediator: party == MEDIATOR_PARTY,
            }
        });
        Self {
            flags: flags.collect(),
            release: protocol.flag(RELEASE),
            protocol: Arc::clone(protocol),
        }
    }

    /// The mediator's next flag, if it is its turn.
    pub(super) fn next_of_mediator(&self, part: &Controlled) -> Option<(FlagId, Position)> {
        let next = self.protocol.next(part.at.set).next()?;
        let open = part.at.set == part.at.read && !part.over;
        (open && self.flags[next.0.index()].by_mediator).then_some(next)
    }

    /// Sets the robot's next flags that wait for nothing, after one that waits for an output.
    pub(super) fn answer(&self, part: &mut Controlled, mut output: Option<u16>) {
        while part.heard == part.at.set {
            let next = self.protocol.next(part.at.set).find(|(flag, _)| {
                let own = &self.flags[flag.index()];
                !own.by_mediator && (own.on_output.is_none() || own.on_output == output)
            });
            let Some((flag, next)) = next else {
                return;
            };
            if self.flags[flag.index()].on_output.is_some() {
                output = None;
            }
            (part.at.set, part.heard) = (next, next);
        }
    }

    /// The last flag that lets into an area was not answered.
    pub(super) fn is_on_the_way(&self, part: &Controlled, area: u16) -> bool {
        let mut on_the_way = false;
        for (flag, _) in self.protocol.set_flags(part.at.read) {
            let own = &self.flags[flag.index()];
            on_the_way = if own.by_mediator {
                on_the_way || own.enters.contains(&area)
            } else {
                false
            };
        }
        on_the_way
    }

    pub(super) fn has_answered(&self, part: &Controlled) -> bool {
        let mut set = self.protocol.set_flags(part.at.read);
        set.any(|(flag, _)| self.protocol.owner(flag) == Some(ROBOT_PARTY))
    }
}

impl Controlled {
    pub(super) fn has_read(&mut self, talk: &Talk) {
        self.kept.retain(|kept| !kept.left);
        self.over = talk.protocol.is_end(self.at.read);
    }

    /// Sets a flag of the mediator's.
    pub(super) fn tell(&mut self, talk: &Talk, next: Option<(FlagId, Position)>) -> bool {
        let Some((flag, next)) = next else {
            return false;
        };
        self.at = Progress {
            set: next,
            read: next,
        };
        self.keep(talk, Some(flag));
        true
    }

    pub(super) fn keep(&mut self, talk: &Talk, flag: Option<FlagId>) {
        let Some(flag) = flag else { return };
        for &area in &talk.flags[flag.index()].enters {
            self.kept.retain(|kept| kept.area != area);
            self.kept.push(Kept {
                area,
                granted: false,
                left: false,
            });
        }
        self.kept.sort_unstable_by_key(|kept| kept.area);
    }
}
