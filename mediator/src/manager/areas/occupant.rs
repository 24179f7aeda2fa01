//! Where one robot is, and what it claims.

use contract::wire::Pose;

use super::claim::{Claim, Claims};
use super::revocation::Revocations;
use super::seconds::Seconds;

/// Where one robot is, and what it claims.
#[derive(Clone, Debug, Default)]
pub(crate) struct Occupant {
    pub(crate) located: bool,
    /// It has said in this session where it stands.
    pub(crate) placed: bool,
    /// Some process has said where it stands: its areas are no guess of before the first.
    pub(crate) is_known: bool,
    /// Areas it reaches into, sorted.
    pub(crate) stands_in: Vec<usize>,
    /// Other processes with its name, and where they stand by their own reports.
    pub(crate) seconds: Seconds,
    /// Areas that it was in and gave back, while it knew where it was; until its report is taken in.
    pub(crate) left: Vec<usize>,
    /// Areas in which it stood when it registered, without a grant.
    pub(crate) found_in: Vec<usize>,
    /// Areas for which an alarm was raised because it intrudes.
    pub(crate) intrudes_in: Vec<usize>,
    pub(crate) pose: Option<Pose>,
    pub(crate) fsm_state: String,
    /// Protocol 1 by area.
    pub(crate) claims: Claims,
    /// Grants that were asked back, by area.
    pub(crate) revocations: Revocations,
}

impl Occupant {
    /// What it has it may have because it was thought elsewhere.
    pub(crate) fn doubt(&mut self) {
        self.claims
            .iter_mut()
            .for_each(|claim| claim.doubtful = true);
    }

    /// Another process speaks for it, which does not know yet where it is.
    pub(crate) fn forget_place(&mut self) {
        self.doubt();
        self.placed = false;
        self.located = false;
        self.found_in.clear();
    }

    pub(crate) fn claim(&self, area: usize) -> Option<&Claim> {
        self.claims.get(area)
    }

    pub(crate) fn stands_in(&self, area: usize) -> bool {
        self.stands_in.contains(&area)
    }

    /// It has the area by a grant.
    pub(crate) fn holds(&self, area: usize) -> bool {
        self.claim(area).is_some_and(Claim::is_held)
    }

    /// It has said that it is in an area that it was granted.
    pub(crate) fn has_entered(&self, area: usize) -> bool {
        self.claim(area).is_some_and(Claim::is_entered)
    }

    /// It has asked for the area, and is in the queue.
    pub(crate) fn waits_for(&self, area: usize) -> bool {
        self.claim(area).is_some_and(Claim::waits)
    }

    /// All areas that it has asked for and waits for.
    pub(crate) fn waits(&self) -> impl Iterator<Item = usize> + '_ {
        { self.claims.iter() }
            .filter(|(_, claim)| claim.waits())
            .map(|(area, _)| area)
    }

    /// It may be in the area, by a grant or because it stands there.
    pub(crate) fn occupies(&self, area: usize) -> bool {
        self.has(area) || self.seconds.are_in(area)
    }

    /// Another body with its name is in the area: where the robot may be itself, one that was not found is taken for its next process.
    pub(crate) fn has_other_body_in(&self, area: usize) -> bool {
        self.seconds.are_found_in(area) || self.seconds.are_in(area) && !self.has(area)
    }

    /// Whoever says that it is in the area does not speak for it: another body with its name, or a process that may be its next one or
    /// has ended.
    pub(crate) fn is_only_said_to_be_in(&self, area: usize) -> bool {
        self.has_other_body_in(area) || !self.placed && !self.holds(area)
    }

    /// The one that speaks for it may be in the area.
    pub(crate) fn has(&self, area: usize) -> bool {
        self.holds(area) || self.stands_in(area)
    }

    /// It is in the area, or may still enter by a grant for the first time. Where a robot stands that has not said so is only guessed.
    pub(crate) fn is_or_will_be_in(&self, area: usize) -> bool {
        let has_left = self.placed && self.has_entered(area);
        let stands = self.stands_in(area) && (self.placed || self.holds(area));
        stands || self.holds(area) && !has_left
    }

    /// It reaches into the area and was not granted it; one that was found there is no intruder until it has left. Before it
    /// has said where it stands, nothing is known of that.
    pub(crate) fn intrudes(&self, area: usize) -> bool {
        self.placed && self.stands_in(area) && !self.holds(area) && !self.found_in.contains(&area)
    }

    /// An operator says that it has left the area.
    pub(crate) fn leave(&mut self, area: usize) {
        self.stands_in.retain(|&other| other != area);
        self.found_in.retain(|&other| other != area);
        self.seconds.leave(area);
    }
}
