//! A disk that takes 50 ms for each write, and then 2 s for one: what robots said meanwhile counts, and what operators gave up does
//! not. The disk moves the clock.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, MutexGuard, Once};
use std::time::Duration;

use contract::client::{Client, Situation};
use contract::timing::{ENTERS_NO_MORE_NS, SILENT_AFTER_NS};
use mediator::journal::Store;
use mediator::manager::{Manager, Status};
use mediator::runtime::{Answer, Asked, Asker, Input, Management, Question, Ticket, Waiting};

use crate::takeover::setup;

const REPORT_NS: u64 = 200_000_000;
const WRITE_NS: u64 = 50_000_000;
const STALL_NS: u64 = 2_000_000_000;
const TICK_NS: u64 = 20_000_000;

#[derive(Clone, Debug, Default)]
struct Disk {
    bytes: Arc<Mutex<Vec<u8>>>,
    now_ns: Arc<AtomicU64>,
    /// With the next write.
    stalls: Arc<AtomicBool>,
    full: Arc<AtomicBool>,
}

impl Disk {
    fn bytes(&self) -> MutexGuard<'_, Vec<u8>> {
        self.bytes.lock().expect("nobody panics")
    }

    fn now_ns(&self) -> u64 {
        self.now_ns.load(Ordering::Relaxed)
    }
}

impl redb::StorageBackend for Disk {
    fn len(&self) -> io::Result<u64> {
        Ok(self.bytes().len() as u64)
    }

    fn read(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        let start = usize::try_from(offset).expect("small");
        out.copy_from_slice(&self.bytes()[start..start + out.len()]);
        Ok(())
    }

    fn set_len(&self, length: u64) -> io::Result<()> {
        let length = usize::try_from(length).expect("small");
        self.bytes().resize(length, 0);
        Ok(())
    }

    fn sync_data(&self) -> io::Result<()> {
        let stalls = self.stalls.swap(false, Ordering::Relaxed);
        let takes_ns = if stalls { STALL_NS } else { WRITE_NS };
        self.now_ns.fetch_add(takes_ns, Ordering::Relaxed);
        Ok(())
    }

    fn write(&self, offset: u64, data: &[u8]) -> io::Result<()> {
        if self.full.load(Ordering::Relaxed) {
            return Err(io::ErrorKind::StorageFull.into());
        }
        let start = usize::try_from(offset).expect("small");
        self.bytes()[start..start + data.len()].copy_from_slice(data);
        Ok(())
    }
}

thread_local! {
    static LOG: RefCell<Option<Vec<u8>>> = const { RefCell::new(None) };
}

/// Keeps what is logged by threads that ask for it, each its own. A subscriber of one thread would not do: a line that another test
/// logs first may be switched off for good.
struct Log;

impl Log {
    fn of(run: impl FnOnce()) -> String {
        static SUBSCRIBED: Once = Once::new();
        SUBSCRIBED.call_once(|| {
            let subscriber = tracing_subscriber::fmt()
                .with_ansi(false)
                .with_writer(|| Self)
                .finish();
            tracing::subscriber::set_global_default(subscriber).expect("the only one");
            // For lines that were logged while it was set.
            tracing::callsite::rebuild_interest_cache();
        });
        LOG.replace(Some(Vec::new()));
        run();
        String::from_utf8(LOG.take().unwrap_or_default()).expect("text")
    }
}

impl Write for Log {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        LOG.with_borrow_mut(|kept| {
            kept.as_mut()
                .map_or(Ok(line.len()), |kept| kept.write(line))
        })
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

struct Hall {
    disk: Disk,
    management: Management,
    waiting: Waiting,
    robots: Vec<(Client, Situation)>,
    /// When robots have reported last.
    said_ns: u64,
}

impl Hall {
    fn new() -> Self {
        let setup = setup();
        let disk = Disk::default();
        let (store, stored) = Store::on(disk.clone(), "hall", 7).expect("opens");
        let manager = Manager::new(&setup, &stored, 0).expect("valid");
        let waiting = Waiting::new(manager.robot_ids());
        let management = Management::start(manager, store, BTreeMap::new()).expect("writes");
        disk.now_ns.fetch_add(ENTERS_NO_MORE_NS, Ordering::Relaxed);
        let robots = { setup.robots.iter() }.map(|own| {
            let situation = Situation {
                located: true,
                ..Situation::default()
            };
            (Client::new(&own.id, "hall", 7), situation)
        });
        Self {
            said_ns: disk.now_ns(),
            robots: robots.collect(),
            disk,
            management,
            waiting,
        }
    }

    /// Robots report five times a second, also while the disk writes.
    fn robots_report(&mut self) {
        while self.said_ns + REPORT_NS <= self.disk.now_ns() {
            self.said_ns += REPORT_NS;
            for (client, situation) in &mut self.robots {
                client.step(situation.clone(), self.said_ns, SILENT_AFTER_NS);
                self.waiting.report(Box::new(client.report()));
            }
        }
    }

    /// One turn, as the program takes it. Returns the robots and sequences of the reports that it has taken in.
    fn turn(&mut self) -> Vec<(String, u64)> {
        let inputs: Vec<Input> = std::iter::from_fn(|| self.waiting.take_next()).collect();
        let reports = inputs.iter().filter_map(|input| match input {
            Input::Report(own) => Some((own.robot_id.clone(), own.sequence)),
            Input::Question(_) => None,
        });
        let reports = reports.collect();
        let before_ns = self.disk.now_ns();
        { self.management.turn(inputs.into_iter(), before_ns) }.expect("it writes");
        if self.disk.now_ns() == before_ns {
            self.disk.now_ns.fetch_add(TICK_NS, Ordering::Relaxed);
        }
        self.robots_report();
        let now_ns = self.disk.now_ns();
        while let Some(message) = self.management.next_message(now_ns) {
            for (client, _) in &mut self.robots {
                client.receive(&message, now_ns);
            }
        }
        self.management.answer();
        reports
    }

    fn run(&mut self, for_ns: u64) {
        let until_ns = self.disk.now_ns() + for_ns;
        while self.disk.now_ns() < until_ns {
            self.turn();
        }
    }

    fn ask(&mut self, question: Question) -> (Ticket, Receiver<Answer>) {
        let (reply, answer) = channel();
        let reply = Box::new(move |answer| drop(reply.send(answer)));
        let asked = Asked::new(question, Asker::default(), reply);
        let ticket = asked.ticket();
        assert!(self.waiting.ask(asked));
        (ticket, answer)
    }

    fn status(&mut self) -> Status {
        let (_, answer) = self.ask(Question::Status);
        self.turn();
        match answer.try_recv() {
            Ok(Answer::Status(status)) => *status,
            other => panic!("{other:?}"),
        }
    }
}

fn close(area: &str) -> Question {
    Question::Close {
        area: area.to_owned(),
        why: String::new(),
    }
}

#[test]
fn a_stall_of_the_disk_makes_nobody_silent_and_carries_out_nothing_late() {
    let text = Log::of(stall);
    // It has stopped reporting when the stall began; the others have not.
    assert!(text.contains("robot `amr-3` is silent"), "{text}");
    assert_eq!(text.matches("is silent").count(), 1, "{text}");
}

fn stall() {
    let mut hall = Hall::new();
    hall.run(3_000_000_000);
    let status = hall.status();
    assert!(
        status.awaited.is_empty() && status.robots.iter().all(|own| own.heard),
        "{status:?}"
    );
    hall.robots.pop();
    hall.robots[0].1.wanted = vec!["gate".to_owned()];
    // With the request there is something to write.
    hall.disk.now_ns.fetch_add(REPORT_NS, Ordering::Relaxed);
    hall.robots_report();
    hall.disk.stalls.store(true, Ordering::Relaxed);
    let before_ns = hall.disk.now_ns();
    hall.turn();
    let now_ns = hall.disk.now_ns();
    assert!(now_ns >= before_ns + STALL_NS);
    // Meanwhile an operator has asked, and gone; another one waits.
    let (given_up, _) = hall.ask(close("yard"));
    let (_, answer) = hall.ask(close("gate"));
    assert!(given_up.give_up());
    // Of each robot the newest of ten reports is taken in, and its lease is what that was worth.
    let next = hall
        .robots
        .iter()
        .map(|(client, _)| client.clone().report());
    let newest: Vec<(String, u64)> = next.map(|own| (own.robot_id, own.sequence - 1)).collect();
    assert_eq!(hall.turn(), newest);
    assert!(matches!(answer.try_recv(), Ok(Answer::Done(_))));
    let status = hall.status();
    let closed: Vec<bool> = status.areas.iter().map(|area| area.closed).collect();
    assert_eq!(closed, [true, false]);
    assert!(status.robots[..2].iter().all(|own| own.heard), "{status:?}");
    let (_, answer) = hall.ask(Question::Orders);
    hall.turn();
    match answer.try_recv() {
        Ok(Answer::Orders(orders)) => assert_eq!(orders.len(), 1, "{orders:?}"),
        other => panic!("{other:?}"),
    }
    hall.run(SILENT_AFTER_NS);
    let now_ns = hall.disk.now_ns();
    let leases = { hall.robots.iter() }.all(|(client, _)| client.has_lease(now_ns));
    assert!(leases && hall.robots[0].0.is_registered());
}

/// It is carried out before the write that fails, and is written, and answered, when there is room.
#[test]
fn an_order_that_the_disk_does_not_take_is_not_said_to_be_refused() {
    let text = Log::of(full);
    let done = text.find("ordered `close gate`: area `gate` is closed");
    let written = text.find("the journal is written again");
    assert!(done > written && written.is_some(), "{text}");
    assert_eq!(text.matches("ordered `").count(), 1, "{text}");
}

fn full() {
    let mut hall = Hall::new();
    hall.run(3_000_000_000);
    hall.disk.full.store(true, Ordering::Relaxed);
    let (ticket, answer) = hall.ask(close("gate"));
    hall.turn();
    assert!(hall.management.is_blocked() && answer.try_recv().is_err());
    match ticket.wait_for(&answer, Duration::ZERO) {
        Answer::Underway(text) => assert!(
            text.contains("once the journal can be written") && text.contains("mediator orders"),
            "{text}"
        ),
        other => panic!("{other:?}"),
    }
    // What is not taken in is given up, and refused.
    let (ticket, answer) = hall.ask(close("yard"));
    let given_up = ticket.wait_for(&answer, Duration::ZERO);
    assert!(matches!(given_up, Answer::Refused(_)), "{given_up:?}");
    hall.disk.full.store(false, Ordering::Relaxed);
    let now_ns = hall.disk.now_ns.fetch_add(STALL_NS, Ordering::Relaxed) + STALL_NS;
    hall.management.retry(now_ns).expect("there is room");
    let status = hall.status();
    let closed: Vec<bool> = status.areas.iter().map(|area| area.closed).collect();
    assert_eq!(closed, [true, false]);
    let (_, answer) = hall.ask(Question::Orders);
    hall.turn();
    match answer.try_recv() {
        Ok(Answer::Orders(orders)) => {
            assert!(orders.len() == 1 && orders[0].done, "{orders:?}");
            assert_eq!(orders[0].order, "close gate");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_question_that_was_given_up_is_not_carried_out_later() {
    let mut hall = Hall::new();
    let (ticket, answer) = hall.ask(close("gate"));
    assert!(ticket.give_up());
    assert!(!hall.status().areas[0].closed && answer.try_recv().is_err());
    // One that is carried out already cannot be given up.
    let (ticket, answer) = hall.ask(close("gate"));
    assert!(hall.status().areas[0].closed && !ticket.give_up());
    assert!(matches!(answer.try_recv(), Ok(Answer::Done(_))));
}

/// Each time that the disk stalls, reports of both have waited, those of the second process first.
#[test]
fn no_second_process_takes_the_place_of_one_that_is_heard_while_the_disk_stalls() {
    let mut hall = Hall::new();
    hall.robots[0].1.wanted = vec!["gate".to_owned()];
    hall.run(3_000_000_000);
    assert!(hall.robots[0].0.holds("gate"));
    hall.robots[0].1.stands_in = vec!["gate".to_owned()];
    hall.run(1_000_000_000);
    let elsewhere = Situation {
        located: true,
        ..Situation::default()
    };
    let second = Client::new("amr-1", "hall", 8);
    hall.robots.insert(0, (second, elsewhere));
    for stall in 0..6 {
        let (_, answer) = hall.ask(match stall % 2 {
            0 => close("yard"),
            _ => Question::Open {
                area: "yard".to_owned(),
            },
        });
        hall.disk.stalls.store(true, Ordering::Relaxed);
        hall.turn();
        assert!(matches!(answer.try_recv(), Ok(Answer::Done(_))));
        assert!(!hall.robots[0].0.is_registered(), "stall {stall}");
    }
    let first = &hall.robots[1].0;
    assert!(first.is_registered() && first.holds("gate"));
}
