//! One robot's activities on a simulated clock.

use std::path::Path;
use std::sync::Arc;

use coordination::fsm::Machine;
use coordination::symbols::SymbolTable;
use description::areas::AreaIndex;
use description::threads::ActivityKind;
use onboard::activities::news::Alarm;
use onboard::activities::port::Port;
use onboard::cli::{Failure, Files};
use onboard::composition::beginning::Beginning;
use onboard::composition::compose::{
    by_thread, compose_chain, compose_communication, compose_devices, membership, port,
};
use onboard::composition::plan::{Plan, thread_names};
use onboard::process::checkpoints::Left;
use onboard::process::inspect::snapshot;
use onboard::process::overruns::OverrunWatch;
use onboard::process::reload::Reload;
use onboard::process::runner::Trigger;
use onboard::process::runtime::Runtime;
use onboard::process::supervisor::{Keeper, PERIOD_NS, Supervisor, ports};
use onboard::realtime::log;
use onboard::realtime::wake::Wake;
use onboard::symbols::values::{Name, RobotMode};
use onboard::symbols::wiring::Wiring;
use serde_json::Value as Json;
use sim::world::Random;

use super::checkpoints::Checkpoints;
use super::clock::{OwnClock, shown_ns};
use super::desk::SteppedDesk;
use super::devices::Devices;
use super::faults::below;
use super::late::Late;
use super::late::Lateness;
use super::leave::Leave;
use super::panics::Ends;
use super::requests::Requests;
use super::running::{Running, phase_ns};
use super::start::{Fleet, Start};
use super::thread::{Step, ThreadClock};
use super::work::measured;
use crate::belief::Insight;
use crate::scenario::SUPERVISOR;

/// Phases of the threads come from the seed.
const PHASE_STREAM: u64 = 0x5048_4153;

/// What hangs the desk of who drives by hand.
const DESK: &str = "teleop";

/// One robot.
pub struct SteppedRobot {
    threads: Vec<Running>,
    supervisor: Supervisor,
    supervisor_next_ns: u64,
    supervisor_late: Late,
    /// As the thread that keeps checkpoints has them.
    kept: Checkpoints,
    machine: Machine,
    /// What operators ask of it.
    pub(super) requests: Requests,
    desk: SteppedDesk,
    insight: Insight,
    id: String,
    runtime: Runtime,
    leave: Option<Leave>,
    /// How its threads are late.
    late: Vec<Lateness>,
    /// Threads that hang.
    hung: Vec<String>,
    random: Random,
    clock: OwnClock,
    /// How its process ends after a panic, or when it is told to.
    ends: Ends,
    // The shared memory itself, and ports of what does not run here, kept until the robot ends.
    _table: SymbolTable,
    _ports: Vec<(ActivityKind, Port)>,
}

impl SteppedRobot {
    /// Composes the robot of a plan on its devices. Its symbols live in `folder`, which must be its own; phases of its threads
    /// are drawn from the number that tells this start from others.
    ///
    /// # Errors
    /// [`Failure::Refused`] when a part cannot be built.
    pub fn new(
        plan: &Plan,
        files: &Files,
        folder: &Path,
        devices: &Devices,
        start: Start,
    ) -> Result<Self, Failure> {
        let Start {
            fleet,
            boot_epoch,
            at_ns,
            ahead_ns,
            mut checkpoints,
        } = start;
        let now_ns = shown_ns(at_ns, ahead_ns);
        let runtime = Runtime::new(Some(folder.to_owned()))?;
        let id = &plan.robot.identity.id;
        let threads = &plan.robot.threads;
        let wiring = Wiring::build(id, &runtime.place(), &thread_names(&plan.robot))
            .map_err(Failure::refused)?;
        let (alarm, scan_wake, (log, drain)) = (Alarm::default(), Wake::default(), log::queue());
        let triggers = { threads.iter() }.map(|thread| Trigger::of(thread, &scan_wake));
        let triggers: Vec<Trigger> = triggers.collect();
        let mut random = Random::new(boot_epoch, PHASE_STREAM);
        let clocks: Vec<Arc<ThreadClock>> = { triggers.iter() }
            .map(|trigger| Arc::new(ThreadClock::new(now_ns + phase_ns(trigger, &mut random))))
            .collect();
        let clock_of = |kind| {
            let own = { threads.iter() }.position(|thread| thread.activities.contains(&kind));
            // The loader has checked that every activity has a thread.
            Arc::clone(&clocks[own.unwrap_or(0)])
        };
        let (reload, replacements) = Reload::new(files.clone(), plan);
        let (mut ports, mut handles) = ports(wiring.states);
        let (symbols, ends) = (wiring.symbols, Ends::default());
        let left = Left::take(&mut checkpoints, plan, &log, now_ns)?;
        let kept = checkpoints.clone();
        let keeper = Keeper::new(Box::new(checkpoints), plan, &left);
        let beginning = Beginning::of(plan, left.place.as_deref(), left.began(), &log);
        let beginning = beginning.map_err(Failure::refused)?;
        let (navigator, began) = (&beginning.navigator, beginning.began.clone());
        let (machine, goes_on) = (navigator.machine().clone(), beginning.left.is_some());
        let (navigation_end, membership, open_session, leave) = match fleet {
            Fleet::Network(open_session) => {
                let own = membership(plan, navigator, (boot_epoch, began), &alarm);
                let (navigation, own) = own.unzip();
                let ends = (symbols.communication, symbols.communication_fleet);
                (navigation, own, Some((open_session, ends)), None)
            }
            Fleet::Rig => {
                let (leave, end) = Leave::new(symbols.communication_fleet.allowed);
                (Some(end), None, None, Some(leave))
            }
            Fleet::Alone => (None, None, None, None),
        };
        let mut activities = compose_chain(
            plan,
            beginning,
            symbols.chain,
            &mut ports,
            replacements,
            navigation_end,
        )
        .map_err(Failure::refused)?;
        let of_devices = (symbols.drive, symbols.lidar);
        let ways = devices.ways(plan, clock_of)?;
        let with_devices = compose_devices(
            plan,
            of_devices,
            &mut ports,
            ways,
            goes_on,
            &scan_wake,
            (&log, &ends.panicked),
        );
        activities.extend(with_devices.map_err(Failure::refused)?);
        if let Some((open_session, symbols)) = open_session {
            let communication = compose_communication(
                plan.communication_settings(boot_epoch),
                port(&mut ports, ActivityKind::Communication),
                symbols,
                membership,
                open_session,
                (&log, &alarm),
                now_ns,
            );
            activities.push((ActivityKind::Communication, Box::new(communication)));
        }
        handles.retain(|handle| activities.iter().any(|(kind, _)| *kind == handle.kind));
        let activities = measured(activities, &scan_wake);
        let activities = by_thread(plan, activities, wiring.scans).map_err(Failure::refused)?;
        let (reports, watched): (Vec<_>, Vec<_>) = wiring.threads.into_iter().unzip();
        let running = { threads.iter().zip(triggers).zip(clocks) }
            .zip(activities.into_iter().zip(reports))
            .filter(|(_, (activities, _))| !activities.is_empty())
            .map(|(((thread, trigger), clock), (activities, report))| {
                let parts = (activities, report);
                let told = (&alarm, &ends.panicked);
                Running::new(thread, (trigger, clock), parts, told, boot_epoch)
            })
            .collect();
        let mode = RobotMode {
            mode: 0,
            halt: 0,
            lost: 0,
            teleop: 0,
            boot_epoch,
            pid: 0,
            robot: Name::new(id),
        };
        let mut supervisor = Supervisor::new(
            handles,
            symbols.supervisor,
            mode,
            OverrunWatch::of(&plan.robot, watched),
            machine.clone(),
            drain,
            (reload.waiting(), keeper),
        )
        .heeding(ends.panicked.clone());
        supervisor.heed(&left, now_ns);
        supervisor.begin();
        Ok(Self {
            threads: running,
            supervisor,
            supervisor_next_ns: now_ns,
            kept,
            supervisor_late: Late::new(boot_epoch),
            machine,
            requests: Requests::default(),
            desk: SteppedDesk::new(symbols.teleop),
            leave,
            late: Vec::new(),
            hung: Vec::new(),
            random,
            clock: OwnClock::new(ahead_ns, at_ns),
            ends,
            insight: Insight::open(id, &runtime.place()).map_err(Failure::refused)?,
            id: id.clone(),
            runtime,
            _table: wiring.table,
            _ports: ports,
        })
    }

    /// From now on its threads are late in these ways.
    pub fn be_late(&mut self, lateness: Vec<Lateness>) {
        self.late = lateness;
    }

    /// From now on these of its threads do not run; `supervisor` is the main one.
    pub fn hang(&mut self, threads: &[&str]) {
        self.hung = threads.iter().map(|&name| name.to_owned()).collect();
    }

    /// From now on its computer sleeps, or is awake.
    pub fn sleep(&mut self, sleeps: bool) {
        self.clock.sleep(sleeps);
    }

    /// This of its threads panics when it has ended its present turn; `supervisor` is the main one.
    pub fn panic(&mut self, thread: &str) {
        if thread == SUPERVISOR {
            self.ends.lose_supervisor(self.clock.now_ns());
        }
        for own in self.threads.iter_mut().filter(|own| own.name == thread) {
            own.panic(&self.ends.panicked);
        }
    }

    /// From now on a reload reads these files.
    pub fn reload_from(&mut self, files: Files) {
        self.supervisor.reload_from(files);
    }

    /// Whether its process has ended, after a panic or because it was told to.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.ends.over
    }

    /// Its process is told to end.
    pub fn tell_to_end(&mut self) {
        self.ends.told = true;
    }

    /// How its process ends after a panic, or when it is told to.
    pub(super) fn ends(&mut self) -> &mut Ends {
        &mut self.ends
    }

    /// Its computer's clock, which outlives its process.
    pub(super) fn clock(&mut self) -> &mut OwnClock {
        &mut self.clock
    }

    /// Everything that is due in the step that begins at `world_ns`.
    pub fn step(&mut self, world_ns: u64) {
        let Some(step) = self.begin(world_ns) else {
            return;
        };
        let now_ns = step.begin_ns;
        self.run_threads(step, usize::MAX);
        self.kept.attend(now_ns);
        let hangs = self.hung.iter().any(|name| name == SUPERVISOR);
        let supervised = !self.ends.is_unsupervised(now_ns) && !hangs;
        if !supervised && self.ends.over {
            self.supervisor.keep_stopped(now_ns);
        }
        let due = supervised && now_ns >= self.supervisor_next_ns;
        let late = (&self.late[..], SUPERVISOR);
        if self.supervisor_late.runs(due, late, now_ns) {
            self.supervisor_next_ns = now_ns + PERIOD_NS;
            if self.ends.stops(&mut self.supervisor, now_ns) {
                return;
            }
            let lent = || self.desk.lent();
            let (requests, slept_ns) = (&mut self.requests, self.clock.slept_ns());
            self.supervisor
                .heed_sleep(slept_ns, || requests.next(lent()), now_ns);
            // One at a time, as people are not faster.
            let mut next = self.requests.next(lent());
            if self.supervisor.turn(now_ns, self.ends.told, || next.take()) {
                self.ends.stop(&mut self.supervisor, now_ns);
            }
        }
    }

    /// Its process is killed in this step: some of its threads, drawn, have had their turn.
    pub fn step_in_part(&mut self, world_ns: u64) {
        let threads = below(&mut self.random, self.threads.len() + 1);
        if let Some(step) = self.begin(world_ns) {
            self.run_threads(step, threads);
        }
    }

    fn begin(&mut self, world_ns: u64) -> Option<Step> {
        let [begin_ns, end_ns] = self.clock.step(world_ns)?;
        if let Some(leave) = &mut self.leave {
            leave.cycle(begin_ns);
        }
        if !self.hung.iter().any(|name| name == DESK) {
            self.desk.step(begin_ns);
        }
        Some(Step {
            begin_ns,
            end_ns,
            world_ns,
        })
    }

    /// The first ones go on.
    fn run_threads(&mut self, step: Step, count: usize) {
        for thread in self.threads.iter_mut().take(count) {
            if !self.hung.contains(&thread.name) {
                thread.go_on(step, &self.late, &mut self.random);
            }
        }
    }

    /// What it believes, and says of its faults and devices.
    pub fn insight(&mut self) -> &mut Insight {
        self.insight.set_ahead(self.clock.ahead_ns() as i64);
        &mut self.insight
    }

    /// What its symbols say, as `onboard inspect --json` prints it.
    #[must_use]
    pub fn symbols(&self) -> Json {
        snapshot(&self.runtime, &self.id).unwrap_or_default()
    }

    /// Gives leave for areas, in the site's order, where the rig says where the robot may be.
    pub fn allow(&mut self, granted: &[bool]) {
        let areas = AreaIndex::first(granted.len()).zip(granted);
        let areas = areas
            .filter(|(_, granted)| **granted)
            .map(|(area, _)| area)
            .collect();
        if let Some(leave) = &mut self.leave {
            leave.give(areas);
        }
    }

    /// Whether its machine has an input of this name.
    #[must_use]
    pub fn knows(&self, event: &str) -> bool {
        self.machine.input(event).is_some()
    }

    /// The desk of who drives it by hand, and who sits there.
    pub fn desk(&mut self) -> &mut SteppedDesk {
        &mut self.desk
    }

    /// Who drives it by hand leaves.
    pub fn let_go(&mut self) {
        self.desk.leave(self.clock.now_ns());
    }
}
