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
    /// The robot has been in it and gave it back, before it has answered the flag that let it in.
    pub(crate) left: bool,
}

/// How a robot has given an area back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GivenBack {
    /// It was not in it.
    Unused,
    /// It was, and wants it no more.
    Used,
    /// It was, and may want it still: it was asked for it, or knows again where it is.
    Taken,
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

    /// A robot that takes no part any more.
    pub(crate) fn released(robot: usize, script: &Script) -> Self {
        let over = Level {
            run: 1,
            ..begin(&script.protocol, MEDIATOR_PARTY).level()
        };
        Self::resume(robot, script, over, None).expect("a run may begin anew")
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
                Some(kept) => (kept.granted, kept.left) = (false, false),
                None => self.kept.push(Kept {
                    area,
                    granted: false,
                    left: false,
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
            kept.left = false;
        }
        news
    }

    /// The robot has not answered the flag that let it into an area. Where answers follow from protocol 1 they are not waited
    /// for: they come after the areas.
    fn is_on_the_way(&self, area: usize) -> bool {
        let protocol = self.side.protocol();
        let mut on_the_way = false;
        for (flag, _) in protocol.set_flags(self.side.read_to()) {
            if protocol.owner(flag) != Some(MEDIATOR_PARTY) {
                on_the_way = false;
            } else if self.enters[flag.index()].contains(&area) {
                on_the_way = true;
            }
        }
        on_the_way && self.own.is_none()
    }

    /// It has given an area back. One whose answers follow from protocol 1 may be in other areas of its passage, and get this one again.
    ///
    /// A robot may have been wrong about where it is, and have to go in again: what its flag let it into stays kept for it until
    /// it has answered that.
    pub(crate) fn gave_back(&mut self, area: usize, how: GivenBack) -> bool {
        let before = self.kept.len();
        let entered = match how {
            GivenBack::Unused => false,
            GivenBack::Used => true,
            GivenBack::Taken => self.own.is_none(),
        };
        if entered && self.is_on_the_way(area) {
            { self.kept.iter_mut() }
                .filter(|kept| kept.area == area && kept.granted)
                .for_each(|kept| (kept.granted, kept.left) = (false, true));
            return true;
        }
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
        let change = self.side.poll();
        if change.is_some() {
            self.kept.retain(|kept| !kept.left);
        }
        change
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
        participant.gave_back(4, GivenBack::Used);
        assert!(participant.keeps(4), "that was before");
        participant.granted(4);
        participant.gave_back(4, GivenBack::Unused);
        assert!(participant.keeps(4), "it was not in there");
        participant.granted(4);
        participant.gave_back(4, GivenBack::Used);
        assert!(!participant.keeps(4));
    }

    #[test]
    fn what_was_taken_from_one_whose_answers_follow_from_its_areas_stays_kept() {
        for (derived, stays) in [(true, true), (false, false)] {
            let script = script(protocols::control([]).expect("valid"));
            let mut participant = Participant::new(0, &script, derived);
            participant.keep(&[4]);
            participant.granted(4);
            participant.gave_back(4, GivenBack::Taken);
            assert_eq!(participant.keeps(4), stays);
        }
    }

    #[test]
    fn what_a_flag_lets_in_to_is_kept_until_it_is_answered() {
        let flags = [
            ("e1", true),
            ("done1", false),
            ("e2", true),
            ("done2", false),
        ];
        let mut script = script(protocols::control(flags).expect("valid"));
        let protocol = Arc::clone(&script.protocol);
        let flag = |name: &str| protocol.flag(name).expect("it has it");
        let mut enters = script.enters.to_vec();
        enters[flag("e1").index()] = vec![4];
        script.enters = enters.into();
        let mut participant = Participant::new(0, &script, false);
        let mut robot = begin(&protocol, ROBOT_PARTY);
        let mut both = |participant: &mut Participant, tell: &str, answer: Option<&str>| {
            participant.set(flag(tell)).expect("next");
            robot.merge(participant.level()).expect("follows");
            while robot.poll().is_some() {}
            let Some(answer) = answer else { return };
            robot.set(flag(answer)).expect("next");
            participant.merge(robot.level()).expect("follows");
            while participant.poll().is_some() {}
        };
        both(&mut participant, "acquire", Some("acquired"));
        both(&mut participant, "e1", None);
        for _ in 0..2 {
            participant.granted(4);
            assert!(participant.gave_back(4, GivenBack::Used));
            assert!(participant.keeps(4), "it has not said that it is done");
        }
        robot.set(flag("done1")).expect("next");
        participant.merge(robot.level()).expect("follows");
        while participant.poll().is_some() {}
        assert!(!participant.keeps(4));
    }
}
