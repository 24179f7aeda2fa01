//! The mediator on the simulated clock: its area management with its journal, its bounded inbox and its period.
//!
//! Simulated are its network, and the disk below the journal.

use std::sync::{Arc, Mutex, PoisonError};

use contract::wire::MediatorReport;
use mediator::journal::Store;
use mediator::manager::{Manager, Status};
use mediator::nets::Plan;
use mediator::runtime::{
    Answer, Asked, Asker, Management, OUTPUTS, Question, Reply, Sent, TICK_NS, Ticket, Turn,
    Waiting, report_in,
};
use mediator::setup::Setup;
use onboard::cli::Failure;
use sim::world::Random;

use super::clock::shown_ns;
use super::disk::Disk;

/// How often the rig asks it how everything stands, as an operator would.
const STATUS_NS: u64 = 200_000_000;
/// After this time an operator who has no answer gives his question up, as in the mediator's own thread of communication.
const PATIENCE_NS: u64 = 2_000_000_000;
/// The numbers of a mediator and of its journal come from when it starts.
const INSTANCE_STREAM: u64 = 0x494E_5354;

/// What holds its thread of management up.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HeldUp {
    /// Writing the journal takes this long.
    pub(super) disk_ns: u64,
    /// It stands still.
    pub(super) hangs: bool,
}

/// The end of the mediator's process, once it writes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ending {
    /// Its computer loses its power.
    pub(super) by_power: bool,
    /// It comes then at the latest.
    pub(super) until_ns: u64,
}

/// What every start of a scenario's mediator shares.
pub(super) struct MediatorPlan {
    setup: Setup,
    nets: Vec<Arc<Plan>>,
}

impl MediatorPlan {
    pub(super) fn new(setup: Setup, nets: Vec<Arc<Plan>>) -> Self {
        Self { setup, nets }
    }

    /// The same, coordinating nobody.
    pub(super) fn without_nets(self) -> Self {
        let nets = Vec::new();
        Self { nets, ..self }
    }
}

/// A mediator.
pub(super) struct SteppedMediator {
    turn: Turn,
    inbox: Waiting,
    /// Its clock counts from its start,
    started_ns: u64,
    /// gets ahead of the world's this fast,
    drift: f64,
    /// is so far ahead, nanoseconds, or behind,
    ahead_ns: f64,
    /// and was looked at last then.
    stepped_ns: u64,
    /// When it goes on at the latest.
    wakes_ns: u64,
    /// When the journal is written and what waits for it may leave.
    written_ns: Option<u64>,
    asks_ns: u64,
    /// Of questions that wait, and when they are given up.
    tickets: Vec<(u64, Ticket)>,
    /// Shared with a question for the status for as long as somebody may answer it.
    asking: Arc<()>,
    status: Arc<Mutex<Option<Status>>>,
    /// Areas that an operator has cleared, not taken yet,
    cleared: Arc<Mutex<Vec<String>>>,
    /// and robots that he has said to be absent.
    absent: Arc<Mutex<Vec<String>>>,
}

impl SteppedMediator {
    /// Starts with the journal on this disk.
    pub(super) fn start(plan: &MediatorPlan, disk: Disk, now_ns: u64) -> Result<Self, Failure> {
        // No two start at once. Which of two has the larger number is chance, as it is among real ones.
        let mut random = Random::new(now_ns, INSTANCE_STREAM);
        let mut number = || (random.unit() * (1_u64 << 53) as f64) as u64 | 1;
        let (instance, journal) = (number(), number());
        let (store, stored) =
            Store::on(disk, &plan.setup.site, journal).map_err(Failure::refused)?;
        let manager = Manager::with_plans(&plan.setup, plan.nets.clone(), &stored, 0)
            .map_err(Failure::refused)?
            .speaks_as(instance);
        let ids = manager.robot_ids();
        let management = Management::start(manager, store, stored.orders);
        Ok(Self {
            turn: Turn::new(management.map_err(Failure::refused)?),
            inbox: Waiting::new(ids),
            started_ns: now_ns,
            drift: 0.0,
            ahead_ns: 0.0,
            stepped_ns: now_ns,
            wakes_ns: now_ns,
            written_ns: None,
            asks_ns: now_ns,
            tickets: Vec::new(),
            asking: Arc::default(),
            status: Arc::default(),
            cleared: Arc::default(),
            absent: Arc::default(),
        })
    }

    /// From now on its clock runs faster than the world's by this share, or slower.
    pub(super) fn drift(&mut self, share: f64) {
        self.drift = share;
    }

    /// A robot's report arrives.
    pub(super) fn deliver(&mut self, key: &str, message: &[u8]) {
        // Others are ignored, and counted by the listener.
        if let Ok(report) = report_in(key, message) {
            self.inbox.report(Box::new(report));
        }
    }

    fn put(&mut self, question: Question, reply: Reply) {
        let asker = Asker {
            who: "the rig".to_owned(),
            at: String::new(),
        };
        let asked = Asked::new(question, asker, reply);
        let ticket = asked.ticket();
        // One that finds no room is counted, and its operator is told to ask again.
        if self.inbox.ask(asked) {
            self.tickets.push((self.stepped_ns + PATIENCE_NS, ticket));
        }
    }

    /// What its thread of communication does for operators.
    fn serve_operators(&mut self, now_ns: u64) {
        self.tickets.retain(|(until_ns, ticket)| {
            let waits = now_ns < *until_ns;
            // Being carried out by now, it is answered all the same.
            let _ = waits || ticket.give_up();
            waits
        });
        if now_ns >= self.asks_ns && Arc::strong_count(&self.asking) == 1 {
            self.asks_ns = now_ns + STATUS_NS;
            self.ask();
        }
    }

    /// Goes on when there is something to do, and gives what leaves to `send`.
    ///
    /// # Errors
    /// [`Failure::Failed`] when the journal cannot be written, which ends it.
    pub(super) fn cycle(
        &mut self,
        now_ns: u64,
        held_up: HeldUp,
        mut send: impl FnMut(MediatorReport),
    ) -> Result<(), Failure> {
        self.ahead_ns += (now_ns - self.stepped_ns) as f64 * self.drift;
        self.stepped_ns = now_ns;
        let own_ns = shown_ns(now_ns - self.started_ns, self.ahead_ns);
        self.serve_operators(now_ns);
        if held_up.hangs {
            return Ok(());
        }
        if self.written_ns.is_none() {
            if self.inbox.is_empty() && now_ns < self.wakes_ns {
                return Ok(());
            }
            self.wakes_ns = now_ns + TICK_NS;
            let inputs = std::iter::from_fn(|| self.inbox.take_next());
            let turned = self.turn.take_in(inputs, own_ns);
            turned.map_err(Failure::failed)?;
            self.written_ns = Some(now_ns + held_up.disk_ns);
        }
        if self
            .written_ns
            .is_some_and(|written_ns| now_ns >= written_ns)
        {
            self.written_ns = None;
            let mut room = OUTPUTS;
            self.turn.release(own_ns, |message| {
                if room == 0 {
                    return Sent::Full;
                }
                room -= 1;
                send(message);
                Sent::Taken
            });
        }
        Ok(())
    }

    /// Messages, reports and questions that have found no room.
    pub(super) fn dropped(&self) -> u64 {
        self.turn.dropped() + self.inbox.dropped()
    }

    fn ask(&mut self) {
        let (status, asking) = (Arc::clone(&self.status), Arc::clone(&self.asking));
        let reply = Box::new(move |answer| {
            drop(asking);
            if let Answer::Status(told) = answer {
                *status.lock().unwrap_or_else(PoisonError::into_inner) = Some(*told);
            }
        });
        self.put(Question::Status, reply);
    }

    /// What an operator does with `mediator clear AREA --taken-away`.
    pub(super) fn clear(&mut self, area: &str) {
        let cleared = Arc::clone(&self.cleared);
        let name = area.to_owned();
        let question = Question::Clear {
            area: name.clone(),
            taken_away: true,
        };
        let reply = Box::new(move |answer| {
            if let Answer::Done(_) = answer {
                let mut cleared = cleared.lock().unwrap_or_else(PoisonError::into_inner);
                cleared.push(name);
            }
        });
        self.put(question, reply);
    }

    /// The same where only other bodies of a robot were, which is heard there and stays.
    pub(super) fn clear_of_seconds(&mut self, area: &str) {
        let question = Question::Clear {
            area: area.to_owned(),
            taken_away: true,
        };
        // Whether it is done, the next status says.
        self.put(question, Box::new(drop));
    }

    /// What an operator does with `mediator close AREA` and `mediator open AREA`.
    pub(super) fn close_or_open(&mut self, area: &str, closes: bool) {
        let area = area.to_owned();
        let question = if closes {
            let why = "a fault of the scenario".to_owned();
            Question::Close { area, why }
        } else {
            Question::Open { area }
        };
        // Whether it is done, the next status says.
        self.put(question, Box::new(drop));
    }

    /// What an operator does with `mediator end NUMBER`.
    pub(super) fn end(&mut self, coordination: u64) {
        let coordination = coordination.to_string();
        // It may have ended by itself by now.
        self.put(Question::End { coordination }, Box::new(drop));
    }

    /// What an operator does with `mediator absent ROBOT --taken-away`. It is refused while the robot may still be on its way.
    pub(super) fn say_absent(&mut self, robot: &str) {
        let absent = Arc::clone(&self.absent);
        let robot = robot.to_owned();
        let question = Question::Absent {
            robot: robot.clone(),
            taken_away: true,
        };
        let reply = Box::new(move |answer| {
            if let Answer::Done(_) = answer {
                let mut absent = absent.lock().unwrap_or_else(PoisonError::into_inner);
                absent.push(robot);
            }
        });
        self.put(question, reply);
    }

    /// Robots that are nowhere on the floor since an operator said so.
    pub(super) fn take_absent(&mut self) -> Vec<String> {
        std::mem::take(&mut self.absent.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Areas in which nobody is any more since an operator said so, each once.
    pub(super) fn take_cleared(&mut self) -> Vec<String> {
        std::mem::take(&mut self.cleared.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// How everything stands, once for each time that it was asked.
    pub(super) fn take_status(&mut self) -> Option<Status> {
        self.status
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take()
    }
}

#[cfg(test)]
mod tests {
    use contract::wire::RobotReport;

    use super::*;
    use crate::testing;

    #[test]
    fn a_message_that_finds_a_full_queue_is_counted_and_operators_are_answered_all_the_same() {
        let setup = Setup::of(&testing::site("overtaking")).expect("a good site");
        let plan = MediatorPlan::new(setup, Vec::new());
        let Ok(mut own) = SteppedMediator::start(&plan, Disk::default(), TICK_NS) else {
            panic!("it starts");
        };
        own.ask();
        own.inbox.report(Box::new(RobotReport {
            robot_id: "amr-1".into(),
            boot_epoch: 1,
            sequence: 1,
            ..RobotReport::default()
        }));
        let inputs = std::iter::from_fn(|| own.inbox.take_next());
        own.turn.take_in(inputs, 1).expect("the disk has room");
        assert!(own.turn.release(1, |_| Sent::Full));
        assert_eq!(own.dropped(), 1);
        assert!(own.take_status().is_some());
    }

    #[test]
    fn while_it_hangs_nobody_asks_twice_and_what_is_given_up_is_not_carried_out() {
        const SECOND_NS: u64 = 1_000_000_000;
        let setup = Setup::of(&testing::site("overtaking")).expect("a good site");
        let plan = MediatorPlan::new(setup, Vec::new());
        let Ok(mut own) = SteppedMediator::start(&plan, Disk::default(), SECOND_NS) else {
            panic!("it starts");
        };
        let mut now_ns = SECOND_NS;
        let mut pass = |own: &mut SteppedMediator, seconds: u64, hangs| {
            let held_up = HeldUp { disk_ns: 0, hangs };
            for _ in 0..seconds * 1000 {
                now_ns += 1_000_000;
                assert!(own.cycle(now_ns, held_up, |_| ()).is_ok());
            }
        };
        let closed = |own: &mut SteppedMediator| {
            let areas = own.take_status().expect("it is asked").areas;
            { areas.into_iter() }
                .filter(|area| area.closed_by.is_some())
                .map(|area| area.id)
                .collect::<Vec<_>>()
        };
        pass(&mut own, 1, false);
        assert_eq!(closed(&mut own), [""; 0]);
        own.close_or_open("1", true);
        pass(&mut own, 30, true);
        assert!(own.take_status().is_none());
        own.close_or_open("2", true);
        pass(&mut own, 1, true);
        pass(&mut own, 1, false);
        assert_eq!(closed(&mut own), ["2"], "that one still waits");
        assert_eq!(own.dropped(), 0);
    }
}
