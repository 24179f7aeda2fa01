//! How soon the real program answers when there is nothing in its way.
//!
//! Two robots without wheels on the areas of the corridor: the emergency robot goes round, and each time the shipped net
//! lets it overtake the normal one, which stays in area 1. So every lap has requests of free areas, and all flags and
//! commands of that net.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use contract::client::{Client, Situation};
use contract::wire::{Access, Control, Level, MediatorReport};

use super::figures::{Times, ms};
use super::floor::hear;
use super::program::{OVERTAKING, Program, Site, session};
use super::wire::Wire;

const LAPS: u64 = 300;
const LONGEST: Duration = Duration::from_secs(40);
const SILENT_NS: u64 = 1_000_000_000;
const REPORT: Duration = Duration::from_millis(200);
const AREAS: [&str; 7] = ["1", "2", "3", "4", "5", "6", "7"];
const ROUND: [&str; 6] = ["7", "1", "2", "3", "4", "6"];

/// A robot, and a flag of its protocol.
type Flag = (&'static str, &'static str);

/// Each command of the net, and the flags that it waits for.
const COMMANDS: [(&str, &str, &[Flag]); 7] = [
    ("fast", "slow", &[("fast", "acquired")]),
    ("slow", "e5", &[("slow", "acquired")]),
    ("fast", "e1", &[("fast", "slowed"), ("slow", "done5")]),
    ("fast", "e2", &[("fast", "done1")]),
    ("fast", "release", &[("fast", "done2")]),
    ("slow", "e1", &[("fast", "done2")]),
    ("slow", "release", &[("slow", "done1")]),
];

fn site() -> Site {
    Site {
        name: "round".into(),
        areas: AREAS.map(|area| (area.to_owned(), 1)).into(),
        robots: vec![
            ("fast".into(), "emergency", 6),
            ("slow".into(), "normal", 0),
        ],
        events: vec![
            ("go-1", "in-1"),
            ("go-2", "in-2"),
            ("aside", "parked"),
            ("back", "back-in-1"),
            ("resume", "resumed"),
        ],
        more: OVERTAKING.into(),
        nets: vec!["overtaking"],
        own_nets: Vec::new(),
    }
}

/// What each order is about: its event, where it leads, and what the state machine outputs there.
const ORDERS: [(&str, &str, &str); 4] = [
    ("go-1", "1", "in-1"),
    ("go-2", "2", "in-2"),
    ("aside", "5", "parked"),
    ("back", "1", "back-in-1"),
];

struct Robot {
    client: Client,
    at: &'static str,
    /// By an order, or by itself.
    to: Option<&'static str>,
    output: &'static str,
    laps: u64,
    reported: Option<Instant>,
    /// What flags mean, as the last message said.
    control: Option<Control>,
}

/// The names of the flags that a level says are set.
fn flags(meaning: &Control, level: Option<&Level>) -> Vec<String> {
    let Some(level) = level else {
        return Vec::new();
    };
    let all: Vec<u32> = (0..meaning.flags.len() as u32).collect();
    let path = meaning.paths.get(level.path as usize);
    let path = path.map_or(&all, |path| &path.flags);
    let set = path.iter().take(level.progress as usize);
    set.map(|&flag| meaning.flags[flag as usize].name.clone())
        .collect()
}

impl Robot {
    fn new(id: &str, at: &'static str, boot_epoch: u64) -> Self {
        Self {
            client: Client::new(id, "round", boot_epoch),
            at,
            to: None,
            output: "",
            laps: 0,
            reported: None,
            control: None,
        }
    }

    /// Follows orders, or its round; the body takes no time.
    fn step(&mut self, goes_round: bool, now_ns: u64) -> bool {
        let mut news = false;
        while let Some(order) = self.client.next_order() {
            let event = order.instruction.event.unwrap_or_default();
            if let Some((_, to, output)) = ORDERS.iter().find(|own| own.0 == event) {
                (self.to, self.output) = (Some(*to), *output);
            }
        }
        if self.to.is_none() && goes_round && !self.client.is_acquired() {
            let place = ROUND.iter().position(|area| *area == self.at);
            self.to = place.map(|place| ROUND[(place + 1) % ROUND.len()]);
        }
        if let Some(to) = self.to
            && self.client.is_registered()
            && self.client.holds(to)
            && self.client.holds(self.at)
        {
            self.laps += u64::from(to == "7");
            (self.at, self.to) = (to, None);
            // It must be seen to be there before its machine says so.
            news |= self.client.step(self.situation(), now_ns, SILENT_NS);
            news |= self.client.output(std::mem::take(&mut self.output));
        }
        news | self.client.step(self.situation(), now_ns, SILENT_NS)
    }

    fn situation(&self) -> Situation {
        let wanted = [Some(self.at), self.to].into_iter().flatten();
        Situation {
            located: self.client.is_registered(),
            stands_in: vec![self.at.to_owned()],
            wanted: wanted.map(str::to_owned).collect(),
            committed: Vec::new(),
            pose: None,
            fsm_state: format!("in-{}", self.at),
        }
    }
}

#[derive(Default)]
struct Clocks {
    /// By robot and area: when the present request was sent.
    asked: BTreeMap<(String, String), (Level, Instant)>,
    /// By robot and flag: when it was set in the present coordination.
    set: BTreeMap<(String, String), (u64, Instant)>,
    /// By robot and flag: in which coordination the command came.
    told: BTreeMap<(String, String), u64>,
    grants: Vec<u64>,
    commands: Vec<u64>,
}

impl Clocks {
    /// Just before a report is sent.
    fn send(&mut self, id: &str, robot: &Robot, access: &[Access], control: Option<&Control>) {
        let now = Instant::now();
        for own in access {
            let Some(level) = own.level.filter(|level| level.progress == 1) else {
                continue;
            };
            // Area 1 is not free: somebody stands there.
            if own.area == "1" || own.area == "5" {
                continue;
            }
            let place = (id.to_owned(), own.area.clone());
            let known = self.asked.get(&place).is_some_and(|asked| asked.0 == level);
            if !known {
                self.asked.insert(place, (level, now));
            }
        }
        if let (Some(own), Some(meaning)) = (control, &robot.control)
            && own.coordination == meaning.coordination
        {
            for flag in flags(meaning, own.level.as_ref()) {
                let set = self.set.entry((id.to_owned(), flag)).or_insert((0, now));
                if set.0 != own.coordination {
                    *set = (own.coordination, now);
                }
            }
        }
    }

    fn receive(&mut self, at: Instant, message: &MediatorReport) {
        let id = &message.robot_id;
        for grant in &message.access {
            let place = (id.clone(), grant.area.clone());
            if let Some((level, asked)) = self.asked.get(&place)
                && let Some(now) = grant.level
                && now.run == level.run
                && now.progress >= 2
            {
                self.grants.push((at - *asked).as_nanos() as u64);
                self.asked.remove(&place);
            }
        }
        let Some(control) = &message.control else {
            return;
        };
        let number = control.coordination;
        for flag in flags(control, control.level.as_ref()) {
            let Some((_, _, enablers)) = COMMANDS.iter().find(|own| own.0 == id && own.1 == flag)
            else {
                continue;
            };
            if self.told.insert((id.clone(), flag), number) == Some(number) {
                continue;
            }
            let set = enablers.iter().map(|(robot, flag)| {
                let set = self.set.get(&((*robot).to_owned(), (*flag).to_owned()));
                set.filter(|set| set.0 == number).map(|set| set.1)
            });
            if let Some(set) = set.collect::<Option<Vec<Instant>>>()
                && let Some(last) = set.into_iter().max()
            {
                self.commands.push((at - last).as_nanos() as u64);
            }
        }
    }
}

pub fn run() {
    let folder = tempfile::tempdir().expect("a folder");
    let (session, endpoint) = session(&[]);
    let mut program = Program::new(folder.path(), &site(), vec![endpoint]);
    program.start();
    program.wait_ready(Duration::from_secs(20));
    let wire = Wire::new(session, ["fast", "slow"].map(str::to_owned).into_iter());
    let mut robots = [Robot::new("fast", "7", 11), Robot::new("slow", "1", 12)];
    let mut clocks = Clocks::default();
    let begun = Instant::now();
    while robots[0].laps < LAPS && begun.elapsed() < LONGEST {
        if let Some((at, message)) = wire.receive(Duration::from_millis(1)) {
            clocks.receive(at, &message);
            let robot = &mut robots[usize::from(message.robot_id == "slow")];
            robot.control.clone_from(&message.control);
            let now_ns = (at - begun).as_nanos() as u64;
            hear(&mut robot.client, &message, now_ns);
        }
        for (robot, id) in robots.iter_mut().zip(["fast", "slow"]) {
            let news = robot.step(id == "fast", begun.elapsed().as_nanos() as u64);
            let late = robot.reported.is_none_or(|at| at.elapsed() >= REPORT);
            if news || late {
                robot.reported = Some(Instant::now());
                let report = robot.client.report();
                clocks.send(id, robot, &report.access, report.control.as_ref());
                wire.send(&report);
            }
        }
    }
    let took = begun.elapsed().as_secs_f64();
    let laps = robots[0].laps;
    println!(
        "\nover zenoh on the loopback, program of its own, journal on disk: 2 robots, {laps} times overtaking in {took:.1} s"
    );
    for (name, times) in [
        ("request -> grant of a free area", clocks.grants),
        ("robot's flag -> command of the net", clocks.commands),
    ] {
        let times = Times::new(times);
        println!(
            "{name:<36} median {}, p99 {}, max {} ({} times)",
            ms(times.per_mille(500)),
            ms(times.per_mille(990)),
            ms(times.max()),
            times.count()
        );
    }
    assert!(
        laps > 0,
        "nobody overtook: {:#?} {}",
        program.status(),
        program.log()
    );
}
