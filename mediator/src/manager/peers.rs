//! Whether robots follow another mediator than this one, and which of the two goes on.
//!
//! All is learnt from what robots report, so both mediators judge alike: the one that more robots follow goes on, then the one
//! that has started more often, then the one with the smaller number. Any other stands by: it grants and orders nothing, and takes
//! in no robot. An earlier process with the same journal is none: this one could not have the journal if it were not gone.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use contract::client::{EPOCH_STEP, LAST_NUMBER};
use contract::timing::DOUBLED_AFTER_NS;
use contract::wire::RobotReport;

/// Whom a robot follows.
#[derive(Clone, Copy, Debug, Default)]
struct Follower {
    boot_epoch: u64,
    sequence: u64,
    heard_ns: u64,
    /// Instance and epoch; none while it hears nobody.
    follows: Option<(u64, u64)>,
    /// For its sake all are not asked again before.
    asks_again_ns: u64,
    /// They are to be asked then.
    asks: bool,
}

/// For the sake of one robot all are asked what they have once in this time: one that lies again and again must not have all
/// register again and again. Nor does a mediator stop standing by sooner after all were asked last.
const ASK_PAUSE_NS: u64 = 2_000_000_000;

/// For robots' sake the epoch grows by at most this much in the life of a process, so that also those follow that have heard its
/// first one only. The rest of [`EPOCH_STEP`] is for those that it takes by itself, one in [`ASK_PAUSE_NS`].
const MOST_GROWTH: u64 = EPOCH_STEP - (1 << 16);

/// What this mediator knows of others.
#[derive(Clone, Debug)]
pub(crate) struct Peers {
    /// Of this process.
    pub(crate) instance: u64,
    /// 0: it has none that others know.
    pub(crate) journal: u64,
    pub(crate) epoch: u64,
    /// With which it has started.
    first_epoch: u64,
    silent_after_ns: u64,
    followers: Vec<Follower>,
    /// Robots that follow somebody and are not silent, by when they were heard.
    heard: BTreeSet<(u64, usize)>,
    /// How many of these follow each instance, by its epoch.
    counts: BTreeMap<(u64, u64), usize>,
    /// Robots and counts looked at since the start.
    pub(crate) looks: u64,
    /// Another one goes on.
    pub(crate) stands_by: bool,
    /// If it stands by, it does so until then at least.
    goes_on_ns: u64,
    /// Since when robots follow another one.
    since_ns: Option<u64>,
    told: bool,
}

impl Peers {
    pub(crate) fn new(
        instance: u64,
        journal: u64,
        epoch: u64,
        robots: usize,
        silent_after_ns: u64,
    ) -> Self {
        Self {
            instance,
            journal,
            epoch,
            first_epoch: epoch,
            silent_after_ns,
            followers: vec![Follower::default(); robots],
            heard: BTreeSet::new(),
            counts: BTreeMap::new(),
            looks: 0,
            stands_by: false,
            goes_on_ns: 0,
            since_ns: None,
            told: false,
        }
    }

    /// The robot follows this mediator, or does not say whom.
    pub(crate) fn is_ours(&self, report: &RobotReport) -> bool {
        report.mediator_instance == self.instance || report.mediator_instance == 0
    }

    /// The robot follows this mediator's process before, which is gone.
    fn is_of_before(&self, report: &RobotReport) -> bool {
        report.mediator_journal == self.journal && report.mediator_epoch < self.epoch
    }

    /// The robot follows a mediator that this one knows nothing of, or did.
    pub(crate) fn is_foreign(&self, report: &RobotReport) -> bool {
        // One that does not say whom is told by its epoch.
        let says = report.mediator_instance != 0 || report.mediator_epoch > self.epoch;
        says && report.mediator_instance != self.instance && !self.is_of_before(report)
    }

    /// The epoch that this mediator must have, so that a robot follows it whose mediator is gone, or to which somebody has spoken
    /// in its name. One that has no registration takes any from another journal. Two mediators that refuse a robot each would
    /// else outdo each other for ever: it says of neither that it is heard, and at each larger epoch processes before it count as
    /// living for as long again. And none is taken that robots would not believe.
    /// `sent`: number of this mediator's last message to the robot.
    pub(crate) fn larger_epoch(&self, report: &RobotReport, sent: u64) -> Option<u64> {
        // One of an older version does not say whether its mediator is gone.
        let says = report.mediator_instance != 0 && !report.mediator_heard;
        let bound = report.session != 0 || report.mediator_journal == self.journal;
        let gone = says && bound && self.is_foreign(report) && !self.stands_by;
        let epoch = report.mediator_epoch;
        let most = self
            .first_epoch
            .saturating_add(MOST_GROWTH)
            .min(LAST_NUMBER);
        let larger = (self.epoch..most).contains(&epoch);
        (larger && (gone || self.is_ahead(report, sent))).then(|| epoch + 1)
    }

    /// The robot has heard this mediator with an epoch that it does not have, or with a number of a message after which too few
    /// are left: somebody has spoken in its name, or the robot lies. With a larger epoch messages count from anywhere. What this
    /// mediator has `sent` itself is no lie: after one of half of all numbers it counts on from there.
    pub(crate) fn is_ahead(&self, report: &RobotReport, sent: u64) -> bool {
        let heard = (report.mediator_epoch, report.mediator_sequence);
        report.mediator_instance == self.instance && heard > (self.epoch, sent.max(LAST_NUMBER / 2))
    }

    /// All are to be asked what they have, for this robot's sake. Returns whether they are now, and not later.
    pub(crate) fn ask(&mut self, robot: usize, now_ns: u64) -> bool {
        let own = &mut self.followers[robot];
        own.asks = now_ns < own.asks_again_ns;
        if !own.asks {
            own.asks_again_ns = now_ns.saturating_add(ASK_PAUSE_NS);
        }
        !own.asks
    }

    /// All are asked, under this epoch. To end standing by is to ask all again.
    pub(crate) fn note_asked(&mut self, epoch: u64, now_ns: u64) {
        self.epoch = epoch;
        self.goes_on_ns = now_ns.saturating_add(ASK_PAUSE_NS);
    }

    /// All are still to be asked for this robot's sake: until then it is not taken in.
    pub(crate) fn asks(&self, robot: usize) -> bool {
        self.followers[robot].asks
    }

    /// The robot has reported of late, whomever it follows.
    pub(crate) fn is_heard(&self, robot: usize, now_ns: u64) -> bool {
        let own = &self.followers[robot];
        own.sequence > 0 && now_ns <= own.heard_ns.saturating_add(self.silent_after_ns)
    }

    /// When the robot has reported last, whomever it follows; 0 where it has not since the start.
    pub(crate) fn heard_ns(&self, robot: usize) -> u64 {
        self.followers[robot].heard_ns
    }

    /// Returns whether the report is newer than the last one of its process, as it is in any case where that `is_known`.
    pub(crate) fn hear(
        &mut self,
        robot: usize,
        report: &RobotReport,
        is_known: bool,
        now_ns: u64,
    ) -> bool {
        let before = self.is_of_before(report);
        let own = &mut self.followers[robot];
        let old = own.boot_epoch == report.boot_epoch && report.sequence <= own.sequence;
        if old && !is_known {
            return false;
        }
        let follows = if before {
            // That one is gone, and whoever has its journal is whom its robots follow next.
            Some((self.instance, report.mediator_epoch))
        } else {
            (report.mediator_heard && report.mediator_instance != 0)
                .then_some((report.mediator_instance, report.mediator_epoch))
        };
        let counted = self.heard.contains(&(own.heard_ns, robot));
        let was = own.follows.filter(|_| counted);
        self.heard.remove(&(own.heard_ns, robot));
        *own = Follower {
            boot_epoch: report.boot_epoch,
            sequence: report.sequence,
            heard_ns: now_ns,
            follows,
            ..*own
        };
        self.looks += 1;
        if let Some(followed) = own.follows {
            self.heard.insert((now_ns, robot));
            *self.counts.entry(followed).or_default() += 1;
        }
        was.into_iter().for_each(|followed| self.uncount(followed));
        true
    }

    fn uncount(&mut self, followed: (u64, u64)) {
        if let Some(count) = self.counts.get_mut(&followed) {
            *count -= 1;
            if *count == 0 {
                self.counts.remove(&followed);
            }
        }
    }

    /// Those that have fallen silent follow nobody.
    fn drop_silent(&mut self, now_ns: u64) {
        while let Some(&(heard_ns, robot)) = self.heard.first()
            && now_ns > heard_ns.saturating_add(self.silent_after_ns)
        {
            self.looks += 1;
            self.heard.pop_first();
            if let Some(followed) = self.followers[robot].follows {
                self.uncount(followed);
            }
        }
    }

    /// Decides anew who goes on. Returns whether people are to hear now that there is another one.
    pub(crate) fn decide(&mut self, now_ns: u64) -> bool {
        self.drop_silent(now_ns);
        self.looks += self.counts.len() as u64;
        // Of the own instance how many, of each other one also the newest epoch.
        let (mut own, mut others) = (0, BTreeMap::<u64, (usize, u64)>::new());
        for (&(instance, epoch), &count) in &self.counts {
            if instance == self.instance {
                own += count;
            } else {
                let (all, newest) = others.entry(instance).or_default();
                (*all, *newest) = (*all + count, epoch.max(*newest));
            }
        }
        let rank = |(count, epoch), instance| (count, epoch, Reverse(instance));
        let own = rank((own, self.epoch), self.instance);
        let gives_way = { others.iter() }.any(|(&other, &rest)| rank(rest, other) > own);
        self.stands_by = gives_way || self.stands_by && now_ns < self.goes_on_ns;
        if others.is_empty() {
            (self.since_ns, self.told) = (None, false);
            return false;
        }
        let since_ns = *self.since_ns.get_or_insert(now_ns);
        let lasts = now_ns > since_ns.saturating_add(DOUBLED_AFTER_NS);
        lasts && !std::mem::replace(&mut self.told, true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SILENT_NS: u64 = 1_000_000_000;

    fn report(instance: u64, mediator_epoch: u64, sequence: u64) -> RobotReport {
        RobotReport {
            mediator_instance: instance,
            mediator_epoch,
            mediator_heard: true,
            boot_epoch: 5,
            sequence,
            ..RobotReport::default()
        }
    }

    /// Two mediators hear the same robots; whether each stands by.
    fn judged(follow: &[(u64, u64)], own: [(u64, u64); 2]) -> [bool; 2] {
        own.map(|(instance, epoch)| {
            let mut peers = Peers::new(instance, 6, epoch, follow.len(), SILENT_NS);
            for (robot, &(instance, epoch)) in follow.iter().enumerate() {
                peers.hear(robot, &report(instance, epoch, 1), false, 0);
            }
            peers.decide(0);
            peers.stands_by
        })
    }

    #[test]
    fn one_of_two_stands_by_whomever_robots_follow() {
        let (one, two, later) = ((7, 1), (8, 1), (9, 2));
        assert_eq!(judged(&[one, one], [one, two]), [false, true]);
        assert_eq!(judged(&[two, two, one], [one, two]), [true, false]);
        assert_eq!(judged(&[one, two], [one, two]), [false, true]);
        assert_eq!(judged(&[one, later], [one, later]), [true, false]);
        assert_eq!(judged(&[], [one, two]), [false, false]);
    }

    #[test]
    fn the_process_before_is_gone_but_not_that_of_a_copied_journal() {
        for (journal, epoch, stands_by) in [(6, 1, false), (9, 1, true), (0, 1, true), (6, 2, true)]
        {
            let mut peers = Peers::new(8, 6, 2, 1, SILENT_NS);
            let follows = RobotReport {
                mediator_journal: journal,
                ..report(7, epoch, 1)
            };
            peers.hear(0, &follows, false, 0);
            peers.decide(0);
            assert_eq!(peers.stands_by, stands_by, "{journal} {epoch}");
        }
    }

    #[test]
    fn robots_of_the_process_before_count_for_this_one() {
        let mut peers = Peers::new(8, 3, 5, 3, SILENT_NS);
        for robot in 0..2 {
            let of_before = RobotReport {
                mediator_journal: 3,
                // One has noticed already that it is gone.
                mediator_heard: robot == 0,
                ..report(7, 4, 1)
            };
            peers.hear(robot, &of_before, false, 0);
        }
        peers.hear(2, &report(9, 1 << 40, 1), false, 0);
        peers.decide(0);
        assert!(!peers.stands_by);
        // With one of them it says otherwise.
        peers.hear(1, &report(9, 1 << 40, 2), false, 0);
        peers.decide(0);
        assert!(peers.stands_by);
    }

    #[test]
    fn a_robot_that_another_mediator_has_refused_needs_no_larger_epoch() {
        let peers = Peers::new(8, 6, 2, 1, SILENT_NS);
        let follows = |session, mediator_journal| RobotReport {
            session,
            mediator_journal,
            mediator_heard: false,
            ..report(7, 4, 1)
        };
        assert_eq!(peers.larger_epoch(&follows(0, 9), 0), None);
        assert_eq!(peers.larger_epoch(&follows(5, 9), 0), Some(5));
        // It takes nothing older from the journal that it heard of last.
        assert_eq!(peers.larger_epoch(&follows(0, 6), 0), Some(5));
    }

    #[test]
    fn for_one_robot_all_are_asked_once_in_a_while() {
        let mut peers = Peers::new(8, 3, 5, 2, SILENT_NS);
        assert!(peers.ask(0, 0) && peers.ask(1, 0));
        assert!(!peers.ask(0, ASK_PAUSE_NS - 1) && peers.asks(0) && !peers.asks(1));
        peers.hear(0, &report(8, 5, 1), false, ASK_PAUSE_NS - 1);
        assert!(peers.asks(0) && peers.ask(0, ASK_PAUSE_NS) && !peers.asks(0));
    }

    #[test]
    fn it_goes_on_when_robots_hear_the_other_no_more_and_tells_once() {
        let mut peers = Peers::new(8, 6, 2, 1, SILENT_NS);
        let mut told = 0;
        for sequence in 1..=20 {
            let now_ns = sequence * SILENT_NS / 5;
            peers.hear(0, &report(7, 1, sequence), false, now_ns);
            told += u64::from(peers.decide(now_ns));
            assert!(peers.stands_by);
            assert_eq!(told, u64::from(sequence > 16));
        }
        let now_ns = 4 * SILENT_NS;
        let lost = RobotReport {
            mediator_heard: false,
            ..report(7, 1, 21)
        };
        peers.hear(0, &lost, false, now_ns);
        // Late.
        peers.hear(0, &report(7, 1, 20), false, now_ns);
        assert!(!peers.decide(now_ns) && !peers.stands_by && !peers.is_ours(&lost));
        peers.hear(0, &report(7, 1, 22), false, now_ns);
        peers.decide(now_ns);
        assert!(peers.stands_by);
        peers.decide(now_ns + SILENT_NS + 1);
        assert!(!peers.stands_by, "the robot itself is silent");
    }
}
