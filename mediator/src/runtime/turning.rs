//! The thread of the area management activity: waits for what comes in, and takes one turn after the other.

use std::sync::PoisonError;
use std::sync::atomic::Ordering;
use std::time::Duration;

use contract::wire::MediatorReport;
use tokio::sync::mpsc::Sender;
use tokio::sync::mpsc::error::TrySendError;

use super::inbox::Inbox;
use super::management::{Management, TICK_NS};
use super::shared::Shared;
use super::turn::{Sent, Turn};
use crate::journal::StoreError;

/// Runs until it is told to stop, or the journal fails: nothing is granted that is not written down first.
pub(super) fn run(
    management: Result<Management, StoreError>,
    inbox: &Inbox,
    outbox: &Sender<MediatorReport>,
    shared: &Shared,
) -> Result<(), String> {
    let outcome = { management.map_err(|error| error.to_string()) }
        .and_then(|management| run_until_stopped(management, inbox, outbox, shared));
    shared.stop();
    outcome
}

fn run_until_stopped(
    management: Management,
    inbox: &Inbox,
    outbox: &Sender<MediatorReport>,
    shared: &Shared,
) -> Result<(), String> {
    let mut overflows = Overflows::default();
    let mut turn = Turn::new(management);
    let tick = Duration::from_nanos(TICK_NS);
    while !shared.is_stopping() {
        let inputs = if turn.is_blocked() {
            std::thread::sleep(tick);
            Vec::new()
        } else {
            inbox.take(tick)
        };
        turn.take_in(inputs.into_iter(), shared.now_ns())
            .map_err(|error| error.to_string())?;
        let now_ns = shared.now_ns();
        overflows.tell(inbox, shared, now_ns);
        let goes_on = turn.release(now_ns, |message| match outbox.try_send(message) {
            Ok(()) => Sent::Taken,
            Err(TrySendError::Full(_)) => Sent::Full,
            Err(TrySendError::Closed(_)) => Sent::Closed,
        });
        (shared.dropped_outputs).store(turn.dropped(), Ordering::Relaxed);
        if !goes_on {
            break;
        }
    }
    Ok(())
}

/// What was dropped or ignored; logged at most once in ten seconds.
#[derive(Default)]
struct Overflows {
    told: [u64; 3],
    again_ns: u64,
}

impl Overflows {
    fn tell(&mut self, inbox: &Inbox, shared: &Shared, now_ns: u64) {
        const PAUSE_NS: u64 = 10_000_000_000;
        if now_ns < self.again_ns {
            return;
        }
        let messages = shared.dropped_outputs.load(Ordering::Relaxed);
        let no_reports = shared.no_reports.load(Ordering::Relaxed);
        let now = [inbox.dropped(), messages, no_reports];
        if now == self.told {
            return;
        }
        let [reports, messages, no_reports] = now;
        if now[..2] != self.told[..2] {
            tracing::warn!(
                "overload: {reports} reports and questions and {messages} messages dropped since the start; each is sent again with \
                 the next level: see who sends so many, let robots report less often, or use a faster machine"
            );
        }
        if no_reports != self.told[2] {
            let last = { shared.last_no_report.lock() }.unwrap_or_else(PoisonError::into_inner);
            tracing::warn!(
                "{no_reports} messages since the start are no reports, and ignored; the last: {last}"
            );
        }
        self.told = now;
        self.again_ns = now_ns + PAUSE_NS;
    }
}
