//! The poll loop: runs one of ethercrab's futures in place while carrying its frames over a link.
//!
//! A future that needs the bus marks a frame as sendable and is pending until the answer has been put into ethercrab's
//! storage. So one round is: poll, send the frame, wait for its answer, poll again. Frames are carried one at a time.
//! A future given up at the deadline must be dropped by the caller, which frees its frame for reuse.

use super::counters::BusCounters;
use super::seal::{self, MAX_FRAME, Verdict};
use crate::clock::Clock;
use crate::ethercat::links::Link;
use ethercrab::{PduRx, PduTx};
use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, Waker};

/// Most frames examined after the deadline: a thread that was held up finds its answer behind others.
const OVERTIME_FRAMES: u32 = 64;

/// Why a future did not become ready.
#[derive(Debug)]
pub enum Stopped {
    /// The deadline came first.
    Deadline,
    /// No answer after all the attempts allowed.
    Unanswered,
    /// The link refused.
    Link(io::Error),
    /// The future waits for something other than a frame, or its frame has no room for the seal.
    Stuck,
}

/// When to give up.
#[derive(Clone, Copy)]
pub struct Patience {
    /// On the link's clock.
    pub deadline_ns: u64,
    /// Send a frame again when it stays unanswered; without it one unanswered frame uses up the whole deadline.
    pub resend: Option<Resend>,
}

/// When to send a frame again, and the number of attempts including the first.
#[derive(Clone, Copy)]
pub struct Resend {
    pub after_ns: u64,
    pub attempts: u32,
}

/// A link with what is needed to carry ethercrab's frames over it.
pub struct Pump {
    link: Box<dyn Link>,
    pub clock: Arc<dyn Clock>,
    sent: Box<[u8; MAX_FRAME]>,
    sent_length: usize,
    received: Box<[u8; MAX_FRAME]>,
    /// The number of the last frame sent.
    number: u64,
    pub counters: BusCounters,
    /// When the last frame was sent, and when the last answer arrived.
    pub sent_ns: u64,
    pub received_ns: u64,
}

impl Pump {
    pub fn new(link: Box<dyn Link>) -> Pump {
        let clock = link.clock();
        // From process id and clock: numbers differ from those of the last run and of other programs on the wire.
        let number = (u64::from(std::process::id()) << 48) ^ clock.now_ns();
        Pump {
            link,
            clock,
            sent: Box::new([0; MAX_FRAME]),
            sent_length: 0,
            received: Box::new([0; MAX_FRAME]),
            number,
            counters: BusCounters::default(),
            sent_ns: 0,
            received_ns: 0,
        }
    }

    pub fn describe(&self) -> String {
        self.link.describe()
    }

    pub fn into_link(self) -> Box<dyn Link> {
        self.link
    }

    /// Runs `future` until it is ready. It must use the MainDevice that belongs to `tx` and `rx`.
    pub fn run<F: Future>(
        &mut self,
        (tx, rx): (&mut PduTx<'static>, &mut PduRx<'static>),
        mut future: Pin<&mut F>,
        patience: Patience,
    ) -> Result<F::Output, Stopped> {
        let mut context = Context::from_waker(Waker::noop());
        loop {
            if let Poll::Ready(output) = future.as_mut().poll(&mut context) {
                return Ok(output);
            }
            self.send_next(tx)?;
            self.carry(rx, patience)?;
        }
    }

    /// Takes the frame that the future has made, seals it and sends it.
    fn send_next(&mut self, tx: &mut PduTx<'static>) -> Result<(), Stopped> {
        let frame = tx.next_sendable_frame().ok_or(Stopped::Stuck)?;
        self.number = self.number.wrapping_add(1);
        let (sent, number, link) = (&mut self.sent, self.number, &mut self.link);
        let mut outcome = Err(Stopped::Stuck);
        let mut sealed_length = 0;
        self.sent_ns = self.clock.now_ns();
        // An error here only means that ethercrab keeps the frame; it goes when the caller drops the future.
        let _ = frame.send_blocking(|bytes| {
            let Some(room) = sent.get_mut(..bytes.len()) else {
                return Ok(0);
            };
            room.copy_from_slice(bytes);
            let Some(length) = seal::seal(&mut sent[..], bytes.len(), number) else {
                return Ok(0);
            };
            sealed_length = length;
            outcome = match link.send(&sent[..length]) {
                // The answer to a frame before: this one may still arrive.
                Err(error) if is_transient(&error) => Ok(()),
                other => other.map_err(Stopped::Link),
            };
            Ok(bytes.len())
        });
        self.sent_length = sealed_length;
        outcome
    }

    /// Waits for the answer to the frame that was sent, sending it again as allowed.
    fn carry(&mut self, rx: &mut PduRx<'static>, patience: Patience) -> Result<(), Stopped> {
        let Some(resend) = patience.resend else {
            return if self.await_answer(rx, patience.deadline_ns)? {
                Ok(())
            } else {
                Err(Stopped::Deadline)
            };
        };
        let mut last_error = None;
        for attempt in 0..resend.attempts.max(1) {
            let until_ns = { self.clock.now_ns() }
                .saturating_add(resend.after_ns)
                .min(patience.deadline_ns);
            if attempt > 0 {
                match self.link.send(&self.sent[..self.sent_length]) {
                    Err(error) if !is_transient(&error) => return Err(Stopped::Link(error)),
                    _ => {}
                }
            }
            match self.await_answer(rx, until_ns) {
                Ok(true) => return Ok(()),
                Ok(false) => {}
                // Nobody listens yet, or the network is coming up: worth the attempts that are left.
                Err(Stopped::Link(error)) => {
                    last_error = Some(error);
                    self.clock.sleep_until(until_ns);
                }
                Err(other) => return Err(other),
            }
            if self.clock.now_ns() >= patience.deadline_ns {
                return Err(last_error.map_or(Stopped::Deadline, Stopped::Link));
            }
        }
        Err(last_error.map_or(Stopped::Unanswered, Stopped::Link))
    }

    /// Hands the answer to ethercrab. `false` when it did not come in time.
    fn await_answer(&mut self, rx: &mut PduRx<'static>, until_ns: u64) -> Result<bool, Stopped> {
        let mut overtime_frames = OVERTIME_FRAMES;
        while overtime_frames > 0 {
            let received = self
                .link
                .receive(&mut self.received[..], until_ns)
                .map_err(Stopped::Link)?;
            let Some(length) = received else {
                return Ok(false);
            };
            let received = &mut self.received[..length.min(MAX_FRAME)];
            match seal::verify(&self.sent[..self.sent_length], received) {
                Verdict::Answer => {
                    self.received_ns = self.clock.now_ns();
                    seal::open(received);
                    if let Ok(ethercrab::ReceiveAction::Processed) = rx.receive_frame(received) {
                        return Ok(true);
                    }
                    self.counters.malformed_frames += 1;
                }
                Verdict::Other => self.counters.foreign_frames += 1,
                Verdict::Echo => self.counters.echoed_frames += 1,
                Verdict::Malformed => self.counters.malformed_frames += 1,
            }
            if self.clock.now_ns() >= until_ns {
                overtime_frames -= 1;
            }
        }
        Ok(false)
    }
}

/// The network's late answer to an earlier datagram, not a broken link.
fn is_transient(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::ConnectionRefused | io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted
    )
}

#[cfg(test)]
mod tests;
