//! Robots that go where they like, over the real network.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use contract::client::{Client, Situation};
use contract::floor::Floor;
use contract::wire::MediatorReport;
use contract::{Message, decode, keys};
use zenoh::Wait;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;

use crate::program::Site;
use crate::random::Random;

pub const PREFIX: &str = "fleet";
const SILENT_NS: u64 = 1_000_000_000;
const REPORT: Duration = Duration::from_millis(200);
const STEP: Duration = Duration::from_millis(4);
/// A robot that has waited for this time picks another place.
const PATIENCE: Duration = Duration::from_millis(400);

struct Robot {
    id: String,
    client: Client,
    /// Where it may go.
    places: Vec<String>,
    at: String,
    wants: Option<String>,
    /// It reaches over the border to there.
    crossing: Option<String>,
    until: Instant,
    asked: Instant,
    reported: Option<Instant>,
    moves: u64,
    /// Grants that were taken away from processes before this one.
    lost: u64,
}

/// All of them, in one thread: the caller's.
pub struct Fleet {
    // Before the session, so that they go first.
    publishers: BTreeMap<String, Publisher<'static>>,
    _session: zenoh::Session,
    inbox: Receiver<MediatorReport>,
    robots: Vec<Robot>,
    random: Random,
    site: String,
    begun: Instant,
    crossing: String,
    crossings: u64,
    forgot: u64,
    parks: bool,
}

impl Fleet {
    /// The first `roamers` never use the crossing.
    pub fn new(
        session: zenoh::Session,
        site: &Site,
        roamers: usize,
        crossing: &str,
        seed: u64,
    ) -> Self {
        let mut random = Random::new(seed);
        let (news, inbox) = channel();
        session
            .declare_subscriber(keys::to_all_robots(PREFIX).expect("a plain name"))
            .callback(move |sample| {
                let message = decode(&sample.payload().to_bytes()).expect("a message");
                // After the end nobody listens.
                let _ = news.send(message);
            })
            .background()
            .wait()
            .expect("it subscribes");
        let mut publishers = BTreeMap::new();
        let mut robots = Vec::new();
        for (number, (id, _, place)) in site.robots.iter().enumerate() {
            let publisher = session
                .declare_publisher(keys::report(PREFIX, id).expect("a plain name"))
                // The observer must hear everything, in this order.
                .congestion_control(CongestionControl::Block)
                .express(true)
                .wait();
            publishers.insert(id.clone(), publisher.expect("it publishes"));
            let places = site.areas.iter().map(|(area, _)| area.clone());
            robots.push(Robot {
                id: id.clone(),
                client: Client::new(id, &site.name, random.next() | 1),
                places: places
                    .filter(|area| number >= roamers || area != crossing)
                    .collect(),
                at: site.areas[*place].0.clone(),
                wants: None,
                crossing: None,
                until: Instant::now(),
                asked: Instant::now(),
                reported: None,
                moves: 0,
                lost: 0,
            });
        }
        Self {
            publishers,
            _session: session,
            inbox,
            robots,
            random,
            site: site.name.clone(),
            begun: Instant::now(),
            crossing: crossing.to_owned(),
            crossings: 0,
            forgot: 0,
            parks: false,
        }
    }

    pub fn run(&mut self, time: Duration) {
        let until = Instant::now() + time;
        while Instant::now() < until {
            self.step();
        }
    }

    pub fn run_until(&mut self, longest: Duration, done: impl Fn(&Self) -> bool) {
        let until = Instant::now() + longest;
        while !done(self) {
            assert!(Instant::now() < until, "robots wait: {:#?}", self.explain());
            self.step();
        }
    }

    /// A robot's process ends and starts again; its body stays where it is.
    pub fn forget(&mut self, robot: usize) {
        let boot_epoch = self.random.next() | 1;
        let robot = &mut self.robots[robot];
        robot.lost += robot.client.counters().aborted;
        robot.client = Client::new(&robot.id, &self.site, boot_epoch);
        robot.reported = None;
        self.forgot += 1;
    }

    /// Everybody goes to a room and stays there.
    pub fn park(&mut self) {
        self.parks = true;
    }

    pub fn is_parked(&self) -> bool {
        let parked = |robot: &Robot| robot.crossing.is_none() && robot.at != self.crossing;
        self.robots.iter().all(parked)
    }

    pub fn standing(&self) -> BTreeSet<(String, String)> {
        let standing = { self.robots.iter() }.map(|robot| (robot.id.clone(), robot.at.clone()));
        standing.collect()
    }

    pub fn moves(&self) -> u64 {
        self.robots.iter().map(|robot| robot.moves).sum()
    }

    pub fn moves_by_robot(&self) -> Vec<u64> {
        self.robots.iter().map(|robot| robot.moves).collect()
    }

    /// How often a robot was on the crossing.
    pub fn crossings(&self) -> u64 {
        self.crossings
    }

    pub fn forgot(&self) -> u64 {
        self.forgot
    }

    /// Grants that were taken away; nobody has asked for that.
    pub fn lost(&self) -> u64 {
        let lost = |robot: &Robot| robot.lost + robot.client.counters().aborted;
        self.robots.iter().map(lost).sum()
    }

    fn explain(&self) -> Vec<String> {
        let robots = self.robots.iter().map(|robot| {
            let waiting: Vec<_> = robot.client.waiting().collect();
            format!(
                "{} in {} wants {:?}, {} moves, registered {}: {waiting:?}",
                robot.id,
                robot.at,
                robot.wants,
                robot.moves,
                robot.client.is_registered()
            )
        });
        robots.collect()
    }

    fn step(&mut self) {
        let now_ns = |begun: Instant| begun.elapsed().as_nanos() as u64;
        // Waits for answers for at most one step.
        let mut next = self.inbox.recv_timeout(STEP).ok();
        while let Some(message) = next {
            let own = { self.robots.iter_mut() }.find(|robot| robot.id == message.robot_id);
            if let Some(robot) = own {
                if !message.floor.is_empty() {
                    // They have no file of the site: the mediator tells them its floor.
                    let client = robot.client.clone();
                    robot.client = client.on(Floor::said(&message.floor));
                }
                robot.client.receive(&message, now_ns(self.begun));
            }
            next = self.inbox.try_recv().ok();
        }
        for robot in 0..self.robots.len() {
            self.drive(robot);
            let now = Instant::now();
            let robot = &mut self.robots[robot];
            let situation = robot.situation();
            let news = robot.client.step(situation, now_ns(self.begun), SILENT_NS);
            let due = robot.reported.is_none_or(|at| now >= at + REPORT);
            if news || due {
                robot.reported = Some(now);
                let report = robot.client.report().encode_to_vec();
                let sent = self.publishers[&robot.id].put(report).wait();
                sent.expect("the session is open");
            }
        }
    }

    fn drive(&mut self, index: usize) {
        let now = Instant::now();
        let random = &mut self.random;
        let robot = &mut self.robots[index];
        if now < robot.until {
            return;
        }
        if let Some(next) = robot.crossing.take() {
            robot.at = next;
            robot.wants = None;
            robot.moves += 1;
            if robot.at == self.crossing {
                self.crossings += 1;
            }
            robot.until = now + Duration::from_millis(random.below(30));
            return;
        }
        let stays = self.parks && robot.at != self.crossing;
        if stays {
            robot.wants = None;
            return;
        }
        if robot.wants.is_none() || now > robot.asked + PATIENCE {
            let place = random.below(robot.places.len() as u64) as usize;
            let place = robot.places[place].clone();
            let fits = place != robot.at && !(self.parks && place == self.crossing);
            robot.wants = fits.then_some(place);
            robot.asked = now;
        }
        let Some(next) = robot.wants.clone() else {
            return;
        };
        let now_ns = self.begun.elapsed().as_nanos() as u64;
        if robot.client.is_registered()
            && robot.client.may_be_in(&robot.at, now_ns)
            && robot.client.may_be_in(&next, now_ns)
        {
            robot.crossing = Some(next.clone());
            robot.until = now + Duration::from_millis(random.below(20));
            self.judge(index, &next);
        }
    }

    /// Judges by where the bodies are: every area holds one.
    fn judge(&self, entering: usize, area: &String) {
        for (other, robot) in self.robots.iter().enumerate() {
            let there = &robot.at == area || robot.crossing.as_ref() == Some(area);
            assert!(
                other == entering || !there,
                "{} enters {area}, where {} is: {:#?}",
                self.robots[entering].id,
                robot.id,
                self.explain()
            );
        }
    }
}

impl Robot {
    fn situation(&self) -> Situation {
        let mut stands_in = vec![self.at.clone()];
        stands_in.extend(self.crossing.clone());
        let mut wanted = stands_in.clone();
        wanted.extend(self.wants.clone());
        wanted.dedup();
        Situation {
            located: self.client.is_registered(),
            stands_in,
            wanted,
            committed: Vec::new(),
            pose: None,
            fsm_state: format!("in-{}", self.at),
        }
    }
}
