//! Somebody sends nonsense, and much of it: honest robots notice nothing, and neither memory nor log grow.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

use contract::client::{Client, Received, Situation};
use contract::floor::Floor;
use contract::wire::{MediatorReport, RobotReport};
use contract::{Message, VERSION, keys};
use zenoh::Wait;
use zenoh::qos::CongestionControl;

use crate::program::{Program, Site, folder, hear, session};
use crate::random::Random;

const PREFIX: &str = "fleet";
const SILENT_NS: u64 = 1_000_000_000;
const REPORT: Duration = Duration::from_millis(200);
/// How long each kind of nonsense goes on.
const LASTS: Duration = Duration::from_millis(1500);
const HUGE: usize = 100 << 20;
const RATE_PER_S: f64 = 5_000.0;
/// A busy machine reaches at least that,
const LEAST_PER_S: f64 = 500.0;
/// and a quiet one, on which the longer test is for.
const QUIET_PER_S: f64 = 4_500.0;
/// Malformed bytes leave no more than this, in memory and in the log.
const MOST_MIB: f64 = 8.0;
const MOST_LOG: usize = 4_000;
/// Nor is the huge message ever in memory as a whole.
const MOST_PEAK_MIB: f64 = 24.0;
/// Names that the site does not list.
const STRANGERS: u64 = 10_000;

fn site() -> Site {
    Site {
        name: "rooms".into(),
        areas: (0..3).map(|room| (format!("room-{room}"), 1)).collect(),
        robots: (0..2)
            .map(|robot| (format!("amr-{robot}"), "normal", robot))
            .collect(),
        events: Vec::new(),
        more: String::new(),
        nets: Vec::new(),
        own_nets: Vec::new(),
    }
}

/// Robots that stand, and report as they must.
struct Honest {
    session: zenoh::Session,
    inbox: Receiver<MediatorReport>,
    robots: Vec<(Client, Instant)>,
    begun: Instant,
    longest: Duration,
}

impl Honest {
    fn new(session: zenoh::Session, site: &Site) -> Self {
        // Refusals of others' robots, too.
        let inbox = hear(&session, keys::to_all_robots(PREFIX));
        let robots = { site.robots.iter().zip(1..) }
            .map(|((id, ..), boot)| (Client::new(id, &site.name, boot), Instant::now()))
            .collect();
        Self {
            session,
            inbox,
            robots,
            begun: Instant::now(),
            longest: Duration::ZERO,
        }
    }

    /// Reports, and hears, until it is told to end.
    fn run(&mut self, end: &AtomicBool) {
        while !end.load(Ordering::Relaxed) {
            for room in 0..self.robots.len() {
                self.report(room);
            }
            let next = Instant::now() + REPORT;
            let left = || next.saturating_duration_since(Instant::now());
            while let Ok(message) = self.inbox.recv_timeout(left()) {
                self.hear(&message);
            }
        }
    }

    fn report(&mut self, room: usize) {
        let now_ns = self.begun.elapsed().as_nanos() as u64;
        let (client, heard) = &mut self.robots[room];
        let here = vec![format!("room-{room}")];
        let situation = Situation {
            located: true,
            stands_in: here.clone(),
            wanted: here,
            ..Situation::default()
        };
        client.step(situation, now_ns, SILENT_NS);
        let report = client.report();
        self.longest = self.longest.max(heard.elapsed());
        let key = keys::report(PREFIX, &report.robot_id).expect("a plain name");
        self.session
            .put(key, report.encode_to_vec())
            .wait()
            .expect("it sends");
    }

    fn hear(&mut self, message: &MediatorReport) {
        let now_ns = self.begun.elapsed().as_nanos() as u64;
        for (client, heard) in &mut self.robots {
            match client.receive(message, now_ns) {
                Received::News | Received::Registered => {
                    self.longest = self.longest.max(heard.elapsed());
                    *heard = Instant::now();
                }
                // It learns the floor.
                Received::Refused if !message.floor.is_empty() => {
                    *client = client.clone().on(Floor::said(&message.floor));
                }
                _ => {}
            }
        }
    }
}

fn send(session: &zenoh::Session, robot: &str, bytes: Vec<u8>) {
    let key = keys::report(PREFIX, robot).expect("a plain name");
    let put = session
        .put(key, bytes)
        .congestion_control(CongestionControl::Drop);
    put.wait().expect("the session is open");
}

/// Tells the honest robots to end, also where an assertion fails meanwhile.
struct Ends<'a>(&'a AtomicBool);

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Calls `nonsense` with growing numbers for this time, and until it was called so often: [`RATE_PER_S`] times a second, or as often as
/// this machine can. Returns how often.
fn flood(lasts: Duration, at_least: u64, mut nonsense: impl FnMut(u64)) -> u64 {
    let (begun, mut number) = (Instant::now(), 0);
    while begun.elapsed() < lasts || number < at_least {
        let due = begun.elapsed().as_secs_f64() * RATE_PER_S;
        if number as f64 >= due {
            std::thread::sleep(Duration::from_millis(1));
            continue;
        }
        number += 1;
        nonsense(number);
    }
    let rate_per_s = number as f64 / begun.elapsed().as_secs_f64();
    println!("{rate_per_s:.0} a second, {number} in all");
    number
}

#[test]
fn honest_robots_notice_nothing_of_nonsense() {
    withstand(LASTS, LEAST_PER_S);
}

/// `cargo test -p mediator --test it -- --ignored --nocapture minute`
#[test]
#[ignore = "takes a minute; prints memory and log before and after"]
fn honest_robots_notice_nothing_of_a_minute_of_malformed_bytes() {
    withstand(Duration::from_secs(60), QUIET_PER_S);
}

/// Malformed bytes for this time, at least so many a second, then strangers, then liars, then one huge message.
fn withstand(malformed_lasts: Duration, least_per_s: f64) {
    let folder = folder();
    let site = site();
    let (honest, honest_at) = session(&[]);
    let (other, other_at) = session(&[]);
    let mut program = Program::new(folder.path(), &site, vec![honest_at, other_at]);
    program.start();
    program.wait_ready(Duration::from_secs(60));
    let mut honest = Honest::new(honest, &site);
    let end = AtomicBool::new(false);
    std::thread::scope(|threads| {
        let robots = threads.spawn(|| {
            honest.run(&end);
            honest
        });
        let ends = Ends(&end);
        std::thread::sleep(Duration::from_secs(3));
        let before = (program.rss_mib(), program.log().len());
        let mut random = Random::new(1);
        let malformed = flood(malformed_lasts, 0, |_| {
            let bytes = (0..64).map(|_| random.next() as u8).collect();
            send(&other, "amr-0", bytes);
        });
        let after = (program.rss_mib(), program.log().len());
        println!(
            "malformed bytes: {:.1} MiB and {} bytes of log before, {:.1} MiB and {} bytes after",
            before.0, before.1, after.0, after.1
        );
        assert!(after.0 - before.0 < MOST_MIB && after.1 - before.1 < MOST_LOG);
        let strangers = flood(LASTS, STRANGERS, |number| {
            let robot_id = format!("stranger-{number}");
            let report = RobotReport {
                robot_id: robot_id.clone(),
                site: "rooms".into(),
                boot_epoch: number,
                sequence: 1,
                ..RobotReport::default()
            };
            send(&other, &robot_id, report.encode_to_vec());
        });
        let liars = flood(LASTS, 0, |number| {
            let report = RobotReport {
                robot_id: "amr-1".into(),
                site: "rooms".into(),
                boot_epoch: 1000 + number,
                sequence: 1,
                version: Some(VERSION.into()),
                ..RobotReport::default()
            };
            send(&other, "amr-1", report.encode_to_vec());
        });
        // Names that no key of ours can have, longer ones than anybody needs, and areas that are not there.
        let long = "x".repeat(100_000);
        let odd = flood(LASTS, 0, |number| {
            let key = format!("{PREFIX}/robots/a b{}/report", number % 8);
            let put = |key: &str, report: RobotReport| {
                let put = other.put(key.to_owned(), report.encode_to_vec());
                let put = put.congestion_control(CongestionControl::Drop);
                put.wait().expect("the session is open");
            };
            let report = RobotReport {
                robot_id: format!("a b{}", number % 8),
                boot_epoch: number,
                sequence: 1,
                ..RobotReport::default()
            };
            put(&key, report.clone());
            if number % 100 == 0 {
                let key = keys::report(PREFIX, "amr-1").expect("a plain name");
                let of_another = RobotReport {
                    robot_id: long.clone(),
                    ..report.clone()
                };
                put(&key, of_another);
                let elsewhere = RobotReport {
                    robot_id: "amr-1".into(),
                    site: long.clone(),
                    version: Some(VERSION.into()),
                    ..report
                };
                put(&key, elsewhere);
            }
        });
        let least = malformed_lasts.as_secs_f64() * least_per_s;
        assert!(malformed as f64 > least, "{malformed}");
        assert!(strangers >= STRANGERS && liars as f64 > LASTS.as_secs_f64() * LEAST_PER_S);
        let sent = malformed + strangers + liars + odd;
        let key = keys::report(PREFIX, "amr-0").expect("a plain name");
        let peak_mib = program.peak_mib();
        let huge = other
            .put(key, vec![0; HUGE])
            .congestion_control(CongestionControl::Block);
        huge.wait().expect("the session is open");
        std::thread::sleep(Duration::from_secs(1));
        let higher_mib = program.peak_mib() - peak_mib;
        assert!(higher_mib < MOST_PEAK_MIB, "{higher_mib} MiB for a moment");
        let grown_mib = program.rss_mib() - before.0;
        drop(ends);
        let honest = robots.join().expect("it ran");
        let log = program.log();
        for (client, _) in &honest.robots {
            assert!(client.is_registered(), "{}; {log}", client.refusal());
        }
        // They report at 5 Hz, and a second without an answer is silence.
        assert!(
            honest.longest < Duration::from_secs(1),
            "{:?}; {log}",
            honest.longest
        );
        assert!(grown_mib < 48.0, "{grown_mib} MiB");
        assert!(
            log.len() < 20_000,
            "{} bytes of log, as {}",
            log.len(),
            &log[..4_000]
        );
        assert!(log.contains("are no reports, and ignored"), "{log}");
        println!(
            "longest {:?}, {grown_mib:.1} MiB, {} bytes of log, {sent} sent",
            honest.longest,
            log.len()
        );
    });
}
