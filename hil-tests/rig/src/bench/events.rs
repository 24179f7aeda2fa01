//! From one thread's event to another thread that waits for it: a queue and a futex word, as the activities use them, beside a channel
//! of the standard library. Who raises the event sleeps between two of them, and both threads have a robot's priority.

use std::marker::PhantomData;
use std::sync::mpsc;
use std::time::Duration;

use coordination::event::queue;
use onboard::cli::Failure;
use onboard::realtime::clock::{Monotonic, SECOND_NS, sleep_until};
use onboard::realtime::wake::Wake;
use sim::rt::monotonic_ns;

use super::measuring::Measuring;
use super::place::{Place, cores, last_core};
use super::report::{PartReport, Unit, What};
use super::samples::Sample;
use super::windows::{Contender, Meter};

/// From one event to the next: an hour has a million.
const PERIOD_NS: u64 = 200_000;
/// Of both threads: that of the motion thread.
const PRIORITY: u8 = 70;
/// Events that wait to be taken.
const ROOM: usize = 64;
/// What ends the thread that receives: no event is sent at this time.
const END: u64 = 0;

/// Measures for so long: two threads on one core, and, where there are two, each on a core of its own.
///
/// # Errors
/// [`Failure`] when ours cannot be measured.
pub fn measure(meter: &Meter, time: Duration, part: &mut PartReport) -> Result<(), Failure> {
    let (to, without) = Place::wanted(PRIORITY, last_core());
    part.notes.extend(without);
    let core = cores().first().copied().unwrap_or(to.core);
    let mut pairs = vec![("on its core", to)];
    if core != to.core {
        pairs.push(("on another core", Place { core, ..to }));
    }
    let each = time / pairs.len() as u32;
    for (what, from) in pairs {
        let title = format!("event to a thread {what}");
        let contenders: Vec<Box<dyn Contender>> = vec![
            Box::new(Threads::<Queue>::new(from, to)),
            Box::new(Threads::<Channel>::new(from, to)),
        ];
        meter.compare(part, &What::new(&title, Unit::Us), each, contenders)?;
    }
    Ok(())
}

/// Sends the time of an event.
type Raise = Box<dyn FnMut(u64) + Send>;
/// Waits for the next.
type Receive = Box<dyn FnMut() -> u64 + Send>;

/// A way of events from thread to thread.
trait Way: Send {
    /// What it is called.
    const NAME: &'static str;

    /// Its ends. Who receives hears [`END`] as well when nobody sends any more.
    fn ends() -> (Raise, Receive);
}

/// A queue and a futex word.
struct Queue;

impl Way for Queue {
    const NAME: &'static str = "onboard";

    fn ends() -> (Raise, Receive) {
        let (mut into, mut out) = queue(ROOM);
        let wake = Wake::default();
        let (other, mut seen) = (wake.clone(), 0);
        let send = Box::new(move |event| {
            // One that finds no room is missing, and the next is late by a whole queue.
            let _ = into.send(event);
            other.wake(monotonic_ns());
        });
        let receive = Box::new(move || {
            loop {
                if let Some(event) = out.receive() {
                    return event;
                }
                if out.is_abandoned() {
                    return END;
                }
                seen = wake.wait_beyond(&Monotonic, seen, monotonic_ns() + SECOND_NS);
            }
        });
        (send, receive)
    }
}

/// `std::sync::mpsc`.
struct Channel;

impl Way for Channel {
    const NAME: &'static str = "std::sync::mpsc";

    fn ends() -> (Raise, Receive) {
        let (into, out) = mpsc::sync_channel(ROOM);
        let send = Box::new(move |event| {
            // Who receives ends last.
            let _ = into.send(event);
        });
        let receive = Box::new(move || out.recv().unwrap_or(END));
        (send, receive)
    }
}

/// Two threads with a way between them, new in each window.
struct Threads<W> {
    from: Place,
    to: Place,
    way: PhantomData<W>,
}

impl<W: Way> Threads<W> {
    fn new(from: Place, to: Place) -> Self {
        let way = PhantomData;
        Self { from, to, way }
    }
}

impl<W: Way> Contender for Threads<W> {
    fn name(&self) -> String {
        W::NAME.to_owned()
    }

    fn window(&mut self, length: Duration, into: &mut Vec<Sample>) -> Result<(), Failure> {
        let (mut send, mut receive) = W::ends();
        let events = length.as_nanos() as u64 / PERIOD_NS;
        let (from, to) = (self.from, self.to);
        let receiver = Measuring::spawn("receiver", move || {
            let mut samples = Vec::with_capacity(events as usize);
            to.take()?;
            loop {
                let sent_ns = receive();
                let now_ns = monotonic_ns();
                if sent_ns == END {
                    return Ok(samples);
                }
                samples.push(Sample::from_to(sent_ns, now_ns));
            }
        })?;
        let sender = Measuring::spawn("sender", move || {
            from.take()?;
            let mut at_ns = monotonic_ns();
            for _ in 0..events {
                at_ns += PERIOD_NS;
                sleep_until(at_ns);
                send(monotonic_ns());
            }
            send(END);
            Ok(())
        })?;
        sender.end()?;
        into.extend(receiver.end()?);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_event_arrives_in_order_and_silence_is_an_end() {
        fn check<W: Way>(said: bool) {
            let (mut send, mut receive) = W::ends();
            let receiver = std::thread::spawn(move || {
                std::iter::from_fn(|| Some(receive()).filter(|event| *event != END)).collect()
            });
            for event in 1..=5 {
                send(event);
            }
            if said {
                send(END);
            }
            drop(send);
            let received: Vec<u64> = receiver.join().expect("it ends");
            assert_eq!(received, [1, 2, 3, 4, 5], "{}", W::NAME);
        }
        for said in [true, false] {
            check::<Queue>(said);
            check::<Channel>(said);
        }
    }

    #[test]
    fn each_event_is_a_sample() {
        let (place, _) = Place::wanted(10, last_core());
        let mut samples = Vec::new();
        let mut threads = Threads::<Queue>::new(place, place);
        let worked = threads.window(Duration::from_nanos(20 * PERIOD_NS), &mut samples);
        assert!(worked.is_ok(), "{worked:?}");
        assert_eq!(samples.len(), 20);
    }
}
