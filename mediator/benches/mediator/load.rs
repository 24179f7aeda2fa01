//! A thousand robots talk to the real program over zenoh on the loopback, ten thousand times a second.

use std::time::{Duration, Instant};

use contract::wire::MediatorReport;

use super::figures::{Times, ms};
use super::floor::{Robot, SITE, Size, hear};
use super::program::{Program, Site, session};
use super::wire::Wire;

const OFFERED_PER_S: f64 = 10_000.0;
const WARM_UP: Duration = Duration::from_secs(4);
const MEASURED: Duration = Duration::from_secs(10);
/// So many robots are looked at for something to say before messages are taken in again.
const LOOKS: usize = 50;
/// A robot that got no answer for this time goes on.
const PATIENCE: Duration = Duration::from_secs(1);

/// What a robot waits for an answer to.
struct Open {
    at: Instant,
    /// Of the report.
    sequence: u64,
}

fn site(size: Size) -> Site {
    let setup = size.setup();
    let place = |id: &str| setup.areas.iter().position(|area| area.id == id);
    let robots = setup.robots.iter().map(|robot| {
        let place = place(&robot.starts_in[0]).expect("it has it");
        (robot.id.clone(), "normal", place)
    });
    Site {
        name: SITE.into(),
        areas: setup
            .areas
            .iter()
            .map(|area| (area.id.clone(), area.capacity))
            .collect(),
        robots: robots.collect(),
        events: Vec::new(),
        more: String::new(),
        nets: Vec::new(),
        own_nets: Vec::new(),
    }
}

struct Load {
    wire: Wire,
    robots: Vec<Robot>,
    open: Vec<Option<Open>>,
    begun: Instant,
    cursor: usize,
    sent: u64,
    unanswered: u64,
    times: Vec<u64>,
}

impl Load {
    /// Offers updates as fast as `OFFERED_PER_S` asks; each from a robot that has news and no open question.
    fn run(&mut self, time: Duration) {
        let begun = Instant::now();
        let mut offered = 0.0;
        while begun.elapsed() < time {
            let mut patience = Duration::from_micros(200);
            while let Some((at, message)) = self.wire.receive(patience) {
                self.take_in(at, &message);
                // What has come by now, all of it: robots that hear late ask late.
                patience = Duration::ZERO;
            }
            let due = begun.elapsed().as_secs_f64() * OFFERED_PER_S;
            // An update that could not be offered in time is left out.
            offered = f64::max(offered, due - 100.0);
            for _ in 0..LOOKS {
                if offered >= due {
                    break;
                }
                offered += f64::from(u8::from(self.offer()));
            }
        }
    }

    fn take_in(&mut self, at: Instant, message: &MediatorReport) {
        let robot: usize = message.robot_id[4..]
            .parse()
            .expect("as this bench named it");
        let now_ns = (at - self.begun).as_nanos() as u64;
        hear(&mut self.robots[robot].client, message, now_ns);
        if let Some(open) = self.open[robot].take_if(|open| message.robot_sequence >= open.sequence)
        {
            self.times.push((at - open.at).as_nanos() as u64);
        }
    }

    /// The next robot moves on and reports if there is something to say.
    fn offer(&mut self) -> bool {
        self.cursor = (self.cursor + 1) % self.robots.len();
        let now = Instant::now();
        let open = &mut self.open[self.cursor];
        match open {
            Some(own) if now < own.at + PATIENCE => return false,
            Some(_) => self.unanswered += 1,
            None => {}
        }
        *open = None;
        let robot = &mut self.robots[self.cursor];
        let now_ns = (now - self.begun).as_nanos() as u64;
        if !robot.step(now_ns) {
            return false;
        }
        let report = robot.client.report();
        // A repeated report is answered only with the mediator's next repetition, which measures nothing.
        if robot.has_news && robot.client.is_registered() {
            let (at, sequence) = (Instant::now(), report.sequence);
            *open = Some(Open { at, sequence });
        }
        self.wire.send(&report);
        self.sent += 1;
        true
    }
}

pub fn run() {
    let size = Size {
        robots: 1000,
        areas: 200,
        round_trip: 10,
    };
    let folder = tempfile::tempdir().expect("a folder");
    let (session, endpoint) = session(&[]);
    let mut program = Program::new(folder.path(), &site(size), vec![endpoint]);
    program.start();
    program.wait_ready(Duration::from_secs(20));
    let ids = (0..size.robots).map(|robot| size.robot_id(robot));
    let mut load = Load {
        wire: Wire::new(session, ids),
        robots: size.robots(),
        open: (0..size.robots).map(|_| None).collect(),
        begun: Instant::now(),
        cursor: 0,
        sent: 0,
        unanswered: 0,
        times: Vec::new(),
    };
    load.run(WARM_UP);
    load.times.clear();
    (load.sent, load.unanswered) = (0, 0);
    let moves = |load: &Load| load.robots.iter().map(|robot| robot.moves).sum::<u64>();
    let (before, cpu) = (moves(&load), program.cpu_time());
    let begun = Instant::now();
    load.run(MEASURED);
    let took = begun.elapsed().as_secs_f64();
    let cpu = (program.cpu_time() - cpu).as_secs_f64() / took;
    let moved = moves(&load) - before;
    let times = Times::new(load.times);
    println!(
        "\nover zenoh on the loopback, program of its own, journal on disk: 1,000 moving robots, 200 areas, {took:.1} s\n\
         offered {:.0} reports/s, answered {:.0}/s, unanswered within 1 s: {}; {:.0} moves/s\n\
         report -> answer: median {}, p99 {}, max {} ({} answers); mediator took {:.0} % of a core",
        load.sent as f64 / took,
        times.count() as f64 / took,
        load.unanswered,
        moved as f64 / took,
        ms(times.per_mille(500)),
        ms(times.per_mille(990)),
        ms(times.max()),
        times.count(),
        cpu * 100.0
    );
    assert!(moved > 0, "nobody moved: {}", program.log());
}
