//! A site with keys, its mediator, robots that behave, and sessions that do not.

use std::path::PathBuf;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

use contract::client::{Client, Received, Situation};
use contract::floor::Floor;
use contract::network::{Access, Identity, NetworkSettings, Party, Security};
use contract::timing::ENTERS_NO_MORE_NS;
use contract::wire::MediatorReport;
use contract::{Message, keys, private};
use mediator::keys::Keys;
use mediator::manager::{RobotStatus, Status};
use zenoh::Wait;

use super::PATIENCE;
use crate::program::{Program, Site, folder, free_endpoint, hear};

pub const PREFIX: &str = "fleet";

/// Robots may wait longer; tests have no time.
const UNHEARD: Duration = Duration::from_secs(5);

pub fn site() -> Site {
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

/// The site, and its running mediator.
pub struct Hall {
    pub keys: Keys,
    pub endpoint: String,
    pub program: Program,
    pub folder: tempfile::TempDir,
    /// When it has answered first.
    ready: Instant,
}

impl Hall {
    pub fn open() -> Self {
        Self::with_certificates_for(30.0)
    }

    pub fn with_certificates_for(days: f64) -> Self {
        Self::with(days, |_| {})
    }

    /// Of which the mediator may have no more than so many files open.
    pub fn with_files(most: u64) -> Self {
        Self::with(30.0, |program| program.limit_files(most))
    }

    fn with(days: f64, set_up: impl FnOnce(&mut Program)) -> Self {
        let folder = folder();
        let keys = Keys::new(folder.path().join("keys"));
        keys.begin("rooms", days).expect("an authority");
        let endpoint = free_endpoint("tls");
        let mut program = Program::new(folder.path(), &site(), Vec::new());
        program.listen(&endpoint);
        program.add(&["--keys", &keys.folder().display().to_string()]);
        set_up(&mut program);
        program.start();
        program.wait_ready(PATIENCE);
        Self {
            keys,
            endpoint,
            program,
            folder,
            ready: Instant::now(),
        }
    }

    pub fn identity(&self, robot: &str) -> Identity {
        let party = Party::Robot(robot.to_owned());
        self.keys.issue(party).expect("it is made")
    }

    /// How an honest robot takes part.
    pub fn settings_as(&self, identity: &Identity) -> NetworkSettings {
        NetworkSettings {
            connect: vec![self.endpoint.clone()],
            security: Some(Security {
                identity: identity.clone(),
                access: Access::MediatorOnly,
            }),
            ..NetworkSettings::default()
        }
    }

    pub fn robot(&self, id: &str) -> Robot {
        Robot::new(self.settings_as(&self.identity(id)), id)
    }

    /// A session that holds to no rules, with this identity.
    pub fn lawless(&self, identity: &Identity, mode: &str, listen: &[&str]) -> zenoh::Session {
        let connect = if listen.is_empty() {
            vec![self.endpoint.as_str()]
        } else {
            Vec::new()
        };
        let file = |name: &str, text: &str| -> String {
            let path = self
                .folder
                .path()
                .join(format!("{name}-{}.pem", next_number()));
            std::fs::write(&path, text).expect("written");
            path.display().to_string()
        };
        let pem = identity.to_pem();
        let own = &pem[pem.find("-----BEGIN CERTIFICATE").expect("there")..];
        let root = self
            .keys
            .folder()
            .join("authority.crt")
            .display()
            .to_string();
        let (key, own) = (file("key", &pem), file("own", own));
        let mut config = zenoh::Config::default();
        let mut set = |name: &str, value: String| {
            config
                .insert_json5(name, &value)
                .expect("a setting of zenoh");
        };
        let text = |value: &str| format!("{value:?}");
        set("mode", text(mode));
        set("listen/endpoints", format!("{listen:?}"));
        set("connect/endpoints", format!("{connect:?}"));
        // A client tries once unless it is told otherwise, and the mediator may be opening its network anew just then.
        set("connect/timeout_ms", r#"{ "client": 20000 }"#.to_owned());
        let retry =
            r#"{ "period_init_ms": 200, "period_max_ms": 200, "period_increase_factor": 1.0 }"#;
        set("connect/retry", retry.to_owned());
        set("scouting/multicast/enabled", "false".to_owned());
        set("transport/link/tls/root_ca_certificate", text(&root));
        set("transport/link/tls/enable_mtls", "true".to_owned());
        set(
            "transport/link/tls/verify_name_on_connect",
            "false".to_owned(),
        );
        for side in ["listen", "connect"] {
            set(
                &format!("transport/link/tls/{side}_private_key"),
                text(&key),
            );
            set(
                &format!("transport/link/tls/{side}_certificate"),
                text(&own),
            );
        }
        zenoh::open(config).wait().expect("a session")
    }

    /// Nothing is granted before every robot was heard, or is said to be nowhere. One that starts in an area counts as there.
    pub fn excuse(&self, robot: &str) {
        self.wait_for_leases();
        let run = self.folder.path().join("run").display().to_string();
        let order = ["absent", robot, "--runtime", &run];
        let (code, text) = Program::command(&order);
        assert!(code == Some(2) && text.contains("--taken-away"), "{text}");
        let (code, text) = Program::command(&[&order[..], &["--taken-away"]].concat());
        assert_eq!(code, Some(0), "{text}");
    }

    /// From then on a mediator that has started knows of all that may still be entered.
    pub fn wait_for_leases(&self) {
        let over = self.ready + Duration::from_nanos(ENTERS_NO_MORE_NS);
        std::thread::sleep(over.saturating_duration_since(Instant::now()));
    }

    /// Waits until the robot has heard of the mediator.
    pub fn until_served(&self, what: &str, robot: &mut Robot) {
        self.until(what, || {
            robot.step();
            robot.heard > 0
        });
    }

    /// Waits until it is so.
    pub fn until(&self, what: &str, mut is_so: impl FnMut() -> bool) {
        let until = Instant::now() + PATIENCE;
        while !is_so() {
            assert!(
                Instant::now() < until,
                "never: {what}: {}",
                self.program.log()
            );
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

fn next_number() -> u64 {
    use std::sync::atomic::{AtomicU64, Ordering};
    static LAST: AtomicU64 = AtomicU64::new(0);
    LAST.fetch_add(1, Ordering::Relaxed)
}

pub fn robot<'a>(status: &'a Status, id: &str) -> &'a RobotStatus {
    { status.robots.iter().find(|robot| robot.id == id) }.expect("a robot of the site")
}

/// The file of an operator.
pub fn operator(hall: &Hall, name: &str) -> PathBuf {
    let identity = hall
        .keys
        .issue(Party::Operator(name.to_owned()))
        .expect("made");
    let path = hall.folder.path().join(format!("{name}.pem"));
    private::replace(&path, identity.to_pem().as_bytes()).expect("written");
    path
}

/// A robot that stands in its room, and behaves.
pub struct Robot {
    pub session: zenoh::Session,
    /// Messages that it has got.
    pub heard: u64,
    /// From which processes, drawn numbers.
    pub instances: Vec<u64>,
    id: String,
    settings: NetworkSettings,
    client: Client,
    inbox: Receiver<MediatorReport>,
    begun: Instant,
    heard_at: Instant,
}

/// A session, and what the mediator says to a robot on it.
fn link(settings: &NetworkSettings, id: &str) -> (zenoh::Session, Receiver<MediatorReport>) {
    let session = settings.open().expect("a session");
    let inbox = hear(&session, keys::to_robot(PREFIX, id));
    (session, inbox)
}

impl Robot {
    pub fn new(settings: NetworkSettings, id: &str) -> Self {
        let (session, inbox) = link(&settings, id);
        Self {
            settings,
            session,
            heard_at: Instant::now(),
            heard: 0,
            instances: Vec::new(),
            id: id.to_owned(),
            client: Client::new(id, "rooms", 7),
            inbox,
            begun: Instant::now(),
        }
    }

    /// Hears what there is, and reports. Opens another session where it hears nothing: it may have come just when the mediator
    /// closed its own.
    pub fn step(&mut self) {
        if self.heard_at.elapsed() > UNHEARD && self.is_linked() {
            self.heard_at = Instant::now();
            (self.session, self.inbox) = link(&self.settings, &self.id);
        }
        let now_ns = self.begun.elapsed().as_nanos() as u64;
        while let Ok(message) = self.inbox.try_recv() {
            self.heard += 1;
            self.heard_at = Instant::now();
            if !self.instances.contains(&message.instance) {
                self.instances.push(message.instance);
            }
            if self.client.receive(&message, now_ns) == Received::Refused
                && !message.floor.is_empty()
            {
                self.client = self.client.clone().on(Floor::said(&message.floor));
            }
        }
        let here = vec![self.id.replace("amr", "room")];
        let situation = Situation {
            located: true,
            stands_in: here.clone(),
            wanted: here,
            ..Situation::default()
        };
        self.client.step(situation, now_ns, 1_000_000_000);
        let key = keys::report(PREFIX, &self.id).expect("a plain name");
        let put = self.session.put(key, self.client.report().encode_to_vec());
        put.wait().expect("it sends");
    }

    pub fn holds(&self) -> bool {
        self.client.holds(&self.id.replace("amr", "room"))
    }

    pub fn epoch(&mut self) -> u64 {
        self.client.report().mediator_epoch
    }

    pub fn is_linked(&self) -> bool {
        self.session.info().peers_zid().wait().next().is_some()
    }
}
