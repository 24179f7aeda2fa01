//! The fleet's network on the simulated clock: messages take their time, and get lost, late or repeated as faults have it.
//!
//! In zenoh's place: a session of each robot, and nothing else of it (no discovery, no liveliness, no keys).

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use onboard::activities::communication::{Inbox, OpenSession, Session};
use sim::world::Random;

use super::faults::Weather;

/// How long a message takes: least and most.
const LATENCY_NS: [f64; 2] = [0.15e6, 0.9e6];
/// Latencies come from the seed.
const NETWORK_STREAM: u64 = 0x4E45_5457;
/// So does what becomes of messages while a fault lasts.
const CHANCE_STREAM: u64 = 0x4348_414E;

/// A message, encoded; robots have the numbers that they have in the scenario.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Message {
    pub(super) robot: usize,
    pub(super) kind: MessageKind,
    pub(super) bytes: Vec<u8>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MessageKind {
    /// Of a robot to everybody.
    State,
    /// Of a robot to the mediator.
    Report,
    /// The same to the second mediator, on a way of its own.
    SecondReport,
    /// Of the mediator to a robot.
    Answer,
}

/// The network.
pub(super) struct Network {
    random: Random,
    /// For what goes wrong.
    chance: Random,
    /// By the time at which it arrives, and a number that makes it unique.
    under_way: BTreeMap<(u64, u64), Message>,
    number: u64,
    lines: Arc<Mutex<Lines>>,
}

/// What sessions and network share.
#[derive(Default)]
struct Lines {
    /// Sent, and not taken up yet.
    sent: Vec<Message>,
    /// By robot and session: where its messages go, while the session is open. A robot and its clone have one each.
    inboxes: BTreeMap<(usize, u64), Inbox>,
    /// Sessions that were opened.
    opened: u64,
    /// By robot: its sessions up to this one carry nothing.
    dead: BTreeMap<usize, u64>,
}

impl Lines {
    fn is_dead(&self, robot: usize, session: u64) -> bool {
        { self.dead.get(&robot) }.is_some_and(|&last| session <= last)
    }
}

impl Network {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            random: Random::new(seed, NETWORK_STREAM),
            chance: Random::new(seed, CHANCE_STREAM),
            under_way: BTreeMap::new(),
            number: 0,
            lines: Arc::default(),
        }
    }

    /// How a robot opens its session.
    pub(super) fn session_of(&self, robot: usize) -> OpenSession {
        let lines = Arc::clone(&self.lines);
        Box::new(move |inbox| {
            let session = {
                let mut lines = lock(&lines);
                lines.opened += 1;
                let session = lines.opened;
                if let Some(inbox) = inbox {
                    lines.inboxes.insert((robot, session), inbox);
                }
                session
            };
            Ok(Box::new(Line {
                robot,
                session,
                lines: Arc::clone(&lines),
            }))
        })
    }

    /// The sessions that a robot has open carry nothing any more.
    pub(super) fn kill_sessions(&self, robot: usize) {
        let mut lines = lock(&self.lines);
        let last = lines.opened;
        lines.dead.insert(robot, last);
    }

    /// Sends a message, in this weather.
    pub(super) fn send(&mut self, message: Message, weather: Weather, now_ns: u64) {
        let [least_ns, most_ns] = LATENCY_NS;
        let latency_ns = least_ns + self.random.unit() * (most_ns - least_ns);
        if weather == Weather::default() {
            return self.carry(message, now_ns, latency_ns);
        }
        // Always as many draws: a fault changes no later one.
        let [lost, repeated, late, later] = std::array::from_fn(|_| self.chance.unit());
        if lost < weather.lost {
            return;
        }
        if repeated < weather.repeated {
            let latency_ns = latency_ns + later * weather.delay_ns;
            self.carry(message.clone(), now_ns, latency_ns);
        }
        self.carry(message, now_ns, latency_ns + late * weather.delay_ns);
    }

    fn carry(&mut self, message: Message, now_ns: u64, latency_ns: f64) {
        self.number += 1;
        let key = (now_ns + latency_ns as u64, self.number);
        self.under_way.insert(key, message);
    }

    /// What robots have sent since the last call.
    pub(super) fn take_sent(&mut self) -> Vec<Message> {
        std::mem::take(&mut lock(&self.lines).sent)
    }

    /// The next message that has arrived. Answers have been put into the inboxes of all who use their robot's key, if the sessions of
    /// any are not dead; else they are passed over.
    pub(super) fn arrived(&mut self, now_ns: u64) -> Option<Message> {
        loop {
            let message = self.next_arrived(now_ns)?;
            if message.kind != MessageKind::Answer || self.put(&message) {
                return Some(message);
            }
        }
    }

    fn next_arrived(&mut self, now_ns: u64) -> Option<Message> {
        let next = self.under_way.first_entry()?;
        if next.key().0 > now_ns {
            return None;
        }
        Some(next.remove())
    }

    /// Puts an answer into the inboxes for it; whether there are any.
    fn put(&self, message: &Message) -> bool {
        let (robot, mut heard) = (message.robot, false);
        let lines = lock(&self.lines);
        for (&(_, session), inbox) in lines.inboxes.range((robot, 0)..=(robot, u64::MAX)) {
            if !lines.is_dead(robot, session) {
                inbox.put(message.bytes.clone());
                heard = true;
            }
        }
        heard
    }
}

/// A robot's session.
struct Line {
    robot: usize,
    session: u64,
    lines: Arc<Mutex<Lines>>,
}

impl Line {
    fn send(&self, kind: MessageKind, bytes: Vec<u8>) {
        let robot = self.robot;
        let mut lines = lock(&self.lines);
        if !lines.is_dead(robot, self.session) {
            lines.sent.push(Message { robot, kind, bytes });
        }
    }
}

impl Session for Line {
    fn id(&self) -> String {
        format!("robot {}, session {}", self.robot, self.session)
    }

    fn send_state(&self, message: Vec<u8>) -> Result<(), String> {
        self.send(MessageKind::State, message);
        Ok(())
    }

    fn send_report(&self, message: Vec<u8>) -> Result<(), String> {
        self.send(MessageKind::Report, message);
        Ok(())
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        let key = (self.robot, self.session);
        lock(&self.lines).inboxes.remove(&key);
    }
}

fn lock(lines: &Mutex<Lines>) -> MutexGuard<'_, Lines> {
    lines.lock().unwrap_or_else(PoisonError::into_inner)
}
