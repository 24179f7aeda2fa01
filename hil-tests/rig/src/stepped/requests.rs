//! What operators ask of a stepped robot, and what they are answered.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use onboard::process::ctl::{Done, Pending, Refusal, Reply, Request};

/// The requests of one robot's operators.
#[derive(Default)]
pub(super) struct Requests {
    waiting: VecDeque<Request>,
    /// So many so far.
    asked: usize,
    replies: Arc<Mutex<Vec<(&'static str, Reply)>>>,
}

impl Requests {
    pub(super) fn ask(&mut self, request: Request) {
        self.asked += 1;
        self.waiting.push_back(request);
    }

    /// The next one, for the supervisor. The number of a session at the desk goes to `lent`.
    pub(super) fn next(&mut self, lent: Arc<AtomicU64>) -> Option<Pending> {
        let request = self.waiting.pop_front()?;
        let (name, replies) = (request.name(), Arc::clone(&self.replies));
        Some(Pending::new(request, move |reply| {
            if let Ok(Done::Lent(session)) = reply {
                lent.store(*session, Ordering::Relaxed);
            }
            let mut all = replies.lock().unwrap_or_else(PoisonError::into_inner);
            all.push((name, reply.clone()));
        }))
    }

    pub(super) fn owes_an_answer(&self) -> bool {
        self.asked > self.replies().len()
    }

    pub(super) fn replies(&self) -> Vec<(&'static str, Reply)> {
        let all = self.replies.lock();
        all.unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(super) fn refused(&self) -> Vec<String> {
        let replies = self.replies().into_iter();
        { replies.filter_map(|(name, reply)| Some((name, reply.err()?))) }
            .filter(|(_, why)| !is_asked_again(why))
            .map(|(name, why)| format!("{name}: {why}"))
            .collect()
    }
}

/// Whether operators ask again what was refused for this reason: resets that left faults, to go on in spite of one, and to read the files
/// of a robot that does not come to a stand.
fn is_asked_again(why: &Refusal) -> bool {
    matches!(
        why,
        Refusal::Remaining(_) | Refusal::StoppedByFault | Refusal::ReloadTooSlow(_)
    )
}
