//! The area management activity: reports in, journal, messages out; its parts, which are handed the time.

use std::collections::BTreeMap;
use std::fmt::Display;

use super::checked::{LONGEST_TEXT, is_text, shown};
use super::input::{Asker, Input, Reply};
use super::orders::Orders;
use super::question::{Answer, Question};
use super::repeats::Repeats;
use crate::journal::{ClosedRecord, Entry, OrderRecord, Store, StoreError};
use crate::manager::{Cleared, Inside, Manager, Precedence, second_of};
use contract::wire::MediatorReport;

/// Time passes for the manager at least this often.
pub const TICK_NS: u64 = 20_000_000;
/// Levels are repeated this often, while there is something to do at all.
const REPEATS_NS: u64 = 2_000_000;
/// A journal that the disk does not take is tried again after this time.
const RETRY_NS: u64 = 1_000_000_000;
/// That it still does not is said again after this time.
const SAID_NS: u64 = 30_000_000_000;
/// What is written this late has left so late: nobody could answer it before.
const HELD_UP_NS: u64 = 500_000_000;

/// The disk does not take the journal.
#[derive(Clone, Copy, Debug)]
struct Blocked {
    since_ns: u64,
    retry_ns: u64,
    say_ns: u64,
}

/// Manager and journal, and what waits for the journal before it leaves.
pub struct Management {
    manager: Manager,
    store: Store,
    entries: Vec<Entry>,
    answers: Vec<(Reply, Answer)>,
    orders: Orders,
    /// Carried out, and not said yet.
    ordered: Vec<String>,
    /// When the last turn began, or what it wrote began to leave.
    turned_ns: u64,
    repeats: Repeats,
    blocked: Option<Blocked>,
    next_tick_ns: u64,
    next_repeats_ns: u64,
}

impl Management {
    /// Writes the new epoch to the journal before anybody hears of it. `orders` is what the journal has of them.
    ///
    /// # Errors
    /// [`StoreError`] when the journal cannot be written.
    pub fn start(
        mut manager: Manager,
        store: Store,
        orders: BTreeMap<u64, OrderRecord>,
    ) -> Result<Self, StoreError> {
        let entries: Vec<Entry> = manager.entries().collect();
        store.write(&entries)?;
        Ok(Self {
            manager,
            store,
            entries,
            answers: Vec::new(),
            orders: Orders::new(orders),
            ordered: Vec::new(),
            turned_ns: 0,
            repeats: Repeats::default(),
            blocked: None,
            next_tick_ns: 0,
            next_repeats_ns: 0,
        })
    }

    /// Takes in inputs, lets time pass, and writes the journal: one commit for all of them. What [`next_message`](Self::next_message)
    /// and [`answer`](Self::answer) give afterwards may leave. Nothing does while the disk does not take the journal: then
    /// this [`is_blocked`](Self::is_blocked), and is to be tried with [`retry`](Self::retry) instead.
    ///
    /// # Errors
    /// [`StoreError`] when the journal cannot be used any more.
    pub fn turn(
        &mut self,
        inputs: impl Iterator<Item = Input>,
        now_ns: u64,
    ) -> Result<(), StoreError> {
        let mut ordered = Vec::new();
        let mut inputs: Vec<Input> = inputs.collect();
        // A disk that has stalled makes nobody silent: who is there is heard before those who would take his place.
        inputs.sort_by_cached_key(|input| match input {
            Input::Report(report) => self.manager.precedence(report),
            Input::Question(_) => Precedence::Other,
        });
        for input in inputs {
            match input {
                Input::Report(report) => self.manager.report(&report, now_ns),
                Input::Question(asked) => {
                    if let Some((question, asker, reply)) = asked.take() {
                        let answer = self.reply_to(&question, &asker, now_ns);
                        if question.is_order() {
                            self.note_order(asker, &question, &answer, &mut ordered);
                        }
                        self.answers.push((reply, answer));
                    }
                }
            }
        }
        if now_ns >= self.next_tick_ns {
            self.manager.tick(now_ns);
            self.next_tick_ns = now_ns + TICK_NS;
            self.next_repeats_ns = now_ns + REPEATS_NS;
        } else if now_ns >= self.next_repeats_ns {
            self.manager.repeat_levels(now_ns);
            self.next_repeats_ns = now_ns + REPEATS_NS;
        }
        self.turned_ns = now_ns;
        self.entries.clear();
        self.entries.extend(self.manager.entries());
        self.entries.append(&mut ordered);
        if let Err(error) = self.store.write(&self.entries) {
            return self.block(error, now_ns);
        }
        self.tell_people(now_ns);
        Ok(())
    }

    /// The disk does not take the journal: nothing is to be taken in, and nothing leaves.
    #[must_use]
    pub fn is_blocked(&self) -> bool {
        self.blocked.is_some()
    }

    /// Tries to write what the disk did not take, once a second.
    ///
    /// # Errors
    /// As [`turn`](Self::turn).
    pub fn retry(&mut self, now_ns: u64) -> Result<(), StoreError> {
        let Some(blocked) = self.blocked.filter(|own| now_ns >= own.retry_ns) else {
            return Ok(());
        };
        let written = { self.store.reopen() }.and_then(|()| self.store.write(&self.entries));
        if let Err(error) = written {
            return self.block(error, now_ns);
        }
        self.blocked = None;
        let lasted_s = now_ns.saturating_sub(blocked.since_ns) as f64 * 1e-9;
        tracing::warn!("the journal is written again, after {lasted_s:.1} s; robots are answered");
        self.tell_people(now_ns);
        Ok(())
    }

    fn block(&mut self, error: StoreError, now_ns: u64) -> Result<(), StoreError> {
        if !matches!(error, StoreError::Disk { .. }) {
            return Err(error);
        }
        let blocked = self.blocked.get_or_insert(Blocked {
            since_ns: now_ns,
            retry_ns: now_ns,
            say_ns: now_ns,
        });
        blocked.retry_ns = now_ns.saturating_add(RETRY_NS);
        if now_ns >= blocked.say_ns {
            blocked.say_ns = now_ns.saturating_add(SAID_NS);
            tracing::error!("{error}");
        }
        Ok(())
    }

    /// Of what is in the journal.
    fn tell_people(&mut self, now_ns: u64) {
        for line in self.ordered.drain(..) {
            tracing::warn!("{line}");
        }
        for alarm in self.manager.alarms() {
            if let Some(line) = self.repeats.say(&alarm, now_ns) {
                tracing::warn!("{line}");
            }
        }
        for line in self.repeats.left_out(now_ns) {
            tracing::warn!("{line}");
        }
    }

    /// The next message to a robot.
    pub fn next_message(&mut self, now_ns: u64) -> Option<MediatorReport> {
        if self.is_blocked() {
            return None;
        }
        let held_up_ns = now_ns.saturating_sub(self.turned_ns);
        if held_up_ns >= HELD_UP_NS {
            self.manager.was_held_up(held_up_ns);
        }
        self.turned_ns = now_ns;
        self.manager.next_message(now_ns)
    }

    /// Answers the operators.
    pub fn answer(&mut self) {
        if self.is_blocked() {
            return;
        }
        for (reply, answer) in self.answers.drain(..) {
            reply(answer);
        }
    }

    fn note_order(
        &mut self,
        asker: Asker,
        question: &Question,
        answer: &Answer,
        entries: &mut Vec<Entry>,
    ) {
        if let Answer::Done(text) = answer {
            (self.ordered).push(format!("{} ordered `{question}`: {text}", asker.who));
        }
        self.orders.note(asker, question, answer, entries);
    }

    fn reply_to(&mut self, question: &Question, asker: &Asker, now_ns: u64) -> Answer {
        // It comes into logs, and to terminals and robots of others.
        if let Some(found) = question.texts().find(|text| !is_text(text)) {
            return Answer::Refused(format!(
                "{} is longer than {LONGEST_TEXT} bytes, or has control characters",
                shown(found)
            ));
        }
        let manager = &mut self.manager;
        let done = match question {
            Question::Status => return Answer::Status(Box::new(manager.status(now_ns))),
            Question::Orders => return Answer::Orders(self.orders.all()),
            Question::Why { robot } => manager.why(robot, now_ns).map_err(text),
            Question::Clear { area, taken_away } => {
                let cleared = manager.clear(area, *taken_away, now_ns);
                cleared.map_err(text).map(|done| cleared_of(area, &done))
            }
            Question::Close { area, why } => {
                let record = ClosedRecord {
                    at: asker.at.clone(),
                    who: asker.who.clone(),
                    why: why.clone(),
                };
                let closed = manager.close(area, record, now_ns);
                closed
                    .map_err(text)
                    .map(|inside| closed_with(area, &inside))
            }
            Question::Open { area } => {
                let opened = manager.open(area, now_ns);
                opened.map_err(text).map(|was_closed| match was_closed {
                    true => format!("area `{area}` is open"),
                    false => format!("area `{area}` was open already"),
                })
            }
            Question::End { coordination } => {
                let ended = manager.end(coordination, now_ns);
                ended.map_err(text).map(|(name, let_go)| {
                    let done = if let_go {
                        "its robots are let go as they are"
                    } else {
                        "its robots are told to get out of the way; end it again to let them go as they are"
                    };
                    format!("coordination `{name}` has ended: {done}")
                })
            }
            Question::Absent { robot, taken_away } => {
                let absent = manager.absent(robot, *taken_away, now_ns);
                absent.map_err(text).map(|areas| {
                    let areas = match areas[..] {
                        [] => "nothing".to_owned(),
                        _ => areas.join(", "),
                    };
                    format!("robot `{robot}` is absent; it had {areas}")
                })
            }
        };
        done.map_or_else(Answer::Refused, Answer::Done)
    }
}

/// What an operator is told who has cleared an area.
fn cleared_of(area: &str, done: &Cleared) -> String {
    let Cleared { of, left } = done;
    if of.is_empty() {
        return format!("area `{area}` was free already");
    }
    let mut text = format!("area `{area}` is free of {}", of.join(", "));
    if !left.is_empty() {
        text += &format!("; in it still: {}", left.join(", "));
    }
    text
}

/// What an operator is told who has closed an area.
fn closed_with(area: &str, inside: &Inside) -> String {
    let mut text = format!("area `{area}` is closed");
    let Inside {
        standing,
        seconds,
        granted,
    } = inside;
    let seconds = seconds.iter().map(|robot| second_of(robot));
    let inside: Vec<String> = standing.iter().cloned().chain(seconds).collect();
    if !inside.is_empty() {
        text += &format!("; in it: {}", inside.join(", "));
    }
    if !granted.is_empty() {
        text += &format!(
            "; granted already, and asked back: {} (one that is too near to stop still enters: see `mediator status`)",
            granted.join(", ")
        );
    }
    text
}

fn text(error: impl Display) -> String {
    error.to_string()
}
