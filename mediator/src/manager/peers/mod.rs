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
    /// Instance and epoch of the mediator that it names.
    names: Option<(u64, u64)>,
    /// It hears that one, which does not stand by.
    follows: bool,
    /// For its sake all are not asked again before.
    asks_again_ns: u64,
    /// They are to be asked then.
    asks: bool,
}

/// How many robots.
#[derive(Clone, Copy, Debug, Default)]
struct Count {
    name: usize,
    follow: usize,
}

/// For the sake of one robot all are asked what they have once in this time: one that lies again and again must not have all
/// register again and again. Nor does a mediator stop standing by sooner after all were asked last.
const ASK_PAUSE_NS: u64 = 2_000_000_000;

/// Two that stand by for each other's sake must not end that at the same time again and again: the one that fewer robots name waits so much
/// longer.
const YIELD_NS: u64 = 2_000_000_000;

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
    /// Robots that name somebody and are not silent, by when they were heard.
    heard: BTreeSet<(u64, usize)>,
    /// How many of these name each instance, by its epoch.
    counts: BTreeMap<(u64, u64), Count>,
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
        let (names, follows) = if before {
            // That one is gone, and whoever has its journal is whom its robots follow next.
            (Some((self.instance, report.mediator_epoch)), true)
        } else {
            let says = report.mediator_instance != 0;
            let named = (report.mediator_instance, report.mediator_epoch);
            (says.then_some(named), says && report.mediator_heard)
        };
        let was = *own;
        let counted = self.heard.remove(&(was.heard_ns, robot));
        *own = Follower {
            boot_epoch: report.boot_epoch,
            sequence: report.sequence,
            heard_ns: now_ns,
            names,
            follows,
            ..was
        };
        self.looks += 1;
        if let Some(named) = names {
            self.heard.insert((now_ns, robot));
            let count = self.counts.entry(named).or_default();
            count.name += 1;
            count.follow += usize::from(follows);
        }
        if counted {
            self.uncount(was);
        }
        true
    }

    fn uncount(&mut self, was: Follower) {
        if let Some(named) = was.names
            && let Some(count) = self.counts.get_mut(&named)
        {
            count.name -= 1;
            count.follow -= usize::from(was.follows);
            if count.name == 0 {
                self.counts.remove(&named);
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
            self.uncount(self.followers[robot]);
        }
    }

    /// Whether another mediator comes before this one, by how many robots `of` it counts; and whether it counts any of others.
    fn comes_after(&mut self, of: impl Fn(Count) -> usize) -> (bool, bool) {
        self.looks += self.counts.len() as u64;
        // Of the own instance how many, of each other one also the newest epoch.
        let (mut own, mut others) = (0, BTreeMap::<u64, (usize, u64)>::new());
        for (&(instance, epoch), &count) in &self.counts {
            let count = of(count);
            if instance == self.instance {
                own += count;
            } else if count > 0 {
                let (all, newest) = others.entry(instance).or_default();
                (*all, *newest) = (*all + count, epoch.max(*newest));
            }
        }
        let rank = |(count, epoch), instance| (count, epoch, Reverse(instance));
        let own = rank((own, self.epoch), self.instance);
        let after = { others.iter() }.any(|(&other, &rest)| rank(rest, other) > own);
        (after, !others.is_empty())
    }

    /// If it stands by, and has no more to give way, it does so until then.
    fn stands_by_until_ns(&mut self) -> u64 {
        let (yields, _) = self.comes_after(|count| count.name);
        self.goes_on_ns
            .saturating_add(if yields { YIELD_NS } else { 0 })
    }

    /// Decides anew who goes on. Returns whether people are to hear now that there is another one.
    pub(crate) fn decide(&mut self, now_ns: u64) -> bool {
        self.drop_silent(now_ns);
        let (gives_way, is_second) = self.comes_after(|count| count.follow);
        self.stands_by = gives_way || self.stands_by && now_ns < self.stands_by_until_ns();
        if !is_second {
            (self.since_ns, self.told) = (None, false);
            return false;
        }
        let since_ns = *self.since_ns.get_or_insert(now_ns);
        let lasts = now_ns > since_ns.saturating_add(DOUBLED_AFTER_NS);
        lasts && !std::mem::replace(&mut self.told, true)
    }
}

#[cfg(test)]
mod tests;
