//! The mediator's side of the protocol with one robot of a coordination.

use std::sync::Arc;

use super::plan::Script;
use contract::protocols::{MEDIATOR_PARTY, ROBOT_PARTY, begin};
use coordination::protocol::{
    AbortError, Change, FlagId, Level, MergeError, Party, Position, Protocol, Replica, SetError,
    Side,
};

/// An area that is kept for a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Kept {
    pub(crate) area: usize,
    /// It was granted since.
    pub(crate) granted: bool,
}

#[derive(Clone, Debug)]
pub(crate) struct Participant {
    pub(crate) robot: usize,
    side: Replica,
    /// By flag: areas that are kept for the robot once it is set.
    enters: Arc<[Vec<usize>]>,
    /// The robot's side, where it follows from protocol 1.
    pub(crate) own: Option<Replica>,
    pub(crate) kept: Vec<Kept>,
}

impl Participant {
    pub(crate) fn new(robot: usize, script: &Script, derived: bool) -> Self {
        let side = |party| begin(&script.protocol, party);
        Self {
            robot,
            side: side(MEDIATOR_PARTY),
            enters: Arc::clone(&script.enters),
            own: derived.then(|| side(ROBOT_PARTY)),
            kept: Vec::new(),
        }
    }

    pub(crate) fn resume(
        robot: usize,
        script: &Script,
        level: Level,
        own: Option<Level>,
    ) -> Result<Self, MergeError> {
        let protocol = &script.protocol;
        let own = own.map(|own| Replica::resume(protocol, ROBOT_PARTY, own));
        Ok(Self {
            robot,
            side: Replica::resume(protocol, MEDIATOR_PARTY, level)?,
            enters: Arc::clone(&script.enters),
            own: own.transpose()?,
            kept: Vec::new(),
        })
    }

    /// What to tell the robot.
    pub(crate) fn level(&self) -> Level {
        self.side.level()
    }

    /// What to store: up to where flags were read or set. The rest comes again with the robot's next
    /// report.
    pub(crate) fn read_level(&self) -> Level {
        self.side.read_level()
    }

    /// The array was run to its end: for protocol 2 the robot is free again.
    pub(crate) fn is_over(&self) -> bool {
        // The robot sets the last flag of every path, so reading it begins the next run.
        self.side.read_level().run > 0
    }

    pub(crate) fn merge(&mut self, level: Level) -> Result<(), MergeError> {
        self.side.merge(level).map(|_| ())
    }

    /// The robot has set a flag that was not read.
    pub(crate) fn has_unread(&self) -> bool {
        self.side.peek().is_some()
    }

    /// Sets a flag of the robot's side, where that follows from protocol 1.
    pub(crate) fn set_own(&mut self, flag: FlagId) -> bool {
        let Some(own) = &mut self.own else {
            return false;
        };
        while own.poll().is_some() {}
        own.set(flag).is_ok() && self.side.merge(own.level()).is_ok()
    }

    /// Lets the robot's side know what the mediator's has set.
    pub(crate) fn tell_own(&mut self) {
        if let Some(own) = &mut self.own {
            let told = own.merge(self.side.level());
            debug_assert!(told.is_ok(), "both sides are ours: {told:?}");
            while own.poll().is_some() {}
        }
    }

    /// Where the robot's side is.
    pub(crate) fn own_position(&self) -> Option<Position> {
        self.own.as_ref().map(Replica::position)
    }

    /// Keeps areas for the robot.
    pub(crate) fn keep(&mut self, areas: &[usize]) {
        for &area in areas {
            match self.kept.iter_mut().find(|kept| kept.area == area) {
                Some(kept) => kept.granted = false,
                None => self.kept.push(Kept {
                    area,
                    granted: false,
                }),
            }
        }
    }

    pub(crate) fn keeps(&self, area: usize) -> bool {
        self.kept.iter().any(|kept| kept.area == area)
    }

    /// It was granted an area.
    pub(crate) fn granted(&mut self, area: usize) -> bool {
        let mut news = false;
        for kept in self.kept.iter_mut().filter(|kept| kept.area == area) {
            news |= !std::mem::replace(&mut kept.granted, true);
        }
        news
    }

    /// It has given an area back, after having been in it or not.
    pub(crate) fn gave_back(&mut self, area: usize, entered: bool) -> bool {
        let before = self.kept.len();
        if entered {
            // A grant from before the area was kept does not count: it will ask again.
            self.kept.retain(|kept| kept.area != area || !kept.granted);
        } else {
            { self.kept.iter_mut() }
                .filter(|kept| kept.area == area)
                .for_each(|kept| kept.granted = false);
        }
        self.kept.len() != before || !entered
    }
}

impl Side for Participant {
    fn protocol(&self) -> &Protocol {
        self.side.protocol()
    }

    fn party(&self) -> Party {
        MEDIATOR_PARTY
    }

    fn read_to(&self) -> Position {
        self.side.read_to()
    }

    /// Keeps the areas that the flag lets the robot into.
    fn set(&mut self, flag: FlagId) -> Result<(), SetError> {
        self.side.set(flag)?;
        self.tell_own();
        let enters = Arc::clone(&self.enters);
        self.keep(&enters[flag.index()]);
        Ok(())
    }

    fn peek(&self) -> Option<Change> {
        self.side.peek()
    }

    fn poll(&mut self) -> Option<Change> {
        self.side.poll()
    }

    /// The mediator is the keeper, and never gives up a run: it begins another instance.
    fn abort(&mut self) -> Result<Position, AbortError> {
        self.side.abort()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use contract::protocols;

    fn script(protocol: Protocol) -> Script {
        let enters = vec![Vec::new(); protocol.flags().count()];
        Script::new(Arc::new(protocol), enters)
    }

    #[test]
    fn what_is_stored_leaves_out_what_was_not_read() {
        let script = script(protocols::control([("e1", true), ("done1", false)]).expect("valid"));
        let protocol = &script.protocol;
        let mut participant = Participant::new(0, &script, false);
        let mut robot = begin(protocol, ROBOT_PARTY);
        participant
            .set(protocol.flag("acquire").expect("it has it"))
            .expect("first");
        robot.merge(participant.level()).expect("follows");
        robot.poll();
        robot
            .set(protocol.flag("acquired").expect("it has it"))
            .expect("next");
        participant.merge(robot.level()).expect("follows");
        assert_eq!(
            (
                participant.level().progress,
                participant.read_level().progress
            ),
            (2, 1)
        );
        let mut again =
            Participant::resume(0, &script, participant.read_level(), None).expect("its own");
        again.merge(robot.level()).expect("the robot says it again");
        assert_eq!(again.peek(), protocol.flag("acquired").map(Change::Flag));
        again.poll();
        assert_eq!(again.read_level().progress, 2);
    }

    #[test]
    fn an_old_grant_does_not_use_up_what_is_kept() {
        let mut participant =
            Participant::new(0, &script(protocols::control([]).expect("valid")), false);
        participant.keep(&[4]);
        participant.gave_back(4, true);
        assert!(participant.keeps(4), "that was before");
        participant.granted(4);
        participant.gave_back(4, false);
        assert!(participant.keeps(4), "it was not in there");
        participant.granted(4);
        participant.gave_back(4, true);
        assert!(!participant.keeps(4));
    }
}
