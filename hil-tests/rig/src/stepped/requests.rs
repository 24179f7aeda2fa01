//! What operators ask of a stepped robot, and what they are answered.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use onboard::process::ctl::{Done, Pending, Refusal, Reply, Request};

/// The requests of one robot's operators.
#[derive(Default)]
pub(super) struct Requests {
    waiting: VecDeque<(Request, Wanted)>,
    /// So many so far.
    asked: usize,
    /// Among them resets.
    resets: usize,
    answered: Arc<Mutex<Vec<Answered>>>,
}

/// Who wants it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wanted {
    /// Somebody who looks after the robot.
    InNeed,
    /// Somebody who says so at a bad moment.
    ByNobody,
}

struct Answered {
    name: &'static str,
    reply: Reply,
    wanted: Wanted,
}

impl Requests {
    pub(super) fn ask(&mut self, request: Request) {
        self.put(request, Wanted::InNeed);
    }

    /// A request at a bad moment, which may be refused for that.
    pub(super) fn ask_unwanted(&mut self, request: Request) {
        self.put(request, Wanted::ByNobody);
    }

    fn put(&mut self, request: Request, wanted: Wanted) {
        self.asked += 1;
        self.resets += usize::from(matches!(request, Request::Reset));
        self.waiting.push_back((request, wanted));
    }

    pub(super) fn times_asked(&self) -> usize {
        self.asked
    }

    pub(super) fn resets_asked(&self) -> usize {
        self.resets
    }

    /// The next one, for the supervisor. The number of a session at the desk goes to `lent`.
    pub(super) fn next(&mut self, lent: Arc<AtomicU64>) -> Option<Pending> {
        let (request, wanted) = self.waiting.pop_front()?;
        let (name, answered) = (request.name(), Arc::clone(&self.answered));
        Some(Pending::new(request, move |reply| {
            if let Ok(Done::Lent(session)) = reply {
                lent.store(*session, Ordering::Relaxed);
            }
            let mut all = answered.lock().unwrap_or_else(PoisonError::into_inner);
            all.push(Answered {
                name,
                reply: reply.clone(),
                wanted,
            });
        }))
    }

    pub(super) fn owes_an_answer(&self) -> bool {
        self.asked > self.answered().len()
    }

    pub(super) fn owes_an_answer_to_a_reset(&self) -> bool {
        let name = Request::Reset.name();
        let all = self.answered();
        self.resets > all.iter().filter(|own| own.name == name).count()
    }

    pub(super) fn replies(&self) -> Vec<(&'static str, Reply)> {
        let all = self.answered();
        { all.iter() }
            .map(|own| (own.name, own.reply.clone()))
            .collect()
    }

    pub(super) fn refused(&self) -> Vec<String> {
        let all = self.answered();
        { all.iter() }
            .filter_map(|own| Some((own, own.reply.as_ref().err()?)))
            .filter(|(own, why)| !is_asked_again(why) && !own.is_at_a_bad_moment(why))
            .map(|(own, why)| format!("{}: {why}", own.name))
            .collect()
    }

    fn answered(&self) -> MutexGuard<'_, Vec<Answered>> {
        let all = self.answered.lock();
        all.unwrap_or_else(PoisonError::into_inner)
    }
}

impl Answered {
    /// Whether nobody wanted it, and it was refused for the moment at which it was said.
    fn is_at_a_bad_moment(&self, why: &Refusal) -> bool {
        let moment = matches!(
            why,
            Refusal::MayMove | Refusal::ByHand | Refusal::Unmeasured | Refusal::AnotherReload
        );
        moment && self.wanted == Wanted::ByNobody
    }
}

/// Whether operators ask again what was refused for this reason: resets that left faults, to go on in spite of one, to read the files
/// of a robot that does not come to a stand, to place one whose drive fell silent just before, and what a computer has slept over.
fn is_asked_again(why: &Refusal) -> bool {
    matches!(
        why,
        Refusal::Remaining(_)
            | Refusal::StoppedByFault
            | Refusal::ReloadTooSlow(_)
            | Refusal::Slept
            | Refusal::Unmeasured
    )
}
