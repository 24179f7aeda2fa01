//! The stage of a scenario with a fleet: world, devices, listener, mediator and robots.

use std::fs;
use std::path::{Path, PathBuf};

use config::SiteConfig;
use onboard::process::inspect;
use onboard::process::runtime::Runtime;
use rustix::process::Signal;
use serde_json::Value as Json;
use sim::rt::monotonic_ns;
use sim::world::{Pose, Random, SharedWorld, TruthRecord};

use crate::cli::Failure;
use crate::folder::Folder;
use crate::network::listener::FleetListener;
use crate::network::mediator_status::Board;
use crate::one_robot::listener::free_endpoint;
use crate::one_robot::stage::{make_folder, runtime_in, settings};
use crate::process::Usage;
use crate::process::janitor::Janitor;
use crate::process::mediator::{MediatorProcess, MediatorSetup};
use crate::process::robot::{RobotProcess, RobotSetup};
use crate::scenario::Scenario;
use crate::testbed::{BusPlace, Devices, drawn_start, start_pose, world};

/// Numbers drawn for starting times have nothing to do with those that the world draws.
const DELAY_STREAM: u64 = 0x4445_4c41;

/// How a scenario is run.
#[derive(Clone, Debug)]
pub struct StageSetup<'a> {
    /// The program that becomes mediator and robots: the rig's own.
    pub program: PathBuf,
    /// Decides wheel errors, start offsets, starting times and noise.
    pub seed: u64,
    /// Folder for what the scenario leaves.
    pub out: &'a Path,
    /// Start the mediator.
    pub mediator: bool,
    /// Leave the site's coordinations as they are.
    pub nets: bool,
}

/// One robot on the stage. Fields are dropped in this order: the robot first, then its devices.
pub struct Member {
    process: Option<RobotProcess>,
    /// Its devices.
    pub devices: Devices,
    /// Memory and processor time of its last process.
    pub usage: Usage,
    setup: RobotSetup,
    start_at_ns: u64,
    started: bool,
}

/// A scenario under way. Fields are dropped in this order: robots, then the mediator, then what they talk to.
pub struct FleetStage {
    /// Robots, in the order of the scenario.
    pub members: Vec<Member>,
    /// The mediator, if there is one.
    pub mediator: Option<MediatorProcess>,
    /// What the mediator tells its operators.
    pub board: Option<Board>,
    /// The world; robots have the numbers that they have in the scenario.
    pub world: SharedWorld,
    /// An independent ear on the network.
    pub listener: FleetListener,
    /// When the first robot may start.
    pub start_ns: u64,
    runtime: Runtime,
    seen: u64,
    _folder: Folder,
    _janitor: Janitor,
}

impl FleetStage {
    /// Builds the world, and starts devices and mediator; robots follow with [`Self::start_robots`].
    ///
    /// # Errors
    /// [`Failure::Refused`] naming what is wrong or cannot be had.
    pub fn set(scenario: &Scenario, setup: &StageSetup<'_>) -> Result<Self, Failure> {
        make_folder(setup.out)?;
        let folder = Folder::new()?;
        let janitor = Janitor::start(&setup.program, folder.path()).map_err(Failure::refused)?;
        let site = &scenario.site;
        let site_file = if setup.nets {
            scenario.site_file.clone()
        } else {
            without_nets(&scenario.site_file, folder.path())?
        };
        let starts = starts(scenario, site, setup.seed)?;
        let robots: Vec<_> = { scenario.robots.iter() }
            .zip(&starts)
            .map(|(player, start)| (&player.config, *start))
            .collect();
        let world = world(site, &robots, setup.seed)?;
        // A name of this run's own, so that two rigs on one machine never meet.
        let key_prefix = format!("rig-{}", std::process::id());
        let listener =
            FleetListener::open(&key_prefix, site, &scenario.nets).map_err(Failure::refused)?;
        let mediator_endpoint = free_endpoint().map_err(Failure::refused)?;
        let runtime_folder = folder.path().join("run");
        let runtime = runtime_in(&runtime_folder)?;
        let mediator = setup.mediator.then(|| {
            MediatorProcess::start(MediatorSetup {
                program: setup.program.clone(),
                site_file: site_file.clone(),
                site: site.name.clone(),
                journal: folder.path().join("journal.redb"),
                key_prefix: key_prefix.clone(),
                listen: mediator_endpoint.clone(),
                connect: listener.endpoint().to_owned(),
                runtime: folder.path().join("mediator"),
                log: setup.out.join("mediator.log"),
            })
        });
        let mediator = mediator.transpose().map_err(|error| {
            Failure::refused(format_args!("the mediator cannot be started: {error}"))
        })?;
        let board = { mediator.as_ref() }
            .map(|mediator| {
                let socket = mediator.socket()?;
                Board::watch(socket).map_err(|error| error.to_string())
            })
            .transpose()
            .map_err(Failure::refused)?;
        let start_ns = monotonic_ns();
        let mut delays = Random::new(setup.seed, DELAY_STREAM);
        let mut members = Vec::new();
        for (number, player) in scenario.robots.iter().enumerate() {
            let lidar_link = folder.path().join(format!("lidar-{}", player.id));
            let any_port = BusPlace::Udp(([127, 0, 0, 1], 0).into());
            let seed = setup.seed.wrapping_add(1_000_003 * number as u64);
            let link = Some(lidar_link.clone());
            let devices = Devices::start(&world, &player.config, &any_port, link, seed)?;
            let mut set = player.set.clone();
            let peers = [listener.endpoint(), &mediator_endpoint];
            set.extend(settings(&devices, &lidar_link, &peers, &key_prefix)?);
            set.push("fleet.listen=[]".to_owned());
            members.push(Member {
                process: None,
                devices,
                usage: Usage::of(0),
                setup: RobotSetup {
                    program: setup.program.clone(),
                    id: player.id.clone(),
                    robot_file: player.file.clone(),
                    site_file: site_file.clone(),
                    set,
                    runtime: runtime_folder.clone(),
                    log: setup.out.join(format!("{}.log", player.id)),
                    environment: Vec::new(),
                },
                start_at_ns: start_ns + (delays.unit() * scenario.start_delay_s * 1e9) as u64,
                started: false,
            });
        }
        Ok(Self {
            members,
            mediator,
            board,
            world,
            listener,
            start_ns,
            runtime,
            seen: 0,
            _folder: folder,
            _janitor: janitor,
        })
    }

    /// Starts every robot whose time has come.
    ///
    /// # Errors
    /// [`Failure::Failed`] when one cannot be started.
    pub fn start_robots(&mut self) -> Result<(), Failure> {
        let now_ns = monotonic_ns();
        for member in &mut self.members {
            if !member.started && now_ns >= member.start_at_ns {
                member.start()?;
            }
        }
        Ok(())
    }

    /// What the world has logged since the last call.
    pub fn new_truths(&mut self) -> Vec<TruthRecord> {
        let mut world = self.world.lock();
        world.advance_to(monotonic_ns());
        let truths = world.log().since(self.seen).copied().collect();
        self.seen = world.log().next_sequence();
        truths
    }

    /// All symbols of a running robot, as `onboard inspect --json` shows them.
    #[must_use]
    pub fn symbols(&self, robot: usize) -> Json {
        self.members.get(robot).map_or(Json::Null, |member| {
            inspect::snapshot(&self.runtime, &member.setup.id).unwrap_or(Json::Null)
        })
    }

    /// Seconds since the start.
    #[must_use]
    pub fn seconds(&self, at_ns: u64) -> f64 {
        at_ns.saturating_sub(self.start_ns) as f64 / 1e9
    }

    /// Tells all robots at once to stop, so that none waits for another to end.
    pub fn tell_robots_to_stop(&mut self) {
        for member in &mut self.members {
            if let Some(process) = &mut member.process {
                process.signal(Signal::TERM);
            }
        }
    }
}

impl Drop for FleetStage {
    fn drop(&mut self) {
        self.tell_robots_to_stop();
    }
}

impl Member {
    /// Starts its process; one that runs goes on, one that has ended starts once more.
    ///
    /// # Errors
    /// [`Failure::Failed`] with the operating system's reason.
    pub fn start(&mut self) -> Result<(), Failure> {
        if self
            .process
            .as_mut()
            .is_some_and(|own| own.poll().is_none())
        {
            return Ok(());
        }
        // What a killed one left is removed first.
        self.process = None;
        let setup = self.setup.clone();
        let process = if self.started {
            RobotProcess::start_again(setup)
        } else {
            RobotProcess::start(setup)
        };
        let process = process.map_err(|error| {
            Failure::failed(format_args!(
                "robot {} cannot be started: {error}",
                self.setup.id
            ))
        })?;
        self.started = true;
        self.usage = Usage::of(process.id());
        self.process = Some(process);
        Ok(())
    }

    /// Its process, once it was started.
    pub fn process(&mut self) -> Option<&mut RobotProcess> {
        self.process.as_mut()
    }

    /// Its identity.
    #[must_use]
    pub fn id(&self) -> &str {
        &self.setup.id
    }

    /// Where its log is.
    #[must_use]
    pub fn log(&self) -> &Path {
        &self.setup.log
    }
}

/// Where the robots truly start, each with an offset of its own.
fn starts(scenario: &Scenario, site: &SiteConfig, seed: u64) -> Result<Vec<Pose>, Failure> {
    { scenario.robots.iter().enumerate() }
        .map(|(number, player)| {
            let seed = seed.wrapping_add(7_919 * number as u64);
            Ok(drawn_start(start_pose(site, &player.id)?, seed))
        })
        .collect()
}

/// A copy of the site file in this folder, from which all coordinations are taken out.
fn without_nets(site_file: &Path, folder: &Path) -> Result<PathBuf, Failure> {
    let cannot = |what: String| {
        Failure::refused(format_args!(
            "the site cannot be had without its coordinations: {what}"
        ))
    };
    let text = fs::read_to_string(site_file).map_err(|error| cannot(error.to_string()))?;
    let mut table: toml::Table = text
        .parse()
        .map_err(|error: toml::de::Error| cannot(error.to_string()))?;
    table.remove("coordinations");
    let text = toml::to_string(&table).map_err(|error| cannot(error.to_string()))?;
    let copy = folder.join("site.toml");
    fs::write(&copy, text).map_err(|error| cannot(error.to_string()))?;
    Ok(copy)
}
