//! One robot's activities on a simulated clock.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use coordination::fsm::Machine;
use coordination::symbols::{Reader, SymbolTable, Writer};
use description::areas::AreaIndex;
use description::threads::{ActivityKind, ThreadConfig, Trigger};
use onboard::activities::communication::{self, OpenSession};
use onboard::activities::news::Alarm;
use onboard::activities::port::Port;
use onboard::activities::robot_activity::ThreadActivities;
use onboard::cli::{Failure, Files};
use onboard::composition::compose::{
    by_thread, compose_chain, compose_communication, membership, port,
};
use onboard::composition::plan::Plan;
use onboard::process::ctl::{Pending, Request};
use onboard::process::overruns::OverrunWatch;
use onboard::process::reload::Reload;
use onboard::process::runtime::Runtime;
use onboard::process::supervisor::{PERIOD_NS, Supervisor, ports};
use onboard::realtime::log;
use onboard::symbols::faults::FaultTable;
use onboard::symbols::values::{Name, RobotMode, ThreadReport};
use onboard::symbols::wiring::Wiring;
use sim::world::{Random, World};

use super::drive::SteppedDrive;
use super::leave::Leave;
use super::lidar::SteppedLidar;
use crate::belief::{Belief, Insight};

const MILLISECOND_NS: u64 = 1_000_000;
/// Phases of the threads come from the seed.
const PHASE_STREAM: u64 = 0x5048_4153;

/// Who says where the robot may be.
pub enum Fleet {
    /// The mediator, where there is one, over a session on the simulated network.
    Network(OpenSession),
    /// The rig, in communication's place; at first nowhere.
    Rig,
    /// Nobody: it may be anywhere, and talks with nobody.
    Alone,
}

/// A start of a robot's process.
pub struct Start {
    /// Who says where the robot may be.
    pub fleet: Fleet,
    /// Tells this start from others.
    pub boot_epoch: u64,
    /// When.
    pub at_ns: u64,
}

/// When the activities of one thread run.
enum Clock {
    Period {
        period_ns: u64,
        next_ns: u64,
    },
    Scan {
        at_least_ns: u64,
        next_ns: u64,
    },
    /// On news, and with a period of its own.
    News {
        period_ns: u64,
        next_ns: u64,
        alarm: Alarm,
        woken: u32,
    },
}

struct Thread {
    clock: Clock,
    activities: ThreadActivities,
}

/// One robot.
pub struct SteppedRobot {
    drive: SteppedDrive,
    lidar: SteppedLidar,
    threads: Vec<Thread>,
    supervisor: Supervisor,
    supervisor_next_ns: u64,
    machine: Machine,
    requests: VecDeque<Request>,
    refused: Arc<Mutex<Vec<String>>>,
    insight: Insight,
    leave: Option<Leave>,
    // What nothing reads or writes here, and the shared memory itself.
    _idle: Idle,
}

/// Ends of symbols that have no user, kept until the robot ends.
struct Idle {
    _ports: Vec<(ActivityKind, Port)>,
    _threads: Vec<(Writer<ThreadReport>, Reader<ThreadReport>)>,
    _table: SymbolTable,
}

impl SteppedRobot {
    /// Composes the robot of a plan as number `robot` of `world`. Its symbols live in `folder`, which must be its own.
    ///
    /// # Errors
    /// [`Failure::Refused`] when a part cannot be built.
    pub fn new(
        plan: &Plan,
        files: &Files,
        folder: &Path,
        world: &World,
        robot: usize,
        start: Start,
    ) -> Result<Self, Failure> {
        let Start {
            fleet,
            boot_epoch,
            at_ns: now_ns,
        } = start;
        let runtime = Runtime::new(Some(folder.to_owned()))?;
        let id = &plan.robot.identity.id;
        let wiring = Wiring::build(id, &runtime.place(), &[]).map_err(Failure::refused)?;
        let mut random = Random::new(world.seed(), PHASE_STREAM + robot as u64);
        let (reload, ends) = Reload::new(files.clone(), plan);
        let (mut ports, mut handles) = ports(wiring.states);
        let symbols = wiring.symbols;
        let navigator = Box::new(plan.navigator().map_err(Failure::refused)?);
        let machine = navigator.machine().clone();
        let (alarm, (log, drain)) = (Alarm::default(), log::queue());
        let (navigation_end, membership, open_session, leave) = match fleet {
            Fleet::Network(open_session) => {
                let (navigation, own) = membership(plan, &navigator, boot_epoch, &alarm).unzip();
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
            navigator,
            symbols.chain,
            &mut ports,
            ends,
            navigation_end,
        )
        .map_err(Failure::refused)?;
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
        let activities = by_thread(plan, activities, wiring.scans).map_err(Failure::refused)?;
        let threads = { plan.robot.threads.iter().zip(activities) }
            .filter_map(|(table, own)| stepped_thread(table, own, &mut random, &alarm, now_ns))
            .collect();
        let lidar_settings = plan.lidar_settings().map_err(Failure::refused)?;
        let mode = RobotMode {
            mode: 0,
            boot_epoch,
            pid: 0,
            robot: Name::new(id),
        };
        let mut supervisor = Supervisor::new(
            handles,
            symbols.supervisor,
            mode,
            // Nothing is late here.
            OverrunWatch::new(Vec::new()),
            machine.clone(),
            drain,
            reload,
        );
        supervisor.begin();
        Ok(Self {
            drive: SteppedDrive::new(robot, plan.drive_settings(), symbols.drive),
            lidar: SteppedLidar::new(world, robot, lidar_settings, symbols.lidar, now_ns),
            threads,
            supervisor,
            supervisor_next_ns: now_ns,
            machine,
            requests: VecDeque::new(),
            refused: Arc::default(),
            leave,
            insight: Insight::open(id, &runtime.place()).map_err(Failure::refused)?,
            _idle: Idle {
                _ports: ports,
                _threads: wiring.threads,
                _table: wiring.table,
            },
        })
    }

    /// Everything that is due at `now_ns`, which advances by a millisecond each time: bus, motion, scan, navigation, messages.
    pub fn step(&mut self, world: &mut World, now_ns: u64) {
        if let Some(leave) = &mut self.leave {
            leave.cycle(now_ns);
        }
        self.drive.cycle(world, now_ns);
        let scanned = self.lidar.cycle(world, now_ns);
        for thread in &mut self.threads {
            if thread.clock.is_due(now_ns, scanned) {
                thread.activities.step(|| now_ns);
            }
        }
        if now_ns >= self.supervisor_next_ns {
            self.supervisor_next_ns = now_ns + PERIOD_NS;
            let (requests, refused) = (&mut self.requests, &self.refused);
            // One at a time, as an operator who waits for the answer.
            let mut next = requests.pop_front();
            self.supervisor.cycle(now_ns, || {
                let request = next.take()?;
                let (name, refused) = (request.name(), Arc::clone(refused));
                Some(Pending::new(request, move |reply| {
                    if let Err(why) = reply {
                        let mut all = refused.lock().unwrap_or_else(PoisonError::into_inner);
                        all.push(format!("{name}: {why}"));
                    }
                }))
            });
        }
    }

    /// What it believes.
    pub fn belief(&mut self) -> Belief {
        self.insight.look()
    }

    /// The faults that it has had, and has.
    pub fn faults(&mut self) -> FaultTable {
        self.insight.faults()
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

    /// A request of an operator, which the supervisor serves when it looks next.
    pub fn ask(&mut self, request: Request) {
        self.requests.push_back(request);
    }

    /// What operators were refused.
    #[must_use]
    pub fn refused(&self) -> Vec<String> {
        self.refused
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }
}

impl Clock {
    fn is_due(&mut self, now_ns: u64, scanned: bool) -> bool {
        match self {
            Self::Period { period_ns, next_ns } => {
                let due = now_ns >= *next_ns;
                if due {
                    // Periods that were missed are not made up for.
                    *next_ns = (*next_ns + *period_ns).max(now_ns);
                }
                due
            }
            Self::Scan {
                at_least_ns,
                next_ns,
            } => {
                let due = scanned || now_ns >= *next_ns;
                if due {
                    *next_ns = now_ns + *at_least_ns;
                }
                due
            }
            Self::News {
                period_ns,
                next_ns,
                alarm,
                woken,
            } => {
                let count = alarm.wake.count();
                let told = alarm.news.take().is_some() || std::mem::replace(woken, count) != count;
                let ticked = now_ns >= *next_ns;
                if ticked {
                    *next_ns = (*next_ns + *period_ns).max(now_ns);
                }
                told || ticked
            }
        }
    }
}

/// A thread of the robot file with those of its activities that run here, or `None` without any.
fn stepped_thread(
    thread: &ThreadConfig,
    activities: ThreadActivities,
    random: &mut Random,
    alarm: &Alarm,
    now_ns: u64,
) -> Option<Thread> {
    let mut phase_ns = |period_ns: u64| {
        let slots = (period_ns / MILLISECOND_NS).max(1);
        now_ns + (random.unit() * slots as f64) as u64 * MILLISECOND_NS
    };
    let ns = |duration: std::time::Duration| u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX);
    let clock = match thread.trigger {
        _ if activities.is_empty() => return None,
        Trigger::Period { period } => Clock::Period {
            period_ns: ns(period),
            next_ns: phase_ns(ns(period)),
        },
        Trigger::Scan { at_least } => Clock::Scan {
            at_least_ns: ns(at_least),
            next_ns: phase_ns(ns(at_least)),
        },
        Trigger::Async => Clock::News {
            period_ns: ns(communication::PERIOD),
            next_ns: phase_ns(ns(communication::PERIOD)),
            alarm: alarm.clone(),
            woken: alarm.wake.count(),
        },
        // The lidar's own thread: a stand-in runs in its place.
        Trigger::Lidar => return None,
    };
    Some(Thread { clock, activities })
}
