//! Protocol 1 of one robot and one area, from the mediator's side.

use contract::mention::Mention;
use contract::protocols::{AccessProtocol, MEDIATOR_PARTY, begin};
use coordination::protocol::{Change, Level, MergeError, Merged, Position, Replica, Side};

use crate::journal::AccessRecord;

/// What a robot did with an area.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Deed {
    Requested,
    Entered,
    /// Released, or returned without having been entered.
    GaveBack {
        entered: bool,
    },
}

/// A robot's claim on an area: the run of protocol 1 under way, and those before it.
#[derive(Clone, Debug)]
pub(crate) struct Claim {
    replica: Replica,
    granted_at: Position,
    entered_at: Position,
    /// Of the present grant, 0 without one.
    pub(crate) fence: u64,
    /// Place in the order of requests, 0 when none waits.
    pub(crate) ticket: u64,
    /// Later requests that were granted while it waits.
    pub(crate) passed: u32,
    /// When the request came, for `why`.
    pub(crate) asked_ns: u64,
    /// When it was last explained why it waits, and why; 0: never.
    pub(crate) why: (u64, String),
    /// An alarm was raised for its present level.
    pub(crate) complained: bool,
    /// Since it was granted its robot was started anew or did not know where it is, or the mediator was started: the robot may give it
    /// back though it wants it.
    pub(crate) doubtful: bool,
    mention: Mention,
}

impl Claim {
    /// Before the first request.
    pub(crate) fn new(protocol: &AccessProtocol) -> Self {
        Self::of(protocol, begin(&protocol.protocol, MEDIATOR_PARTY))
    }

    /// Where the journal, or the robot, left it.
    pub(crate) fn resume(
        protocol: &AccessProtocol,
        record: AccessRecord,
    ) -> Result<Self, MergeError> {
        Ok(Self {
            fence: record.fence,
            ticket: record.ticket,
            passed: record.passed,
            doubtful: true,
            ..Self::of(
                protocol,
                Replica::resume(&protocol.protocol, MEDIATOR_PARTY, record.level)?,
            )
        })
    }

    fn of(protocol: &AccessProtocol, replica: Replica) -> Self {
        Self {
            replica,
            granted_at: protocol.granted_at,
            entered_at: protocol.entered_at,
            fence: 0,
            ticket: 0,
            passed: 0,
            asked_ns: 0,
            why: (0, String::new()),
            complained: false,
            doubtful: false,
            mention: Mention::default(),
        }
    }

    /// The next thing that the robot did and that was not read yet.
    pub(crate) fn next_deed(&mut self, protocol: &AccessProtocol) -> Option<Deed> {
        let deed = match self.replica.poll()? {
            Change::Flag(flag) if flag == protocol.request => Deed::Requested,
            Change::Flag(flag) if flag == protocol.entered => Deed::Entered,
            Change::Flag(flag) => {
                debug_assert!(flag == protocol.released || flag == protocol.returned);
                self.fence = 0;
                let entered = flag == protocol.released;
                Deed::GaveBack { entered }
            }
            // Only the keeper aborts, and that is the mediator.
            Change::Aborted => return None,
        };
        Some(deed)
    }

    /// Sets `granted`; `false` when the robot has not asked.
    pub(crate) fn grant(&mut self, protocol: &AccessProtocol, fence: u64) -> bool {
        if self.replica.set(protocol.granted).is_err() {
            return false;
        }
        self.fence = fence;
        (self.ticket, self.passed, self.doubtful) = (0, 0, false);
        self.mention.renew();
        true
    }

    pub(crate) fn level(&self) -> Level {
        self.replica.level()
    }

    pub(crate) fn run(&self) -> u32 {
        self.replica.run()
    }

    /// Returns whether there is something new to read.
    pub(crate) fn merge(&mut self, level: Level) -> Result<bool, MergeError> {
        let merged = self.replica.merge(level)?;
        let news = merged != Merged::Nothing;
        if news || level.run < self.replica.run() {
            self.mention.renew();
        }
        Ok(news)
    }

    /// The robot is further, though ours has the last word on what follows.
    pub(crate) fn is_behind(&self, level: Level) -> bool {
        let ours = self.replica.level();
        (level.run, level.progress) > (ours.run, ours.progress)
    }

    /// A level that the robot can have only by the present grant, and whose fence is that of another one, or of none.
    pub(crate) fn is_of_other_grant(&self, level: Level, fence: u64) -> bool {
        /// Only `request` is set.
        const REQUESTED: u16 = 1;
        let ours = level.run == self.replica.run() && level.progress > REQUESTED;
        ours && self.is_held() && fence != self.fence
    }

    /// Aborts the run: the robot loses what it held by it.
    pub(crate) fn abort(&mut self) {
        // There are 2^32 run numbers; when they run out, the robot keeps the area.
        if self.replica.abort().is_ok() {
            self.mention.renew();
            self.fence = 0;
            (self.ticket, self.passed) = (0, 0);
        }
    }

    /// Requested and not granted, whether it has a ticket or not.
    pub(crate) fn is_requested(&self) -> bool {
        self.replica.position() != Position::START && !self.is_held()
    }

    /// Requested, not granted, and in the queue.
    pub(crate) fn waits(&self) -> bool {
        self.ticket != 0
    }

    pub(crate) fn is_held(&self) -> bool {
        let at = self.replica.position();
        at == self.granted_at || at == self.entered_at
    }

    pub(crate) fn is_entered(&self) -> bool {
        self.replica.position() == self.entered_at
    }

    /// It was ever used, so that the other side must know its run number.
    pub(crate) fn is_known(&self) -> bool {
        self.replica.run() > 0 || self.replica.position() != Position::START
    }

    /// Whether a message must mention it; `known`: the robot has heard that one, if any that counts.
    pub(crate) fn is_said(&self, known: Option<u64>) -> bool {
        let rests = self.replica.position() == Position::START;
        self.is_known() && !(rests && known.is_some_and(|heard| self.mention.is_known(heard)))
    }

    /// A message of this number is written.
    pub(crate) fn note(&mut self, number: u64) {
        self.mention.note(number);
    }

    pub(crate) fn record(&self) -> AccessRecord {
        AccessRecord {
            level: self.level(),
            fence: self.fence,
            ticket: self.ticket,
            passed: self.passed,
        }
    }
}

/// The claims of one robot by area, with room for those it has used only. Areas apart from claims: most questions are about
/// areas, and are answered without a look at the claims.
#[derive(Clone, Debug, Default)]
pub(crate) struct Claims {
    areas: Vec<usize>,
    claims: Vec<Claim>,
}

impl Claims {
    pub(crate) fn get(&self, area: usize) -> Option<&Claim> {
        let place = self.areas.binary_search(&area).ok()?;
        self.claims.get(place)
    }

    pub(crate) fn get_mut(&mut self, area: usize) -> Option<&mut Claim> {
        let place = self.areas.binary_search(&area).ok()?;
        self.claims.get_mut(place)
    }

    pub(crate) fn get_or_insert_with(
        &mut self,
        area: usize,
        new: impl FnOnce() -> Claim,
    ) -> &mut Claim {
        let place = self.areas.binary_search(&area).unwrap_or_else(|place| {
            self.areas.insert(place, area);
            self.claims.insert(place, new());
            place
        });
        &mut self.claims[place]
    }

    pub(crate) fn set(&mut self, area: usize, claim: Claim) {
        match self.areas.binary_search(&area) {
            Ok(place) => self.claims[place] = claim,
            Err(place) => {
                self.areas.insert(place, area);
                self.claims.insert(place, claim);
            }
        }
    }

    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Claim> {
        self.claims.iter_mut()
    }

    /// In the order of the areas.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, &Claim)> {
        self.areas.iter().copied().zip(&self.claims)
    }
}
