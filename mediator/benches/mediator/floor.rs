//! A large floor with robots that are always on the move, each with the contract's own client.

use std::time::Duration;

use contract::client::{Client, Situation};
use contract::floor::Floor;
use contract::wire::{MediatorReport, Pose};
use mediator::setup::{AreaSetup, RobotSetup, Setup};

pub const SITE: &str = "hall";
/// A robot that has nothing to say repeats itself this often.
const REPORT_NS: u64 = 200_000_000;
const SILENT_AFTER: Duration = Duration::from_secs(1);

/// A robot hears the mediator. One that has no file of the site learns its floor from it.
pub fn hear(client: &mut Client, message: &MediatorReport, now_ns: u64) {
    if !message.floor.is_empty() && !client.is_registered() {
        *client = client.clone().on(Floor::said(&message.floor));
    }
    client.receive(message, now_ns);
}

/// How large.
#[derive(Clone, Copy)]
pub struct Size {
    pub robots: usize,
    pub areas: usize,
    /// Areas on one robot's round trip; it has a level for each of them.
    pub round_trip: usize,
}

impl Size {
    /// One and a half places per robot, so that some wait and all get on.
    fn capacity(self) -> u32 {
        let capacity = (self.robots * 3).div_ceil(self.areas * 2).max(1);
        u32::try_from(capacity).expect("a small number")
    }

    pub fn robot_id(self, robot: usize) -> String {
        format!("amr-{robot:04}")
    }

    fn area_id(area: usize) -> String {
        format!("hall-{area:03}")
    }

    /// Rings of areas, side by side; robots are spread evenly.
    pub fn route(self, robot: usize) -> Vec<String> {
        let rings = self.areas / self.round_trip;
        let (ring, place) = (robot % rings, robot / rings % self.round_trip);
        let areas = (0..self.round_trip).map(|leg| (place + leg) % self.round_trip);
        areas
            .map(|area| Self::area_id(ring * self.round_trip + area))
            .collect()
    }

    pub fn setup(self) -> Setup {
        let areas = (0..self.areas).map(|area| AreaSetup {
            id: Self::area_id(area),
            capacity: self.capacity(),
        });
        let robots = (0..self.robots).map(|robot| RobotSetup {
            id: self.robot_id(robot),
            role: "normal".into(),
            priority: u32::from(robot % 10 == 0),
            ages_after: 0,
            starts_in: vec![self.route(robot)[0].clone()],
        });
        Setup {
            site: SITE.into(),
            areas: areas.collect(),
            robots: robots.collect(),
            floor: Floor::default(),
            silent_after: SILENT_AFTER,
        }
    }

    pub fn robots(self) -> Vec<Robot> {
        let robot = |robot: usize| Robot::new(&self.robot_id(robot), self.route(robot));
        (0..self.robots).map(robot).collect()
    }
}

/// A robot that asks for the next area of its round trip, enters, leaves the one behind it, and asks again.
pub struct Robot {
    pub client: Client,
    route: Vec<String>,
    leg: usize,
    /// It reaches over the border to the next area.
    crossing: bool,
    reported_ns: u64,
    /// The last step has changed what the robot says; otherwise it only repeats itself.
    pub has_news: bool,
    pub moves: u64,
}

impl Robot {
    fn new(id: &str, route: Vec<String>) -> Self {
        let boot_epoch = 1 + id.bytes().map(u64::from).sum::<u64>();
        Self {
            client: Client::new(id, SITE, boot_epoch),
            route,
            leg: 0,
            crossing: false,
            reported_ns: 0,
            has_news: false,
            moves: 0,
        }
    }

    fn area(&self, ahead: usize) -> &String {
        &self.route[(self.leg + ahead) % self.route.len()]
    }

    /// Drives as far as the grants allow. Returns whether a report is due: there is news, or the last report is too old.
    pub fn step(&mut self, now_ns: u64) -> bool {
        if self.crossing {
            self.crossing = false;
            self.leg = (self.leg + 1) % self.route.len();
            self.moves += 1;
        } else if self.client.holds(self.area(0)) && self.client.holds(self.area(1)) {
            self.crossing = true;
        }
        let mut stands_in = vec![self.area(0).clone()];
        let mut wanted = stands_in.clone();
        if self.crossing {
            stands_in.push(self.area(1).clone());
            wanted.push(self.area(1).clone());
        } else if self.client.holds(self.area(0)) {
            wanted.push(self.area(1).clone());
        }
        let situation = Situation {
            located: self.client.is_registered(),
            stands_in,
            wanted,
            committed: Vec::new(),
            pose: Some(Pose {
                x_m: self.moves as f64,
                y_m: 0.5,
                theta_rad: 0.1,
                std_x_m: 0.01,
                std_y_m: 0.01,
                std_theta_rad: 0.01,
            }),
            fsm_state: if self.crossing { "turning" } else { "driving" }.to_owned(),
        };
        let silent_ns = SILENT_AFTER.as_nanos() as u64;
        self.has_news = self.client.step(situation, now_ns, silent_ns);
        let due = self.has_news || now_ns >= self.reported_ns + REPORT_NS || self.reported_ns == 0;
        if due {
            self.reported_ns = now_ns.max(1);
        }
        due
    }
}
