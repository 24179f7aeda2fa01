//! The file system of the journal is full, in earnest: nothing is granted, people are told, and it goes on by itself when there is room.

use std::fs::File;
use std::io::Write;
use std::process::Command;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

use contract::client::{Client, Received, Situation};
use contract::floor::Floor;
use contract::wire::MediatorReport;
use contract::{Message, keys};
use zenoh::Wait;

use crate::program::{Program, Site, folder, hear, session};

const PREFIX: &str = "fleet";
const SILENT_NS: u64 = 1_000_000_000;
const REPORT: Duration = Duration::from_millis(100);
const PATIENCE: Duration = Duration::from_secs(60);
/// A robot is silent after 1 s, and a link may be slow to carry its first message on a busy machine: longer than both.
const UNHEARD: Duration = Duration::from_secs(3);
const DISK_KIB: u64 = 8192;

fn site() -> Site {
    Site {
        name: "rooms".into(),
        areas: vec![("room".into(), 1)],
        robots: vec![("amr-1".into(), "normal", 0)],
        events: Vec::new(),
        more: String::new(),
        nets: Vec::new(),
        own_nets: Vec::new(),
    }
}

/// A robot outside, which wants to go into the room, and then no more, again and again.
struct Robot {
    session: zenoh::Session,
    inbox: Receiver<MediatorReport>,
    client: Client,
    begun: Instant,
    heard: Instant,
    wants: bool,
    granted: u64,
}

impl Robot {
    fn now_ns(&self) -> u64 {
        self.begun.elapsed().as_nanos() as u64
    }

    fn step(&mut self) {
        let wanted = if self.wants {
            vec!["room".into()]
        } else {
            Vec::new()
        };
        let situation = Situation {
            located: true,
            wanted,
            ..Situation::default()
        };
        self.client.step(situation, self.now_ns(), SILENT_NS);
        let key = keys::report(PREFIX, "amr-1").expect("a plain name");
        let report = self.client.report().encode_to_vec();
        self.session.put(key, report).wait().expect("it sends");
        let next = Instant::now() + REPORT;
        while let Ok(message) = self
            .inbox
            .recv_timeout(next.saturating_duration_since(Instant::now()))
        {
            self.heard = Instant::now();
            let now_ns = self.now_ns();
            let received = self.client.receive(&message, now_ns);
            if received == Received::Refused && !message.floor.is_empty() {
                self.client = self.client.clone().on(Floor::said(&message.floor));
            }
        }
        if self.client.holds("room") == self.wants {
            self.granted += u64::from(self.wants);
            self.wants = !self.wants;
        }
    }

    fn until(&mut self, what: &str, program: &Program, mut is_so: impl FnMut(&Self) -> bool) {
        let until = Instant::now() + PATIENCE;
        while !is_so(self) {
            assert!(Instant::now() < until, "never: {what}: {}", program.log());
            self.step();
        }
    }
}

#[test]
fn a_full_file_system_stops_grants_and_says_so() {
    let folder = folder();
    let (session, endpoint) = session(&[]);
    let mut program = Program::new(folder.path(), &site(), vec![endpoint]);
    if let Err(why) = program.limit_disk(DISK_KIB) {
        eprintln!("skipped: no file system of its own, which needs CAP_SYS_ADMIN: {why}");
        return;
    }
    let inbox = hear(&session, keys::to_robot(PREFIX, "amr-1"));
    program.start();
    program.wait_ready(PATIENCE);
    let mut robot = Robot {
        session,
        inbox,
        client: Client::new("amr-1", "rooms", 7),
        begun: Instant::now(),
        heard: Instant::now(),
        wants: true,
        granted: 0,
    };
    robot.until("it is granted the room, and again", &program, |robot| {
        robot.granted > 2
    });

    // A process that writes without end.
    let path = program.disk().join("filler");
    let mut filler = File::create(&path).expect("its disk is there");
    let full = std::iter::repeat_with(|| filler.write(&[7; 4096])).find_map(Result::err);
    let full = full.map(|error| error.kind());
    assert_eq!(full, Some(std::io::ErrorKind::StorageFull));
    robot.until("it hears nothing, and has no grant", &program, |robot| {
        let client = &robot.client;
        robot.heard.elapsed() > UNHEARD && !client.may_be_in("room", robot.now_ns())
    });
    let said = program.log();
    let error = program.status().expect_err("nothing is on the disk");
    assert!(error.contains("full"), "{error}");
    assert!(said.contains("cannot be written"), "{said}");
    // Once, and not with each of the robot's reports.
    let lines = said.matches("cannot be written").count();
    assert!(lines < 10, "{said}");

    drop(filler);
    std::fs::remove_file(path).expect("it was there");
    let before = robot.granted;
    robot.until("it is granted the room again", &program, |robot| {
        robot.granted > before + 2
    });
    assert!(
        program.log().contains("is written again"),
        "{}",
        program.log()
    );
    let status = program.status().expect("it answers");
    assert!(status.robots[0].heard, "{status:?}");
    program.kill();
}

/// A first start on a disk that is full, and one when there is room, which asks whether it is to be a first one.
const BEGINS: &str = r#"
mount -t tmpfs -o size=4096k,mode=0700 none "$1/disk"
dd if=/dev/zero of="$1/disk/filler" bs=4096 2>"$1/dd"
"$0" run --site "$2" --journal "$1/disk/journal" --runtime "$1/run" --listen tcp/127.0.0.1:0 --first-start
ls "$1/disk"
rm "$1/disk/filler"
"$0" run --site "$2" --journal "$1/disk/journal" --runtime "$1/run" --listen tcp/127.0.0.1:0
ls "$1/disk"
"#;

#[test]
fn a_journal_that_a_full_file_system_has_not_taken_is_begun_when_it_has_room() {
    let folder = folder();
    let mut program = Program::new(folder.path(), &site(), Vec::new());
    if let Err(why) = program.limit_disk(DISK_KIB) {
        eprintln!("skipped: no file system of its own, which needs CAP_SYS_ADMIN: {why}");
        return;
    }
    std::fs::create_dir(folder.path().join("disk")).expect("made");
    let output = Command::new("unshare")
        .args(["--mount", "sh", "-c", BEGINS])
        .arg(env!("CARGO_BIN_EXE_mediator"))
        .arg(folder.path())
        .arg(program.site_file())
        .env_remove("MEDIATOR_LOG")
        .output()
        .expect("it starts");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let there = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("free space on its disk"), "{said}");
    assert!(said.contains("is empty"), "{said}");
    assert_eq!(there, "filler\njournal\n", "{said}");
}
