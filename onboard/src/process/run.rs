//! `onboard run`: composes the robot and runs it until it is told to end.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::thread::JoinHandle;

use config::ProblemKind;
use contract::draw::draw;
use contract::logging::{LevelFilter, Logging, Targets};
use description::robot::Link;
use description::threads::{ActivityKind, Trigger as ConfigTrigger};

use crate::activities::communication::read_identity;
use crate::composition::checkpoint::Checkpoint;
use crate::composition::compose::compose;
use crate::composition::failure::Failure;
use crate::composition::files::Files;
use crate::composition::plan::{Plan, thread_names, wanted_scheduling};
use crate::process::asynchronous::spawn_asynchronous;
use crate::process::checkpoints::{Background, CheckpointFile, Left};
use crate::process::ctl::{Guest, Server};
use crate::process::overruns::OverrunWatch;
use crate::process::reload::Reload;
use crate::process::runner::{ThreadSetup, Trigger};
use crate::process::runtime::Runtime;
use crate::process::signals::termination_flag;
use crate::process::supervisor::{Ending, Keeper, Supervisor, UNSUPERVISED_NS, ports};
use crate::process::teleop::{self, Desk};
use crate::process::watchdogs::Watchdogs;
use crate::realtime::clock::{SECOND_NS, check_absolute_sleep, now_ns, sleep_until, slept_ns};
use crate::realtime::latency::{self, keep_cores_awake};
use crate::realtime::log::{self, LogSender};
use crate::realtime::memory::{MemoryLock, lock_memory, populate_memory};
use crate::realtime::panic::{Panicked, install_hook};
use crate::realtime::{guard, own_cores, scheduling, system_calls};
use crate::symbols::values::{Name, RobotMode};
use crate::symbols::wiring::{ACTIVITIES, Wiring};

/// How long threads may take to end.
const JOIN_NS: u64 = 5 * SECOND_NS;

/// Runs the robot.
///
/// # Errors
/// [`Failure::Refused`] when nothing was started, [`Failure::Failed`] when a part of it failed while running.
pub fn run(files: &Files, runtime: &Runtime, without_real_time: bool) -> Result<(), Failure> {
    let logging = Logging::start("ONBOARD_LOG", &logged(), || !guard::holds());
    let plan = Plan::load(files)?;
    check_absolute_sleep().map_err(Failure::refused)?;
    if !without_real_time {
        check_priority(&plan)?;
    }
    if let Some(path) = &plan.robot.fleet.keys {
        read_identity(path.as_ref(), &plan.robot.identity.id).map_err(Failure::refused)?;
    }
    check_cores(&plan)?;
    let panicked = Panicked::default();
    install_hook(&panicked);
    let asked_to_end = termination_flag().map_err(Failure::refused)?;
    let wiring = Wiring::build(
        &plan.robot.identity.id,
        &runtime.place(),
        &thread_names(&plan.robot),
    )
    .map_err(Failure::refused)?;
    let (seats, guests) = channel();
    let server = Server::open(runtime, &plan.robot.identity.id)?.seating(seats);
    let guarded = guard::arm_from_environment();
    let (log, log_drain) = log::queue();
    let log_drain = log_drain.counting(logging.unwritten());
    let locked = match lock_memory() {
        MemoryLock::Locked => true,
        MemoryLock::NotLocked(why) => {
            log.warn(why);
            false
        }
    };
    log.info(format!(
        "robot {} in site {}{}{}; {}",
        plan.robot.identity.id,
        plan.site.name,
        if guarded {
            ", allocation guard armed"
        } else {
            ""
        },
        if system_calls::wanted() {
            ", guard of system calls armed"
        } else {
            ""
        },
        plan.tube_report
            .to_string()
            .lines()
            .next()
            .unwrap_or_default()
    ));
    let awake = keep_cores_awake();
    if let (Err(error), Link::Interface(_)) = (&awake, &plan.robot.ethercat.link) {
        log.warn(format!(
            "cores may sleep deeply, and wake late: {}: {error}",
            latency::DEVICE
        ));
    }
    let mut store = CheckpointFile::of(runtime, &plan.robot.identity.id)?;
    let slept_ns = slept_ns();
    let left = Left::take(&mut store, &plan, &log, now_ns())?;
    let store = Background::of(store, Checkpoint::unattended).map_err(Failure::refused)?;
    let keeper = Keeper::new(Box::new(store), &plan, &left);
    let watchdogs = Watchdogs::start(&plan.robot.watchdog, &panicked).map_err(Failure::refused)?;
    let mut robot = Robot::start(
        files,
        plan,
        wiring,
        (left, keeper),
        (&log, log_drain, &panicked),
        (locked, guests),
    )?;
    // From before it was known where the robot is.
    robot.supervisor.heed_sleep(slept_ns, || None, now_ns());
    // A panic of the supervisor itself leaves the robot to the drive activity, which stops it.
    let ending = catch_unwind(AssertUnwindSafe(|| {
        let pulse = watchdogs.pulse();
        robot.supervisor.run(&asked_to_end, &server, pulse)
    }));
    if ending.is_err() {
        robot.supervisor.keep_stopped(now_ns());
        sleep_until(now_ns() + UNSUPERVISED_NS);
        // Where it stands now.
        robot.supervisor.keep_stopped(now_ns());
    }
    robot.end();
    // One that panicked while the robot ended already.
    robot.supervisor.log_panic();
    drop(awake);
    drop(watchdogs);
    drop(server);
    robot.clear_desk();
    if matches!(ending, Ok(Ending::Asked)) {
        robot.supervisor.arrive();
    }
    match ending {
        Ok(Ending::Asked) => Ok(()),
        Ok(Ending::Panicked) | Err(_) => Err(Failure::failed(
            "a part of the program failed; the robot was stopped, see the message above",
        )),
    }
}

/// What is logged unless `ONBOARD_LOG` says otherwise.
fn logged() -> Targets {
    Targets::new()
        .with_default(LevelFilter::INFO)
        .with_target("zenoh", LevelFilter::ERROR)
        .with_target("ethercrab", LevelFilter::WARN)
}

/// A real bus takes real-time priority for what drives: without it a robot may stop at any moment because its threads are late.
fn check_priority(plan: &Plan) -> Result<(), Failure> {
    let Link::Interface(interface) = &plan.robot.ethercat.link else {
        return Ok(());
    };
    let refused = |why: String| {
        Failure::refused(format_args!(
            "the bus on {interface} is not driven without real-time priority: {why}; `onboard doctor` shows what else, and \
             --without-real-time drives all the same"
        ))
    };
    let drives =
        |activity: &ActivityKind| matches!(activity, ActivityKind::Drive | ActivityKind::Control);
    for thread in &plan.robot.threads {
        let wanted = wanted_scheduling(thread);
        if wanted.fifo_priority.is_none() && thread.activities.iter().any(drives) {
            return Err(refused(format!(
                "found threads.{}.scheduling = \"normal\", expected \"fifo\", since it drives",
                thread.name
            )));
        }
        scheduling::try_out(&wanted).map_err(refused)?;
    }
    Ok(())
}

/// A literal core number that does not exist is an error, and only where the robot runs.
fn check_cores(plan: &Plan) -> Result<(), Failure> {
    for thread in &plan.robot.threads {
        if let Err(error) = scheduling::check_core(wanted_scheduling(thread).cores) {
            let key = format!("threads.{}.core", thread.name);
            let found = error.number.to_string();
            let expected = format!(
                "a core of this machine, one of {:?}, or any, big or little",
                error.available
            );
            let problem = plan
                .robot
                .origin
                .problem(ProblemKind::OutOfRange, &key, found, expected);
            return Err(Failure::Refused(miette::Report::new(problem)));
        }
    }
    Ok(())
}

/// A robot whose threads run.
struct Robot {
    supervisor: Supervisor,
    threads: Vec<JoinHandle<()>>,
    stop: Arc<AtomicBool>,
    desk: JoinHandle<()>,
    // Kept until all threads have ended: it holds the shared memory.
    _table: coordination::symbols::SymbolTable,
}

impl Robot {
    fn start(
        files: &Files,
        plan: Plan,
        mut wiring: Wiring,
        (left, keeper): (Left, Keeper),
        (log, log_drain, panicked): (&LogSender, log::LogDrain, &Panicked),
        (locked, guests): (bool, Receiver<Guest>),
    ) -> Result<Self, Failure> {
        let boot_epoch = draw();
        let (ports, handles) = ports(std::mem::take(&mut wiring.states));
        let threads = std::mem::take(&mut wiring.threads);
        let (reports, watched): (Vec<_>, Vec<_>) = threads.into_iter().unzip();
        let (reload, reload_ends) = Reload::new(files.clone(), &plan);
        let composed = compose(
            &plan,
            wiring,
            ports,
            (reload_ends, left.place.as_deref(), left.began()),
            boot_epoch,
            (log, panicked),
        )
        .map_err(Failure::refused)?;
        if locked && let Err(why) = populate_memory() {
            log.warn(why);
        }
        let mode = RobotMode {
            mode: 0,
            halt: 0,
            lost: 0,
            teleop: 0,
            boot_epoch,
            pid: u64::from(std::process::id()),
            robot: Name::new(&plan.robot.identity.id),
        };
        let mut supervisor = Supervisor::new(
            handles,
            composed.supervisor,
            mode,
            OverrunWatch::of(&plan.robot, watched),
            composed.machine,
            log_drain,
            (reload, keeper),
        )
        .heeding(panicked.clone());
        supervisor.heed(&left, now_ns());
        let desk = teleop::spawn(Desk::new(composed.teleop), guests).map_err(Failure::failed)?;
        let mut robot = Self {
            supervisor,
            desk,
            threads: Vec::new(),
            stop: Arc::default(),
            _table: composed.table,
        };
        let wanted: Vec<_> = plan.robot.threads.iter().map(wanted_scheduling).collect();
        let wanted = own_cores::with_own_cores(&wanted);
        let threads = plan.robot.threads.iter().zip(wanted).zip(composed.threads);
        for (((thread, wanted), activities), report) in threads.zip(reports) {
            let setup = ThreadSetup {
                name: thread.name.clone(),
                trigger: Trigger::of(thread, &composed.scan_wake),
                wanted,
                report,
                stop: Arc::clone(&robot.stop),
                log: log.clone(),
                panicked: panicked.clone(),
            };
            let spawned = if thread.trigger == ConfigTrigger::Async {
                spawn_asynchronous(setup, activities, composed.alarm.clone())
            } else {
                setup.spawn(activities)
            };
            match spawned {
                Ok(handle) => robot.threads.push(handle),
                Err(error) => {
                    robot.end();
                    let name = &thread.name;
                    return Err(Failure::failed(format_args!(
                        "thread {name} cannot be started: {error}"
                    )));
                }
            }
        }
        Ok(robot)
    }

    /// The desk of a robot that has ended is left, for want of guests.
    fn clear_desk(&self) {
        let deadline_ns = now_ns() + SECOND_NS;
        while now_ns() < deadline_ns && !self.desk.is_finished() {
            sleep_until(now_ns() + SECOND_NS / 100);
        }
    }

    /// Ends all threads; one that hangs is left behind and logged.
    fn end(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let deadline_ns = now_ns() + JOIN_NS;
        while now_ns() < deadline_ns && self.threads.iter().any(|thread| !thread.is_finished()) {
            sleep_until(now_ns() + SECOND_NS / 100);
        }
        for thread in self.threads.drain(..) {
            if thread.is_finished() {
                // A panic in it was reported by the hook.
                let _ = thread.join();
            } else {
                tracing::error!(
                    "thread {} did not end",
                    thread.thread().name().unwrap_or("?")
                );
            }
        }
    }
}

const _: () = assert!(ACTIVITIES.len() == ActivityKind::ALL.len());
