//! Measured without a network: bytes of a report in, bytes of the answers out, on one core.

use std::time::{Duration, Instant};

use contract::timing::ENTERS_NO_MORE_NS;
use contract::wire::{MediatorReport, RobotReport};
use contract::{Message, decode};
use mediator::journal::{Entry, Store, Stored};
use mediator::manager::Manager;

use super::figures::{Times, median, us};
use super::floor::{Robot, SITE, Size};

/// Time of the fleet between two reports: 200,000 reports a second.
const BETWEEN_NS: u64 = 5_000;
/// Time passes for the manager, as in the running mediator.
const TICK_NS: u64 = 20_000_000;

/// The list in memory is emptied after this many entries.
const LOG: usize = 100_000;

/// What a step waits for.
pub enum Journal {
    /// Nothing: entries go into a list.
    Memory(Vec<Entry>),
    /// The disk, with one commit for this many reports, as the running mediator does when they queue up.
    Disk(Box<Store>),
}

impl Journal {
    fn batch(&self) -> usize {
        match self {
            Self::Memory(_) => 1,
            Self::Disk(_) => 256,
        }
    }

    fn write(&mut self, entries: &mut Vec<Entry>) {
        match self {
            Self::Memory(log) => {
                if log.len() > LOG {
                    log.clear();
                }
                log.append(entries);
            }
            Self::Disk(store) => {
                store.write(entries).expect("the disk works");
                entries.clear();
            }
        }
    }
}

/// The mediator's side and the fleet's.
struct Bench {
    manager: Manager,
    journal: Journal,
    robots: Vec<Robot>,
    now_ns: u64,
    next_tick_ns: u64,
    entries: Vec<Entry>,
    /// Encoded answers, one behind the other, and where each begins and whose it is.
    answers: Vec<u8>,
    ends: Vec<(usize, usize)>,
    levels: u64,
    messages: u64,
}

#[derive(Clone, Copy, Default)]
struct Spent {
    cpu: Duration,
    wall: Duration,
}

/// How long this thread has had a core.
fn cpu_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// One window of measurement.
struct Window {
    /// Measured by the processor time of this thread.
    updates_per_s: f64,
    updates_per_s_on_the_clock: f64,
    levels_per_s: f64,
    messages_per_update: f64,
    steps: Times,
}

impl Bench {
    fn new(size: Size, journal: Journal) -> Self {
        let manager = Manager::new(&size.setup(), &Stored::new(1), 0).expect("a new journal");
        Self {
            manager,
            journal,
            robots: size.robots(),
            // Nobody enters any more what a manager before may have granted.
            now_ns: ENTERS_NO_MORE_NS,
            next_tick_ns: 0,
            entries: Vec::new(),
            answers: Vec::new(),
            ends: Vec::new(),
            levels: 0,
            messages: 0,
        }
    }

    /// What is measured: `reports` in, answers out.
    fn step(&mut self, reports: &[Vec<u8>]) {
        for bytes in reports {
            let report: RobotReport = decode(bytes).expect("a report");
            self.levels += report.access.len() as u64;
            self.now_ns += BETWEEN_NS;
            self.manager.report(&report, self.now_ns);
        }
        if self.now_ns >= self.next_tick_ns {
            self.manager.tick(self.now_ns);
            self.next_tick_ns = self.now_ns + TICK_NS;
        }
        self.entries.extend(self.manager.entries());
        self.journal.write(&mut self.entries);
        while let Some(message) = self.manager.next_message(self.now_ns) {
            message
                .encode(&mut self.answers)
                .expect("a vector grows as needed");
            let robot = message.robot_id[4..]
                .parse()
                .expect("as this bench named it");
            self.ends.push((self.answers.len(), robot));
        }
    }

    /// All robots move on, then the mediator takes in what they report. Only the latter is timed.
    fn round(&mut self, times: &mut Vec<u64>) -> (u64, Spent) {
        let mut reports = Vec::new();
        for robot in &mut self.robots {
            if robot.step(self.now_ns) {
                reports.push(robot.client.report().encode_to_vec());
            }
        }
        let cpu = cpu_time();
        let begun = Instant::now();
        let mut last = begun;
        for batch in reports.chunks(self.journal.batch()) {
            self.step(batch);
            let now = Instant::now();
            times.push((now - last).as_nanos() as u64);
            last = now;
        }
        let spent = Spent {
            cpu: cpu_time() - cpu,
            wall: last - begun,
        };
        self.messages += self.ends.len() as u64;
        let mut begin = 0;
        for (end, robot) in self.ends.drain(..) {
            let message: MediatorReport = decode(&self.answers[begin..end]).expect("a message");
            self.robots[robot].client.receive(&message, self.now_ns);
            begin = end;
        }
        self.answers.clear();
        if let Some(alarm) = self.manager.alarms().next() {
            panic!("nothing goes wrong here, but: {alarm}");
        }
        (reports.len() as u64, spent)
    }

    fn window(&mut self, updates: u64, longest: Duration) -> Window {
        let (mut done, mut spent) = (0, Spent::default());
        let mut times = Vec::new();
        (self.levels, self.messages) = (0, 0);
        while done < updates && spent.wall < longest {
            let (reports, time) = self.round(&mut times);
            done += reports;
            spent.cpu += time.cpu;
            spent.wall += time.wall;
        }
        let per_s = |count: u64| count as f64 / spent.cpu.as_secs_f64();
        Window {
            updates_per_s: per_s(done),
            updates_per_s_on_the_clock: done as f64 / spent.wall.as_secs_f64(),
            levels_per_s: per_s(self.levels),
            messages_per_update: self.messages as f64 / done as f64,
            steps: Times::new(times),
        }
    }

    fn moves(&self) -> u64 {
        self.robots.iter().map(|robot| robot.moves).sum()
    }
}

/// Measures some windows behind each other and prints one line.
fn measure(name: &str, size: Size, disk: Option<Store>, windows: usize, updates: u64) {
    let mut bench = Bench::new(size, Journal::Memory(Vec::new()));
    // Everybody has registered and been round once.
    let mut rounds = 0;
    while bench.moves() < (size.robots * size.round_trip) as u64 {
        bench.round(&mut Vec::new());
        rounds += 1;
        assert!(rounds < 100 * size.round_trip, "the fleet stands still");
    }
    if let Some(store) = disk {
        if let Journal::Memory(log) = &bench.journal {
            store.write(log).expect("the disk works");
        }
        bench.journal = Journal::Disk(Box::new(store));
    }
    let before = bench.moves();
    let longest = Duration::from_secs(2);
    let windows: Vec<Window> = (0..windows)
        .map(|_| bench.window(updates, longest))
        .collect();
    assert!(bench.moves() > before, "nobody moved");
    let of = |figure: fn(&Window) -> f64| median(windows.iter().map(figure).collect());
    let p99 = |window: &Window| window.steps.per_mille(990).as_secs_f64() * 1e6;
    let steps: usize = windows.iter().map(|window| window.steps.count()).sum();
    let worst = windows.iter().map(p99).fold(0.0, f64::max);
    let longest = windows.iter().map(|window| window.steps.max()).max();
    println!(
        "{name:<44} {:>10.0} {:>9.0} {:>10.0} {:>8.2} {:>6} {:>8} {:>9.1} us {:>9.1} us {:>9.1} us {:>12}",
        of(|window| window.updates_per_s),
        of(|window| window.updates_per_s_on_the_clock),
        of(|window| window.levels_per_s),
        of(|window| window.messages_per_update),
        bench.journal.batch(),
        steps,
        of(|window| window.steps.per_mille(500).as_secs_f64() * 1e6),
        median(windows.iter().map(p99).collect()),
        worst,
        us(longest.unwrap_or_default()),
    );
}

pub fn run() {
    println!(
        "\nwithout network, one core: bytes of a report in, bytes of the answers out (medians of windows)\n{:<44} {:>10} {:>9} {:>10} {:>8} {:>6} {:>8} {:>12} {:>12} {:>12} {:>12}",
        "1,000 moving robots, 200 areas",
        "reports/s",
        "by clock",
        "levels/s",
        "answers",
        "batch",
        "steps",
        "step median",
        "step p99",
        "worst p99",
        "longest"
    );
    let size = Size {
        robots: 1000,
        areas: 200,
        round_trip: 10,
    };
    let everywhere = Size {
        round_trip: 50,
        ..size
    };
    let name = "journal in memory, round trips of 10 areas";
    measure(name, size, None, 11, 100_000);
    let name = "journal in memory, round trips of 50 areas";
    measure(name, everywhere, None, 5, 20_000);
    let folder = tempfile::tempdir().expect("a folder");
    let journal = folder.path().join("journal.redb");
    let (store, _) = Store::open(&journal, SITE).expect("a new journal");
    let name = "journal on disk, round trips of 10 areas";
    measure(name, size, Some(store), 7, 20_000);
}
