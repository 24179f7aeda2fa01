//! Protocol 1 of one robot and one area, from the mediator's side.

use std::sync::Arc;

use crate::journal::AccessRecord;
use contract::level::PROTOCOL_ID;
use contract::protocols::{self, ENTERED, GRANTED, MEDIATOR, RELEASED, REQUEST, RETURNED};
use coordination::protocol::{
    Change, FlagId, Level, MergeError, Merged, Party, Position, Protocol, Replica, Side,
};

/// The access protocol with its flags looked up.
#[derive(Clone, Debug)]
pub(super) struct AccessProtocol {
    protocol: Arc<Protocol>,
    mediator: Party,
    request: FlagId,
    granted: FlagId,
    entered: FlagId,
    released: FlagId,
    returned: FlagId,
    granted_at: Position,
    entered_at: Position,
}

/// What a robot did in a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Deed {
    Requested,
    Entered,
    /// The run is over: released, or returned without having been entered.
    GaveBack {
        entered: bool,
    },
}

/// A run under way, and those before it.
#[derive(Clone, Debug)]
pub(super) struct Run {
    replica: Replica,
    granted_at: Position,
    entered_at: Position,
    /// Of the present grant, 0 without one.
    pub(super) fence: u64,
    /// Place in the order of requests, 0 when none waits.
    pub(super) ticket: u64,
    /// When the request came, for `why`.
    pub(super) asked_ns: u64,
    /// Why it waits, as of then; 0: never said.
    pub(super) why: (u64, String),
    /// The robot has been told off for its present level.
    pub(super) complained: bool,
}

impl AccessProtocol {
    pub(super) fn new() -> Self {
        let protocol = protocols::access();
        let flag = |name| {
            protocol
                .flag(name)
                .expect("the access protocol has its flags")
        };
        let (request, granted, entered) = (flag(REQUEST), flag(GRANTED), flag(ENTERED));
        let after = |at, flag| {
            protocol
                .after(at, flag)
                .expect("the access protocol has its order")
        };
        let granted_at = after(after(Position::START, request), granted);
        Self {
            mediator: protocol
                .party(MEDIATOR)
                .expect("the access protocol has its parties"),
            request,
            granted,
            entered,
            released: flag(RELEASED),
            returned: flag(RETURNED),
            granted_at,
            entered_at: after(granted_at, entered),
            protocol: Arc::new(protocol),
        }
    }

    /// Before the first request.
    pub(super) fn begin(&self) -> Run {
        self.run(Replica::new(&self.protocol, PROTOCOL_ID, self.mediator, 0))
    }

    /// Where the journal left it.
    pub(super) fn resume(&self, record: AccessRecord) -> Result<Run, MergeError> {
        let mut run = self.run(Replica::resume(
            &self.protocol,
            self.mediator,
            record.level,
        )?);
        run.fence = record.fence;
        run.ticket = record.ticket;
        Ok(run)
    }

    fn run(&self, replica: Replica) -> Run {
        Run {
            replica,
            granted_at: self.granted_at,
            entered_at: self.entered_at,
            fence: 0,
            ticket: 0,
            asked_ns: 0,
            why: (0, String::new()),
            complained: false,
        }
    }

    /// The next thing that the robot did and that was not read yet.
    pub(super) fn next_deed(&self, run: &mut Run) -> Option<Deed> {
        let deed = match run.replica.poll()? {
            Change::Flag(flag) if flag == self.request => Deed::Requested,
            Change::Flag(flag) if flag == self.entered => Deed::Entered,
            Change::Flag(flag) => {
                debug_assert!(flag == self.released || flag == self.returned);
                run.fence = 0;
                let entered = flag == self.released;
                Deed::GaveBack { entered }
            }
            // Only the keeper aborts, and that is the mediator.
            Change::Aborted => return None,
        };
        Some(deed)
    }

    /// Sets `granted`; `false` when the robot has not asked.
    pub(super) fn grant(&self, run: &mut Run, fence: u64) -> bool {
        if run.replica.set(self.granted).is_err() {
            return false;
        }
        run.fence = fence;
        run.ticket = 0;
        true
    }
}

impl Run {
    pub(super) fn level(&self) -> Level {
        self.replica.level()
    }

    /// Returns whether there is something new to read.
    pub(super) fn merge(&mut self, level: Level) -> Result<bool, MergeError> {
        self.replica
            .merge(level)
            .map(|merged| merged != Merged::Nothing)
    }

    /// The other side is further than ours, though ours has the last word on what follows.
    pub(super) fn is_behind(&self, level: Level) -> bool {
        let ours = self.replica.level();
        (level.run, level.progress) > (ours.run, ours.progress)
    }

    /// A level about the present grant, or from before one.
    pub(super) fn fence_fits(&self, level: Level, fence: u64) -> bool {
        level.run != self.replica.run() || self.fence == 0 || fence == 0 || fence == self.fence
    }

    /// Gives the run up: the robot has nothing by it any more.
    pub(super) fn abort(&mut self) {
        // Run numbers last for four thousand million passages; when they end, the robot keeps the area.
        if self.replica.abort().is_ok() {
            self.fence = 0;
            self.ticket = 0;
        }
    }

    /// Requested and not granted, whether it has a ticket or not.
    pub(super) fn is_requested(&self) -> bool {
        self.replica.position() != Position::START && !self.is_held()
    }

    /// Requested, not granted, and in the queue.
    pub(super) fn waits(&self) -> bool {
        self.ticket != 0
    }

    pub(super) fn is_held(&self) -> bool {
        let at = self.replica.position();
        at == self.granted_at || at == self.entered_at
    }

    pub(super) fn is_entered(&self) -> bool {
        self.replica.position() == self.entered_at
    }

    /// It was ever used, so that the other side must know its run number.
    pub(super) fn is_known(&self) -> bool {
        self.replica.run() > 0 || self.replica.position() != Position::START
    }

    pub(super) fn record(&self) -> AccessRecord {
        AccessRecord {
            level: self.level(),
            fence: self.fence,
            ticket: self.ticket,
        }
    }
}

/// The runs of one robot by area, with room for those it has used only. Areas apart from runs: most questions are about
/// areas, and are answered without a look at the runs.
#[derive(Clone, Debug, Default)]
pub(super) struct Runs {
    areas: Vec<usize>,
    runs: Vec<Run>,
}

impl Runs {
    pub(super) fn get(&self, area: usize) -> Option<&Run> {
        let place = self.areas.binary_search(&area).ok()?;
        self.runs.get(place)
    }

    pub(super) fn get_mut(&mut self, area: usize) -> Option<&mut Run> {
        let place = self.areas.binary_search(&area).ok()?;
        self.runs.get_mut(place)
    }

    pub(super) fn get_or_insert_with(
        &mut self,
        area: usize,
        begin: impl FnOnce() -> Run,
    ) -> &mut Run {
        let place = self.areas.binary_search(&area).unwrap_or_else(|place| {
            self.areas.insert(place, area);
            self.runs.insert(place, begin());
            place
        });
        &mut self.runs[place]
    }

    pub(super) fn set(&mut self, area: usize, run: Run) {
        match self.areas.binary_search(&area) {
            Ok(place) => self.runs[place] = run,
            Err(place) => {
                self.areas.insert(place, area);
                self.runs.insert(place, run);
            }
        }
    }

    pub(super) fn len(&self) -> usize {
        self.areas.len()
    }

    /// In the order of the areas.
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, &Run)> {
        self.areas.iter().copied().zip(&self.runs)
    }
}
