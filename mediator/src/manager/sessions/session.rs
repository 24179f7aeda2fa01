//! Who speaks for one robot.

use contract::client::LAST_NUMBER;
use contract::timing::{DOUBLED_AFTER_NS, ENTERS_NO_MORE_NS, LEVEL_PERIOD_NS};
use contract::wire::RobotReport;

use super::factsheet::Factsheet;
use super::numbers::Numbers;
use crate::journal::RobotRecord;

/// The last 64 earlier boots are remembered, so that their late reports are recognised as such; and as many that were found beside
/// the one that speaks, which no number of restarts makes forgotten.
const RETIRED: usize = 64;
/// So many processes beside the one that speaks are told from each other. A holder of the robot's certificate can invent any number.
const RIVALS: usize = 8;
/// More processes of a robot than this are not taken in between two starts of the mediator.
pub(super) const SESSIONS_PER_EPOCH: u64 = 1_000_000;

/// A process that has asked to speak for the robot and has not yet repeated its session. It may be a late message of a
/// process that is long gone, so the present one keeps speaking until then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Candidate {
    pub(crate) boot_epoch: u64,
    /// 0: it gets none, only the reason.
    pub(crate) session: u64,
    pub(crate) since_ns: u64,
    /// Number of the last message before it was told so.
    after: u64,
}

/// A process that reports while another one speaks for the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Rival {
    boot_epoch: u64,
    /// Of its last report.
    sequence: u64,
    since_ns: u64,
    heard_ns: u64,
    /// Number of the last message to the robot when that had lasted for longer than a restart. Whoever has heard a later one
    /// has lived since.
    mark: Option<u64>,
    /// Both have.
    known: bool,
}

/// The process that speaks for a robot, and the one that asks to.
#[derive(Clone, Debug, Default)]
pub(crate) struct Session {
    /// Of the process that speaks for it; 0 before the first.
    pub(crate) number: u64,
    pub(crate) boot_epoch: u64,
    /// The last session number that was given out.
    issued: u64,
    pub(crate) candidate: Option<Candidate>,
    /// Never speak for the robot again: those that have, and those that were found beside one that does.
    retired: Vec<u64>,
    found: Vec<u64>,
    /// Heard of late, while another one speaks.
    rivals: Vec<Rival>,
    /// How often a second process was found beside the one that speaks.
    pub(crate) doubled: u64,
    /// Until then the process that speaks counts as living, whatever it said.
    alive_until_ns: u64,
    /// The last message of this mediator that it has heard.
    echo: u64,
    /// Messages from that one on were complete for the process that speaks, until it has heard one of them.
    says_from: u64,
    /// Another mediator may have granted it anything: what it says next is all that it has.
    pub(crate) unaccounted: bool,
    /// An operator has said that it is nowhere, and it was not heard since.
    pub(crate) absent: bool,
    /// It has reported since the start. Before that nothing is sent to it: its first report says whom it has followed so far.
    pub(crate) reports: bool,
    /// It has reported as one of this site.
    pub(crate) reports_here: bool,
    /// Its last report has named this site's floor.
    pub(crate) knows_floor: bool,
    /// It has said that it knows no protocol 2.
    pub(crate) without_control: bool,
    /// What kind of robot it is, by its own word.
    pub(crate) factsheet: Option<Factsheet>,
    /// It has repeated its session to this mediator, so that both mean the same levels.
    pub(crate) registered: bool,
    /// Of the last report of this boot.
    pub(crate) sequence: u64,
    pub(super) numbers: Numbers,
    /// Of the last one that counted: from that one on the robot's lease runs.
    pub(crate) counted: u64,
    pub(crate) heard_ns: u64,
    /// Until then another mediator, or this one before it was started, may have heard the robot.
    pub(crate) before_until_ns: u64,
    /// When the process that speaks was taken in; nothing when it is that of the journal, or all is known that those before
    /// it have left.
    taken_in_ns: Option<u64>,
    /// Number of the last message to the robot when that process was taken in; 0 when it is that of the journal.
    pub(super) taken_in_at: u64,
    /// Number of the last message to it when the body had entered all that it could.
    at_rest: Option<u64>,
    pub(crate) silent: bool,
    /// A process that was refused, and why.
    pub(crate) refused: Option<(u64, String)>,
    /// Of the last message to it.
    pub(crate) sent: u64,
    pub(crate) sent_ns: u64,
}

impl Session {
    /// Nobody has spoken for it yet.
    pub(crate) fn new(now_ns: u64) -> Self {
        Self {
            before_until_ns: now_ns,
            ..Self::default()
        }
    }

    /// The process of the journal may still be there, and needs its time to open a link to this mediator. One that asks meanwhile could
    /// speak for the body only after this time in any case.
    pub(crate) fn restore(&mut self, record: &RobotRecord, now_ns: u64) {
        self.alive_until_ns = now_ns.saturating_add(ENTERS_NO_MORE_NS);
        self.unaccounted = record.unaccounted;
        self.absent = record.absent;
        self.number = record.session;
        self.boot_epoch = record.boot_epoch;
        self.issued = record.issued;
        self.retired.clone_from(&record.retired);
        self.found.clone_from(&record.found);
    }

    /// What the journal must know of it.
    pub(crate) fn record(&self) -> RobotRecord {
        RobotRecord {
            session: self.number,
            boot_epoch: self.boot_epoch,
            issued: self.issued,
            retired: self.retired.clone(),
            found: self.found.clone(),
            unaccounted: self.unaccounted,
            absent: self.absent,
            ..RobotRecord::default()
        }
    }

    pub(crate) fn is_retired(&self, boot_epoch: u64) -> bool {
        self.retired.contains(&boot_epoch) || self.was_found(boot_epoch)
    }

    /// It has run beside one that speaks for the robot, so that it is of another body.
    pub(crate) fn was_found(&self, boot_epoch: u64) -> bool {
        self.found.contains(&boot_epoch)
    }

    /// This process has spoken for the robot, and is of another body than the one that does now, for all that is known.
    pub(crate) fn note_another(&mut self, boot_epoch: u64) {
        remember(&mut self.found, boot_epoch);
    }

    /// A process speaks for the robot, and it is that one.
    pub(crate) fn is_of(&self, boot_epoch: u64) -> bool {
        self.number > 0 && self.boot_epoch == boot_epoch
    }

    /// Whether the head of a report is that of the next one that counts.
    pub(crate) fn is_next(&self, report: &RobotReport) -> bool {
        let newer = self.is_of(report.boot_epoch) && report.sequence > self.sequence;
        newer && report.session == self.number
    }

    /// A process unknown so far asks to speak for this robot, and is offered a session. Its number is none that an earlier epoch has
    /// given out, of which the journal may have lost the last ones. Returns whether it was: another one has its time to repeat its
    /// session first, so that whoever makes up processes writes little into the journal.
    pub(crate) fn invite(&mut self, boot_epoch: u64, epoch: u64, now_ns: u64) -> bool {
        if self.offers_another(boot_epoch, now_ns) || self.has_used_up(epoch) {
            return false;
        }
        self.issued = self.issued.max(before(epoch)) + 1;
        self.candidate = Some(Candidate {
            boot_epoch,
            session: self.issued,
            since_ns: now_ns,
            after: self.sent,
        });
        true
    }

    /// Another process has its time to repeat the session that it was offered.
    fn offers_another(&self, boot_epoch: u64, now_ns: u64) -> bool {
        let other = { self.candidate.as_ref() }
            .filter(|own| own.session > 0 && own.boot_epoch != boot_epoch);
        other.is_some_and(|own| now_ns < own.since_ns.saturating_add(LEVEL_PERIOD_NS))
    }

    /// All sessions of the epoch were offered: no process is taken in any more.
    pub(crate) fn has_used_up(&self, epoch: u64) -> bool {
        self.issued >= before(epoch) + SESSIONS_PER_EPOCH
    }

    /// A process that does not speak for the robot is refused. Returns whether it hears so when its robot is told: not while another one
    /// has its time to repeat its session, which one that is refused must not keep out.
    pub(crate) fn refuse(&mut self, boot_epoch: u64, why: String, now_ns: u64) -> bool {
        self.refused = Some((boot_epoch, why));
        if self.offers_another(boot_epoch, now_ns) {
            return false;
        }
        if !self.is_of(boot_epoch) {
            self.candidate = Some(Candidate {
                boot_epoch,
                session: 0,
                since_ns: now_ns,
                after: self.sent,
            });
        }
        true
    }

    /// The candidate has repeated its session: it is alive, and from now on it speaks for the robot.
    pub(crate) fn promote(&mut self, candidate: Candidate, now_ns: u64) {
        if self.number > 0 {
            remember(&mut self.retired, self.boot_epoch);
        }
        self.candidate = None;
        self.rivals.clear();
        self.echo = 0;
        self.say_all();
        self.boot_epoch = candidate.boot_epoch;
        self.number = candidate.session;
        self.sequence = 0;
        self.counted = 0;
        self.registered = false;
        self.taken_in_ns = Some(now_ns);
        self.taken_in_at = self.sent;
        // One that was offered its session then has heard of it since.
        let at_rest = self.unknown_for_ns(candidate.since_ns) == 0;
        self.at_rest = at_rest.then_some(candidate.after);
    }

    /// Another mediator may have granted anything to it, or to a process before it.
    pub(crate) fn unaccount(&mut self, now_ns: u64) {
        self.unaccounted = true;
        self.before_until_ns = now_ns;
        self.at_rest = None;
        self.absent = false;
        self.registered = false;
        self.silent = true;
    }

    /// For how long the body may still enter what a process before this one was granted and this mediator knows nothing of: by
    /// a mediator before it whose journal has lost that, or another one.
    pub(crate) fn unknown_for_ns(&self, now_ns: u64) -> u64 {
        self.taken_in_ns.map_or(0, |taken_in_ns| {
            let granted_ns = taken_in_ns.min(self.before_until_ns);
            (granted_ns.saturating_add(ENTERS_NO_MORE_NS)).saturating_sub(now_ns)
        })
    }

    /// Whether its last report speaks for the body, too: it was made when no process before could carry it on any more.
    pub(crate) fn speaks_for_body(&mut self, now_ns: u64) -> bool {
        if self.taken_in_ns.is_none() {
            return true;
        }
        if self.unknown_for_ns(now_ns) > 0 {
            return false;
        }
        // A report may be late; one that knows of a message since is not.
        let speaks = self.echo > *self.at_rest.get_or_insert(self.sent);
        if speaks {
            self.taken_in_ns = None;
        }
        speaks
    }

    /// The process that speaks may know nothing of what was said so far.
    pub(crate) fn say_all(&mut self) {
        self.says_from = self.sent + 1;
    }

    /// The newest message that it has heard, if what rested in it need not be repeated.
    pub(crate) fn known(&self) -> Option<u64> {
        Some(self.echo).filter(|&heard| heard >= self.says_from)
    }

    /// The process that speaks for the robot lives, and has heard this message of the mediator.
    pub(crate) fn lives(&mut self, until_ns: u64, echo: u64) {
        self.alive_until_ns = until_ns;
        self.echo = echo;
        // Somebody has spoken to it in the mediator's name, with a number that was not reached yet. After a larger one too few are
        // left, and the epoch grows instead.
        if echo <= LAST_NUMBER / 2 {
            self.sent = self.sent.max(echo);
        }
    }

    /// The process that speaks for the robot lives until then at least, for all that is known.
    pub(crate) fn may_live(&mut self, until_ns: u64) {
        self.alive_until_ns = self.alive_until_ns.max(until_ns);
    }

    /// A process speaks for the robot, and is not silent: nobody else can.
    pub(crate) fn is_alive(&self, now_ns: u64) -> bool {
        self.number > 0 && now_ns <= self.alive_until_ns
    }

    /// A process reports that cannot speak for the robot now. Returns whether it turns out that two run at once; the second
    /// one is not taken in then when the first one falls silent, whose body may be in its areas all the same.
    pub(crate) fn turn_away(
        &mut self,
        boot_epoch: u64,
        sequence: u64,
        echo: Option<u64>,
        now_ns: u64,
        silent_after_ns: u64,
    ) -> bool {
        (self.rivals).retain(|rival| now_ns <= rival.heard_ns.saturating_add(silent_after_ns));
        let known = (self.rivals.iter()).any(|rival| rival.boot_epoch == boot_epoch);
        if !known && self.rivals.len() < RIVALS {
            self.rivals.push(Rival {
                boot_epoch,
                sequence: 0,
                since_ns: now_ns,
                heard_ns: now_ns,
                mark: None,
                known: false,
            });
        }
        let (sent, own_echo) = (self.sent, self.echo);
        let rival = (self.rivals.iter_mut())
            .find(|rival| rival.boot_epoch == boot_epoch && rival.sequence < sequence);
        // A report of a dead process may come again; one that lives reports on.
        let Some(rival) = rival else { return false };
        (rival.sequence, rival.heard_ns) = (sequence, now_ns);
        if now_ns <= rival.since_ns.saturating_add(DOUBLED_AFTER_NS) {
            return false;
        }
        // A late report tells of a living process only if it knows of something that was sent since; one that understands
        // nothing of it lives if it reports on for so long.
        let mark = *rival.mark.get_or_insert(sent);
        let hears = echo.is_none_or(|echo| echo > mark);
        if rival.known || !hears || own_echo <= mark {
            return false;
        }
        rival.known = true;
        self.doubled += 1;
        remember(&mut self.found, boot_epoch);
        true
    }

    /// It may be another body's process. One that has spoken for the robot or was found beside it may be gone, and its reports late:
    /// it lives if it has heard of something that was sent since another one speaks. Since when the journal's one speaks is not known,
    /// and one that was found hears the refusals of a mediator that has started again only after a second.
    pub(crate) fn may_be_second(&self, boot_epoch: u64, echo: Option<u64>) -> bool {
        let hears = echo.is_none_or(|echo| echo > self.taken_in_at);
        let lives = hears || self.taken_in_at == 0;
        !self.is_of(boot_epoch) && (lives || !self.is_retired(boot_epoch))
    }

    /// A second process runs beside the one that speaks for the robot.
    pub(crate) fn is_doubled(&self, now_ns: u64, silent_after_ns: u64) -> bool {
        self.rivals
            .iter()
            .any(|rival| rival.known && now_ns <= rival.heard_ns.saturating_add(silent_after_ns))
    }

    /// Why that process is refused; empty when it is not.
    pub(crate) fn refusal(&self, boot_epoch: u64) -> &str {
        let refused = { self.refused.as_ref() }.filter(|(boot, _)| *boot == boot_epoch);
        refused.map_or("", |(_, why)| why)
    }

    /// That process is refused, and has not spoken for the robot before another one: it may be the robot's next one.
    pub(crate) fn refuses(&self, boot_epoch: u64) -> bool {
        !self.refusal(boot_epoch).is_empty() && !self.is_retired(boot_epoch)
    }

    /// It reports, so that it can use a grant.
    pub(crate) fn is_heard(&self) -> bool {
        self.registered && !self.silent
    }
}

/// The last session that an earlier epoch may have given out.
fn before(epoch: u64) -> u64 {
    epoch
        .saturating_mul(SESSIONS_PER_EPOCH)
        .min(LAST_NUMBER / 2)
}

/// Remembers a boot with the last ones.
fn remember(boots: &mut Vec<u64>, boot_epoch: u64) {
    if boots.contains(&boot_epoch) {
        return;
    }
    if boots.len() == RETIRED {
        boots.remove(0);
    }
    boots.push(boot_epoch);
}
