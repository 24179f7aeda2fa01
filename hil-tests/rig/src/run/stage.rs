//! The real programs in real time: world, devices, listener, mediator and robots.

use description::instruction::Instruction;
use std::path::Path;
use std::time::Duration;

use onboard::cli::Failure;
use onboard::process::ctl;
use onboard::process::inspect;
use onboard::process::runtime::Runtime;
use onboard::symbols::faults::Fault;
use rustix::process::Signal;
use serde_json::Value as Json;
use sim::rt::monotonic_ns;
use sim::world::{SharedWorld, Truth, TruthRecord, World};

use super::ending::Ending;
use super::execution::{Execution, Found, LOOK_NS, MediatorRuns};
use super::links::Links;
use super::measured::{device_violations, robot_summary};
use super::member::Member;
use super::options::Options;
use super::settings::{settings, without_nets};
use crate::belief::{Belief, Insight};
use crate::folder::Folder;
use crate::machine::round;
use crate::network::listener::Listener;
use crate::network::mediator_status::{MediatorWatch, Told};
use crate::network::observations::Observations;
use crate::output::make_folder;
use crate::process::Usage;
use crate::process::janitor::Janitor;
use crate::process::mediator::{MediatorProcess, MediatorSetup};
use crate::process::robot::{RobotSetup, send};
use crate::scenario::{Player, Scenario};
use crate::stalls::StallWatch;
use crate::stand_ins::caretaker::{Blame, Care, Caretaker, words};
use crate::stand_ins::clutter::furnish;
use crate::summary::{MediatorSummary, RobotSummary};
use crate::testbed::{BusPlace, Devices, drawn_starts, start_delays_ns, world};
use crate::violation::ViolationKind;

/// The programs of a scenario. Fields are dropped in this order: robots, then the mediator, then what they talk to.
pub struct Stage {
    /// Robots, in the order of the scenario.
    pub members: Vec<Member>,
    /// The mediator, if there is one.
    pub mediator: Option<MediatorProcess>,
    watch: Option<MediatorWatch>,
    /// The world; robots have the numbers that they have in the scenario.
    pub world: SharedWorld,
    /// The independent listener.
    pub listener: Listener,
    /// Where robots find the mediator.
    pub links: Links,
    players: Vec<Player>,
    managed: bool,
    start_ns: u64,
    runtime: Runtime,
    seen: u64,
    stall_watch: StallWatch,
    stranded: Option<(Fault, u64)>,
    folder: Folder,
    _janitor: Janitor,
}

impl Stage {
    /// Builds the world, and starts devices and mediator; robots follow as their times come.
    ///
    /// # Errors
    /// [`Failure::Refused`] naming what is wrong or not available.
    pub fn set(scenario: &Scenario, options: &Options) -> Result<Self, Failure> {
        if !scenario.faults.is_empty() {
            return Err(Failure::refused(
                "the scenario has `faults`, which happen on the simulated clock only: add --stepped",
            ));
        }
        make_folder(&options.out)?;
        let folder = Folder::new()?;
        let janitor = Janitor::start(&options.program, folder.path()).map_err(Failure::refused)?;
        let site = &scenario.site;
        let site_file = if options.nets {
            scenario.site_file.clone()
        } else {
            without_nets(&scenario.site_file, folder.path())?
        };
        let robots = drawn_starts(scenario, options.seed);
        let world = world(site, &robots, options.seed)?;
        if let Some(clutter) = &scenario.clutter {
            furnish(&mut world.lock(), clutter, options.seed).map_err(Failure::refused)?;
        }
        let links =
            Links::new(&site.name, options.secure, folder.path()).map_err(Failure::refused)?;
        let listener = { links.listener(site, &scenario.nets) }.map_err(Failure::refused)?;
        let runtime = Runtime::new(Some(folder.path().join("run")))?;
        let wanted = options.mediator && site.areas_managed;
        if options.secure && !wanted {
            let why = "--secure is for sites with a mediator, with which robots have certificates";
            return Err(Failure::refused(why));
        }
        if wanted && !scenario.set.is_empty() {
            let why = "`set` cannot be used with a mediator, which reads the site file itself";
            return Err(Failure::refused(why));
        }
        let mediator = wanted.then(|| {
            MediatorProcess::start(MediatorSetup {
                program: options.program.clone(),
                site_file: site_file.clone(),
                site: site.name.clone(),
                journal: folder.path().join("journal.redb"),
                key_prefix: links.key_prefix.clone(),
                listen: links.mediator.clone(),
                connect: { listener.as_ref() }.map(|listener| listener.endpoint().to_owned()),
                keys: links.keys(),
                runtime: folder.path().join("mediator"),
                log: options.out.join("mediator.log"),
            })
        });
        let mediator = mediator.transpose().map_err(|error| {
            Failure::refused(format_args!("the mediator cannot be started: {error}"))
        })?;
        let watch = { mediator.as_ref() }
            .map(|mediator| {
                let socket = mediator.socket()?;
                MediatorWatch::start(socket).map_err(|error| error.to_string())
            })
            .transpose()
            .map_err(Failure::refused)?;
        let listener =
            listener.map_or_else(|| links.listener_through_mediator(site, &scenario.nets), Ok);
        let listener = listener.map_err(Failure::refused)?;
        let start_ns = monotonic_ns();
        let delays_ns = start_delays_ns(scenario, options.seed);
        let mut members = Vec::new();
        for (number, player) in scenario.robots.iter().enumerate() {
            let lidar_link = folder.path().join(format!("lidar-{}", player.id));
            let any_port = BusPlace::Udp(([127, 0, 0, 1], 0).into());
            let seed = options.seed.wrapping_add(1_000_003 * number as u64);
            let link = Some(lidar_link.clone());
            let devices = Devices::start(&world, &player.config, &any_port, link, seed)?;
            devices
                .drive
                .set_encoders_ahead(player.encoders_ahead_rad());
            let mut set = scenario.set_of(player);
            let mut peers = vec![listener.endpoint()];
            if site.areas_managed && !peers.contains(&links.mediator.as_str()) {
                peers.push(&links.mediator);
            }
            set.extend(settings(&devices, &lidar_link, &peers, &links.key_prefix)?);
            set.extend(links.robot(&player.id).map_err(Failure::refused)?);
            set.push("fleet.listen=[]".to_owned());
            members.push(Member {
                process: None,
                devices,
                usage: Usage::of(0),
                setup: RobotSetup {
                    program: options.robot(),
                    id: player.id.clone(),
                    robot_file: player.file.clone(),
                    site_file: site_file.clone(),
                    set,
                    runtime: folder.path().join("run"),
                    log: options.out.join(format!("{}.log", player.id)),
                    environment: Vec::new(),
                },
                start_at_ns: start_ns + delays_ns[number],
                started: false,
                ends_on_purpose: false,
                insight: None,
                caretaker: Caretaker::default(),
                symbols: Json::Null,
            });
        }
        Ok(Self {
            members,
            mediator,
            watch,
            players: scenario.robots.clone(),
            managed: site.areas_managed,
            world,
            listener,
            links,
            start_ns,
            runtime,
            seen: 0,
            stall_watch: StallWatch::start().map_err(Failure::refused)?,
            stranded: None,
            folder,
            _janitor: janitor,
        })
    }

    /// Where the run has what it needs: the site's keys and the robots' files with `secure`.
    #[must_use]
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Plays the operator: resets robots that latched because the machine stalled, and notes one that latched otherwise.
    fn look_after(&mut self) {
        let (place, now_ns) = (self.runtime.place(), monotonic_ns());
        let stalled = |from_ns, to_ns| self.stall_watch.stalled(from_ns, to_ns);
        for (number, member) in self.members.iter_mut().enumerate() {
            let faults = member.faults(&place);
            match member.care(&faults, now_ns, Blame::Stalls(&stalled)) {
                Care::None => {}
                Care::Reset => {
                    let world = self.world.lock().snapshot();
                    for word in words(&faults, &world, number, None) {
                        // One that does not answer is asked again later.
                        let _ = ctl::send(&self.runtime, Some(member.id()), &word);
                    }
                }
                Care::GiveUp(fault) => self.stranded = Some((fault, faults.state(fault).since_ns)),
            }
        }
    }

    /// Tells all robots at once to stop, so that none waits for another to end.
    fn tell_robots_to_stop(&mut self) {
        for member in &mut self.members {
            if let Some(process) = &mut member.process {
                process.signal(Signal::TERM);
            }
        }
    }
}

impl Execution for Stage {
    fn start_ns(&self) -> u64 {
        self.start_ns
    }

    fn now_ns(&self) -> u64 {
        monotonic_ns()
    }

    fn pass_time(&mut self) -> Result<(), Failure> {
        std::thread::sleep(Duration::from_nanos(LOOK_NS));
        let now_ns = monotonic_ns();
        for member in &mut self.members {
            if !member.started && now_ns >= member.start_at_ns {
                member.start()?;
            }
            member.usage.look();
        }
        if let Some(mediator) = &mut self.mediator {
            mediator.usage.look();
        }
        self.look_after();
        Ok(())
    }

    fn ended(&mut self) -> Option<Ending> {
        for member in &mut self.members {
            if let Some(status) = member.poll()
                && !member.ends_on_purpose
            {
                return Some(Ending::RobotEnded(member.id().to_owned(), status));
            }
        }
        if let Some((fault, since_ns)) = self.stranded {
            return Some(Ending::Stranded(fault.name(), since_ns));
        }
        let status = self.mediator.as_mut()?.poll()?;
        Some(Ending::MediatorEnded(status))
    }

    fn truths(&mut self) -> Vec<TruthRecord> {
        let mut world = self.world.lock();
        world.advance_to(monotonic_ns());
        let truths = world.log().since(self.seen).copied().collect();
        self.seen = world.log().next_sequence();
        truths
    }

    fn belief(&mut self, robot: usize) -> Option<Belief> {
        let insight = self.members.get_mut(robot)?.insight(&self.runtime.place());
        insight.map(Insight::look)
    }

    fn show<R>(&self, to: impl FnOnce(&World, &Observations) -> R) -> R {
        // Simulated buses wait for the lock: a judge that is preempted while it holds it costs them frames.
        let world = self.world.lock().snapshot();
        to(&world, &self.listener.observations())
    }

    fn heard<R>(&self, to: impl FnOnce(&Observations) -> R) -> R {
        to(&self.listener.observations())
    }

    fn told<R>(&self, to: impl FnOnce(Option<&Told>) -> R) -> R {
        match &self.watch {
            Some(watch) => to(Some(&watch.told())),
            None => to(None),
        }
    }

    fn hears_grants(&self) -> bool {
        self.managed
    }

    fn instruct(&mut self, robot: usize, instruction: &Instruction<String>) -> Result<(), String> {
        match self.members.get(robot) {
            Some(member) => send(&self.runtime, member.id(), instruction),
            None => Err("there is no such robot".to_owned()),
        }
    }

    fn give_leave(&mut self, _robot: usize, _areas: &[bool]) -> bool {
        false
    }

    fn stop(&mut self) -> Vec<Found> {
        let mut found = Vec::new();
        // Before they end: afterwards there is nothing to look into.
        for member in &mut self.members {
            let symbols = inspect::snapshot(&self.runtime, &member.setup.id);
            member.symbols = symbols.unwrap_or(Json::Null);
            member.insight = None;
        }
        let ended: Vec<bool> = { self.members.iter_mut() }
            .map(|member| member.poll().is_some())
            .collect();
        self.tell_robots_to_stop();
        for (member, by_itself) in self.members.iter_mut().zip(ended) {
            let id = member.id().to_owned();
            let Some(process) = &mut member.process else {
                continue;
            };
            let status = process.stop();
            if !member.ends_on_purpose && (by_itself || !status.success()) {
                let how = if by_itself { " by itself" } else { "" };
                let detail = format!("the robot ended{how} with {status}, expected success");
                found.push((ViolationKind::RobotEnd, id, detail));
            }
        }
        for (member, player) in self.members.iter().zip(&self.players) {
            let statistics = member.devices.drive.statistics();
            for (kind, detail) in device_violations(&player.config, &statistics) {
                found.push((kind, player.id.clone(), detail));
            }
        }
        if let Some(mediator) = &mut self.mediator {
            let ended = mediator.poll();
            if let Some(status) = mediator.stop()
                && (ended.is_some() || !status.success())
            {
                let detail = format!("the mediator ended with {status}, expected success");
                found.push((ViolationKind::MediatorEnd, "mediator".to_owned(), detail));
            }
        }
        found
    }

    fn robot_summary(&self, robot: usize, truth: Option<&Truth>) -> RobotSummary {
        let (member, player) = (&self.members[robot], &self.players[robot]);
        let observations = self.listener.observations();
        let faults = { observations.said(&player.id) }.map(|said| said.state.faults.clone());
        RobotSummary {
            faults: { faults.into_iter().flatten() }
                .filter(|fault| fault.count > 0)
                .map(|fault| (fault.name, fault.count))
                .collect(),
            rss_mib: Some(round(member.usage.largest_rss_mib())),
            cpu_percent: Some(round(member.usage.cpu_percent())),
            resets: member.caretaker.resets,
            ..robot_summary(
                &player.config,
                &member.devices.drive.statistics(),
                truth,
                &member.symbols,
            )
        }
    }

    fn stall_watch(&self) -> Option<&StallWatch> {
        Some(&self.stall_watch)
    }

    fn mediator(&self) -> Option<MediatorRuns> {
        let mediator = self.mediator.as_ref()?;
        let spans_ns = mediator.spans_ns().to_vec();
        Some(MediatorRuns {
            summary: MediatorSummary {
                starts: u32::try_from(spans_ns.len()).unwrap_or(u32::MAX),
                dropped: None,
                rss_mib: Some(round(mediator.usage.largest_rss_mib())),
                cpu_percent: Some(round(mediator.usage.cpu_percent())),
            },
            spans_ns,
        })
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        self.tell_robots_to_stop();
    }
}
