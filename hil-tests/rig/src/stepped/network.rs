//! The fleet's network on the simulated clock: messages take their time, and get lost, late or repeated as faults have it.
//!
//! In zenoh's place: a session of each robot, and nothing else of it (no discovery, no liveliness, no keys).

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use onboard::activities::communication::{Inbox, OpenSession, Session};
use sim::world::Random;

use super::message::{Message, MessageKind, Weather};

/// How long a message takes: least and most.
const LATENCY_NS: [f64; 2] = [0.15e6, 0.9e6];
/// Latencies come from the seed.
const NETWORK_STREAM: u64 = 0x4E45_5457;
/// One that is repeated comes once more within this time, mostly soon.
const AGAIN_NS: f64 = 10e9;
/// So does what becomes of messages while a fault lasts.
const CHANCE_STREAM: u64 = 0x4348_414E;

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
    /// Robots without a network interface.
    unreachable: BTreeSet<usize>,
}

impl Lines {
    fn is_dead(&self, robot: usize, session: u64) -> bool {
        self.unreachable.contains(&robot) || { self.dead.get(&robot) }
            .is_some_and(|&last| session <= last)
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
                if lines.unreachable.contains(&robot) {
                    return Err("there is no such interface".to_owned());
                }
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

    /// From now on a robot has no network interface, or has it: its sessions carry nothing meanwhile, and it can open none.
    pub(super) fn lose_interface(&self, robot: usize, gone: bool) {
        let mut lines = lock(&self.lines);
        if gone {
            lines.unreachable.insert(robot);
        } else {
            lines.unreachable.remove(&robot);
        }
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
            let latency_ns = latency_ns + later.powi(3) * AGAIN_NS.max(weather.delay_ns);
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
            let answers = matches!(
                message.kind,
                MessageKind::Answer | MessageKind::SecondAnswer
            );
            if !answers || self.put(&message) {
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

    fn is_linked(&self) -> bool {
        !lock(&self.lines).unreachable.contains(&self.robot)
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

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;
    const GOOD: Weather = Weather {
        lost: 0.0,
        repeated: 0.0,
        delay_ns: 0.0,
    };

    fn report(number: u64) -> Message {
        Message {
            robot: 0,
            kind: MessageKind::Report,
            bytes: number.to_le_bytes().to_vec(),
        }
    }

    /// Numbers of the reports that arrive, and how long each took, one being sent each millisecond in the weather of its number.
    fn arrived(seed: u64, count: u64, weather: impl Fn(u64) -> Weather) -> Vec<(u64, u64)> {
        let mut network = Network::new(seed);
        let mut arrived = Vec::new();
        for step in 0..count * 10 + 100_000 {
            // Ten steps for each millisecond, so that what takes less is told apart.
            let now_ns = step * MS / 10;
            if step % 10 == 0 && step / 10 < count {
                network.send(report(step / 10), weather(step / 10), now_ns);
            }
            while let Some(message) = network.arrived(now_ns) {
                let number = message.bytes.try_into().map(u64::from_le_bytes);
                let number = number.expect("eight bytes");
                arrived.push((number, now_ns - number * MS));
            }
        }
        arrived
    }

    #[test]
    fn in_good_weather_each_message_arrives_once_and_soon() {
        let all = arrived(1, 2000, |_| GOOD);
        let numbers: Vec<u64> = all.iter().map(|(number, _)| *number).collect();
        assert_eq!(numbers, (0..2000).collect::<Vec<_>>());
        let took = |most: bool| {
            all.iter()
                .map(|(_, ns)| *ns)
                .reduce(if most { u64::max } else { u64::min })
        };
        assert_eq!(
            (took(false), took(true)),
            (Some(2 * MS / 10), Some(9 * MS / 10))
        );
        assert_eq!(all, arrived(1, 2000, |_| GOOD));
        assert_ne!(all, arrived(2, 2000, |_| GOOD));
    }

    #[test]
    fn messages_get_lost_repeated_and_late_as_often_as_the_weather_says() {
        let lost = arrived(1, 2000, |_| Weather { lost: 0.3, ..GOOD });
        assert!((1300..1500).contains(&lost.len()), "{}", lost.len());
        assert!(arrived(1, 2000, |_| Weather { lost: 1.0, ..GOOD }).is_empty());
        let twice = arrived(1, 2000, |_| Weather {
            repeated: 0.3,
            ..GOOD
        });
        assert!((2500..2700).contains(&twice.len()), "{}", twice.len());
        let late = arrived(1, 2000, |_| Weather {
            delay_ns: 50.0 * MS as f64,
            ..GOOD
        });
        assert_eq!(late.len(), 2000);
        let overtakes = late.windows(2).filter(|pair| pair[1].0 < pair[0].0).count();
        assert!(overtakes > 500, "{overtakes}");
        let slowest = late.iter().map(|(_, ns)| *ns).max();
        assert!(
            slowest.is_some_and(|ns| (45 * MS..=51 * MS).contains(&ns)),
            "{slowest:?}"
        );
    }

    #[test]
    fn what_happened_to_some_messages_changes_nothing_for_later_ones() {
        let storm = |number: u64| Weather {
            lost: if number < 500 { 0.5 } else { 0.0 },
            ..GOOD
        };
        let after = arrived(3, 1000, storm);
        let calm = arrived(3, 1000, |_| GOOD);
        let later = |all: &[(u64, u64)]| {
            all.iter()
                .copied()
                .filter(|own| own.0 >= 500)
                .collect::<Vec<_>>()
        };
        assert!(after.len() < 900);
        assert_eq!(later(&after), later(&calm));
    }

    #[test]
    fn a_dead_link_carries_nothing_until_the_robot_opens_another_one() {
        let mut network = Network::new(1);
        let open = |network: &Network, robot| network.session_of(robot)(None).expect("a line");
        let (own, other) = (open(&network, 0), open(&network, 1));
        network.kill_sessions(0);
        for line in [&own, &other] {
            line.send_report(vec![1]).expect("sent");
        }
        let sent: Vec<usize> = network.take_sent().iter().map(|own| own.robot).collect();
        assert_eq!(sent, [1]);
        drop(own);
        open(&network, 0).send_state(vec![2]).expect("sent");
        let sent = network.take_sent();
        assert_eq!((sent.len(), sent[0].kind), (1, MessageKind::State));
        // Nobody hears what is said to a robot without an inbox.
        let answer = Message {
            kind: MessageKind::Answer,
            ..report(0)
        };
        network.send(answer, GOOD, 0);
        assert_eq!(network.arrived(10 * MS), None);
    }

    #[test]
    fn without_an_interface_nothing_is_opened_and_open_sessions_carry_on_afterwards() {
        let mut network = Network::new(1);
        let line = network.session_of(0)(None).expect("a line");
        network.lose_interface(0, true);
        line.send_report(vec![1]).expect("nobody waits for it");
        assert!(network.take_sent().is_empty() && !line.is_linked());
        assert!(network.session_of(0)(None).is_err());
        assert!(network.session_of(1)(None).is_ok(), "another computer's");
        network.lose_interface(0, false);
        line.send_report(vec![2]).expect("sent");
        assert!(network.session_of(0)(None).is_ok() && line.is_linked());
        assert_eq!(network.take_sent().len(), 1);
    }
}
