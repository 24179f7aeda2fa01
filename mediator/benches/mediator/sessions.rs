//! Robots on a session each talk to the real program, over zenoh on the loopback: five times a second, and on news.
//!
//! The floor has places, each a crossing and three rooms around it. Nets let one robot at a time over each crossing, whichever
//! come; as many other nets would take in any robot, and wait for a situation that does not come. A robot that has crossed asks for a room in which there is always room: those requests are measured.

use std::collections::BTreeSet;
use std::net::TcpListener;
use std::path::Path;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use contract::client::{Client, Situation};
use contract::network::{Access, NetworkSettings, Party, Security};
use contract::wire::MediatorReport;
use contract::{Message, decode, keys};
use mediator::keys::Keys;
use zenoh::Wait;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;

use super::figures::{Times, ms};
use super::floor::hear;
use super::program::site::{idle_coordination, idle_net, shipped_net};
use super::program::{Program, Site};
use super::random::Random;

/// A request of a free area is granted within this time, but for one in a hundred.
const MOST_P99: Duration = Duration::from_millis(10);
/// A report costs no more among ten times as many robots. They share wake-ups, so that it costs less.
const MOST_GROWN: f64 = 1.2;
/// What is measured must not grow; allocators keep some.
const MOST_GROWTH_MIB: f64 = 16.0;
const PREFIX: &str = "fleet";
const PLACES: usize = 50;
const ROOMS: usize = 3;
const SILENT_NS: u64 = 1_000_000_000;
const REPORT: Duration = Duration::from_millis(200);
/// How long a robot drives over a crossing: at least, and by up to how much longer. No two places keep step.
const CROSSES_MS: u64 = 200;
const LONGER_MS: u64 = 200;
/// Robots whose time has come are looked for so often.
const LOOKS: Duration = Duration::from_millis(1);
/// So many sessions are opened at once, so that the machine that plays a thousand robots is not the measure.
const OPENED_AT_ONCE: usize = 50;
const WARM_UP: Duration = Duration::from_secs(20);
const MEASURED: Duration = Duration::from_secs(30);
const NET: &str = "t-junction";

fn site(robots: usize) -> Site {
    let each = u32::try_from(robots / PLACES).expect("a small number");
    let mut areas = Vec::new();
    let (mut more, mut own_nets) = (String::new(), Vec::new());
    for place in 0..PLACES {
        areas.push((format!("Cr-{place}"), 1));
        areas.extend((0..ROOMS).map(|room| (format!("room-{place}-{room}"), each)));
        let net = format!("crossing-{place}");
        let text = shipped_net(NET)
            .replace("[\"Cr\"]", &format!("[\"Cr-{place}\"]"))
            .replace(&format!("name = \"{NET}\""), &format!("name = \"{net}\""));
        own_nets.push((net.clone(), text));
        let role = "{ role = \"normal\" }";
        let idle = format!("idle-{place}");
        more += &idle_coordination(
            &idle,
            &format!("room-{place}-0"),
            &format!("Cr-{}", (place + 1) % PLACES),
        );
        own_nets.push(idle_net(&idle));
        more += &format!(
            "[coordinations.{net}]\nnet = \"{net}\"\nsituations.all-outside = {{ west = {role}, east = {role}, south = {role} }}\n"
        );
    }
    let starts = |robot: usize| robot % PLACES * (ROOMS + 1) + 1;
    Site {
        name: "rooms".into(),
        areas,
        robots: (0..robots)
            .map(|robot| (format!("amr-{robot:04}"), "normal", starts(robot)))
            .collect(),
        events: Vec::new(),
        more,
        nets: Vec::new(),
        own_nets,
    }
}

struct Robot {
    client: Client,
    publisher: Publisher<'static>,
    _session: zenoh::Session,
    room: usize,
    /// Since when it is on the crossing, and for how long it will be.
    crosses: Option<(Instant, Duration)>,
    random: Random,
    /// Its crossing, and the rooms around it.
    crossing: String,
    rooms: [String; ROOMS],
    /// When it is to be looked at, though it hears nothing.
    next: Instant,
    /// When it reports, though there is no news.
    due: Instant,
    asked: Option<Instant>,
    sent: u64,
    moves: u64,
}

impl Robot {
    fn open(
        number: usize,
        id: &str,
        settings: &NetworkSettings,
        news: Sender<(usize, Instant, MediatorReport)>,
    ) -> Self {
        let session = settings.open().expect("a session");
        session
            .declare_subscriber(keys::to_robot(PREFIX, id).expect("a plain name"))
            .callback(move |sample| {
                let at = Instant::now();
                let message = decode(&sample.payload().to_bytes()).expect("a message");
                // After the end nobody listens.
                let _ = news.send((number, at, message));
            })
            .background()
            .wait()
            .expect("it subscribes");
        let publisher = session.declare_publisher(keys::report(PREFIX, id).expect("a plain name"));
        let publisher = publisher
            .congestion_control(CongestionControl::Drop)
            .express(true)
            .wait();
        Self {
            client: Client::new(id, "rooms", 1 + number as u64),
            publisher: publisher.expect("it publishes"),
            _session: session,
            room: 0,
            crosses: None,
            random: Random::new(number as u64),
            crossing: format!("Cr-{}", number % PLACES),
            rooms: std::array::from_fn(|room| format!("room-{}-{room}", number % PLACES)),
            next: Instant::now(),
            due: Instant::now(),
            asked: None,
            sent: 0,
            moves: 0,
        }
    }

    fn name_of(&self, room: usize) -> String {
        self.rooms[room % ROOMS].clone()
    }

    /// Drives as far as grants allow, and reports when that is due.
    fn step(&mut self, now: Instant, now_ns: u64) {
        let (here, there) = (self.name_of(self.room), self.name_of(self.room + 1));
        let crossing = self.crossing.clone();
        match self.crosses {
            None if self.client.holds(&crossing) && self.client.holds(&here) => {
                let takes_ms = CROSSES_MS + self.random.below(LONGER_MS);
                self.crosses = Some((now, Duration::from_millis(takes_ms)));
            }
            Some((since, takes)) if now >= since + takes && self.client.holds(&there) => {
                self.crosses = None;
                self.room = (self.room + 1) % ROOMS;
                self.moves += 1;
            }
            _ => {}
        }
        let here = self.name_of(self.room);
        let (stands_in, wanted) = match self.crosses {
            // Half way it has left the room behind it, and asks for the one ahead.
            Some((since, takes)) if now >= since + takes / 2 => {
                (vec![crossing.clone()], vec![crossing, there.clone()])
            }
            Some(_) => (vec![here.clone(), crossing.clone()], vec![here, crossing]),
            None => (vec![here.clone()], vec![here, crossing]),
        };
        let asks = wanted.contains(&there) && self.crosses.is_some();
        let situation = Situation {
            located: self.client.is_registered(),
            stands_in,
            wanted,
            ..Situation::default()
        };
        let news = self.client.step(situation, now_ns, SILENT_NS);
        let due = now >= self.due;
        if !news && !due {
            self.wait(now);
            return;
        }
        if asks && news && self.asked.is_none() && !self.client.holds(&there) {
            self.asked = Some(Instant::now());
        }
        // News does not put it off: or else robots that heard something at the same time would report together ever after.
        while self.due <= now {
            self.due += REPORT;
        }
        self.wait(now);
        self.sent += 1;
        let report = self.client.report().encode_to_vec();
        self.publisher
            .put(report)
            .wait()
            .expect("the session is open");
    }

    /// Until the next report is due, or it is half way or all the way over the crossing.
    fn wait(&mut self, now: Instant) {
        let ways = { self.crosses.iter() }
            .flat_map(|&(since, takes)| [since + takes / 2, since + takes])
            .filter(|at| *at > now);
        self.next = ways.fold(self.due, Instant::min);
    }

    /// Returns how long the room that it has asked for took.
    fn hear(&mut self, message: &MediatorReport, at: Instant, now_ns: u64) -> Option<u64> {
        hear(&mut self.client, message, now_ns);
        let asked = self.asked?;
        if self.client.holds(&self.name_of(self.room + 1)) {
            self.asked = None;
            return Some(at.saturating_duration_since(asked).as_nanos() as u64);
        }
        None
    }
}

struct Floor {
    robots: Vec<Robot>,
    inbox: Receiver<(usize, Instant, MediatorReport)>,
    begun: Instant,
    heard: u64,
    bytes: u64,
}

impl Floor {
    fn run(&mut self, time: Duration) -> Vec<u64> {
        let until = Instant::now() + time;
        let mut times = Vec::new();
        let mut looked = Instant::now();
        while Instant::now() < until {
            let mut heard = BTreeSet::new();
            let mut patience = LOOKS;
            while let Ok((number, at, message)) = self.inbox.recv_timeout(patience) {
                patience = Duration::ZERO;
                self.heard += 1;
                self.bytes += message.encoded_len() as u64;
                let now_ns = self.begun.elapsed().as_nanos() as u64;
                times.extend(self.robots[number].hear(&message, at, now_ns));
                heard.insert(number);
                if heard.len() >= 100 {
                    break;
                }
            }
            let now = Instant::now();
            let now_ns = self.begun.elapsed().as_nanos() as u64;
            for number in heard {
                self.robots[number].step(now, now_ns);
            }
            if now >= looked + LOOKS {
                looked = now;
                for robot in self.robots.iter_mut().filter(|own| own.next <= now) {
                    robot.step(now, now_ns);
                }
            }
        }
        times
    }

    fn sent(&self) -> u64 {
        self.robots.iter().map(|robot| robot.sent).sum()
    }

    fn moves(&self) -> u64 {
        self.robots.iter().map(|robot| robot.moves).sum()
    }
}

/// How each robot takes part: with a certificate of its own, or without.
fn settings(
    site: &Site,
    folder: &Path,
    program: &mut Program,
    secure: bool,
) -> Vec<NetworkSettings> {
    let port = TcpListener::bind("127.0.0.1:0").and_then(|socket| socket.local_addr());
    let port = port.expect("a free port").port();
    let protocol = if secure { "tls" } else { "tcp" };
    let endpoint = format!("{protocol}/127.0.0.1:{port}");
    program.listen(&endpoint);
    let keys = secure.then(|| {
        let keys = Keys::new(folder.join("keys"));
        keys.begin("rooms", 30.0).expect("an authority");
        program.add(&["--keys", &keys.folder().display().to_string()]);
        keys
    });
    let security = |id: &str| {
        let party = Party::Robot(id.to_owned());
        keys.as_ref().map(|keys| Security {
            identity: keys.issue(party).expect("it is made"),
            access: Access::MediatorOnly,
        })
    };
    { site.robots.iter() }
        .map(|(id, ..)| NetworkSettings {
            connect: vec![endpoint.clone()],
            security: security(id),
            ..NetworkSettings::default()
        })
        .collect()
}

/// Returns the processor time that the mediator takes for a report, seconds.
fn measure(count: usize, secure: bool) -> f64 {
    let folder = tempfile::tempdir().expect("a folder");
    let site = site(count);
    let mut program = Program::new(folder.path(), &site, Vec::new());
    let settings = settings(&site, folder.path(), &mut program, secure);
    program.start();
    program.wait_ready(Duration::from_secs(60));
    let (news, inbox) = channel();
    let mut robots = Vec::new();
    let ids: Vec<(usize, &str)> = { site.robots.iter().enumerate() }
        .map(|(number, (id, _, _))| (number, id.as_str()))
        .collect();
    for some in ids.chunks(OPENED_AT_ONCE) {
        let opened = std::thread::scope(|scope| {
            let all: Vec<_> = { some.iter() }
                .map(|&(number, id)| {
                    let (news, settings) = (news.clone(), &settings[number]);
                    scope.spawn(move || Robot::open(number, id, settings, news))
                })
                .collect();
            all.into_iter()
                .map(|own| own.join().expect("opened"))
                .collect::<Vec<_>>()
        });
        robots.extend(opened);
    }
    // Not all at once: that would be a burst, five times a second.
    let now = Instant::now();
    for (number, robot) in robots.iter_mut().enumerate() {
        robot.due = now + REPORT * number as u32 / count as u32;
        robot.next = robot.due;
    }
    let mut floor = Floor {
        robots,
        inbox,
        begun: Instant::now(),
        heard: 0,
        bytes: 0,
    };
    floor.run(WARM_UP);
    (floor.heard, floor.bytes) = (0, 0);
    floor.robots.iter_mut().for_each(|robot| robot.sent = 0);
    let (moves, cpu, rss_mib) = (floor.moves(), program.cpu_time(), program.rss_mib());
    let begun = Instant::now();
    let times = Times::new(floor.run(MEASURED));
    let took_s = begun.elapsed().as_secs_f64();
    let status = program.wait_ready(Duration::from_secs(5));
    let reports = floor.sent();
    let cpu_s = (program.cpu_time() - cpu).as_secs_f64();
    let report_s = cpu_s / reports.max(1) as f64;
    let nets = status.coordinations.iter().filter(|own| !own.over).count();
    println!(
        "\n{count} robots on {count} sessions{}, {} areas, {nets} nets run, {took_s:.1} s: {:.0} reports/s, {:.0} messages/s, {:.0} moves/s\n\
         request -> grant: median {}, p99 {}, max {} ({} grants); a message has {:.0} bytes\n\
         mediator: {:.1} % of a core, {:.1} us for each report; resident {rss_mib:.1} MiB, then {:.1} MiB",
        if secure { " with certificates" } else { "" },
        site.areas.len(),
        reports as f64 / took_s,
        floor.heard as f64 / took_s,
        (floor.moves() - moves) as f64 / took_s,
        ms(times.per_mille(500)),
        ms(times.per_mille(990)),
        ms(times.max()),
        times.count(),
        floor.bytes as f64 / floor.heard.max(1) as f64,
        100.0 * cpu_s / took_s,
        1e6 * report_s,
        program.rss_mib()
    );
    let registered = { floor.robots.iter() }
        .filter(|robot| robot.client.is_registered())
        .count();
    // Of fewer, or of nets that do not run, the figures say nothing.
    assert_eq!(registered, count, "robots that are registered");
    assert_eq!(nets, PLACES, "nets that run");
    assert!(times.count() > 0, "nobody moved: {}", program.log());
    let grown_mib = program.rss_mib() - rss_mib;
    assert!(grown_mib < MOST_GROWTH_MIB, "{grown_mib} MiB more");
    let p99 = times.per_mille(990);
    assert!(p99 < MOST_P99, "p99 {}", ms(p99));
    report_s
}

pub fn run() {
    let few_s = measure(100, false);
    let many_s = measure(1000, false);
    measure(1000, true);
    let grown = many_s / few_s;
    println!("\na report among 1000 robots costs {grown:.2} times what it costs among 100");
    assert!(grown < MOST_GROWN, "{grown:.2} times");
}
