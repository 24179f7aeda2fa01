//! One robot's activities on a simulated clock.

use std::path::Path;

use coordination::symbols::{Reader, SymbolTable, Writer};
use description::areas::AreaIndex;
use description::instruction::Instruction;
use description::threads::{ActivityKind, ThreadConfig, Trigger};
use onboard::activities::port::{Command, Port};
use onboard::activities::robot_activity::ThreadActivities;
use onboard::cli::{Failure, Files};
use onboard::composition::compose::{by_thread, compose_chain};
use onboard::composition::plan::Plan;
use onboard::process::reload::Reload;
use onboard::process::runtime::Runtime;
use onboard::process::supervisor::ports;
use onboard::symbols::values::ThreadReport;
use onboard::symbols::wiring::Wiring;
use sim::world::{Random, World};

use super::drive::SteppedDrive;
use super::leave::Leave;
use super::lidar::SteppedLidar;
use super::supervisor::{Note, Supervisor};
use crate::belief::{Belief, Insight};

const MILLISECOND_NS: u64 = 1_000_000;
/// The supervisor's period.
const SUPERVISOR_NS: u64 = 100 * MILLISECOND_NS;
/// Phases of the threads come from the seed.
const PHASE_STREAM: u64 = 0x5048_4153;

/// When the activities of one thread run.
enum Clock {
    Period { period_ns: u64, next_ns: u64 },
    Scan { at_least_ns: u64, next_ns: u64 },
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
    notes: Vec<(u64, Note)>,
    insight: Insight,
    leave: Option<Leave>,
    // Ends of symbols that nothing uses here, and the shared memory itself.
    _idle: Idle,
}

/// Ends of symbols that have no user, kept until the robot ends.
struct Idle {
    _ports: Vec<(ActivityKind, Port)>,
    _threads: Vec<(Writer<ThreadReport>, Reader<ThreadReport>)>,
    _reload: Reload,
    _table: SymbolTable,
}

impl SteppedRobot {
    /// Composes the robot of a plan as number `robot` of `world`. Its symbols live in `folder`, which must be its own.
    /// It needs leave for areas when `takes_leave`, and has none at first; otherwise it has leave for all.
    ///
    /// # Errors
    /// [`Failure::Refused`] when a part cannot be built.
    pub fn new(
        plan: &Plan,
        files: &Files,
        folder: &Path,
        world: &World,
        robot: usize,
        takes_leave: bool,
        now_ns: u64,
    ) -> Result<Self, Failure> {
        let runtime = Runtime::new(Some(folder.to_owned()))?;
        let id = &plan.robot.identity.id;
        let wiring = Wiring::build(id, &runtime.place(), &[]).map_err(Failure::refused)?;
        let mut random = Random::new(world.seed(), PHASE_STREAM + robot as u64);
        let (reload, ends) = Reload::new(files.clone(), plan);
        let (mut ports, mut handles) = ports(wiring.states);
        let symbols = wiring.symbols;
        let (leave, end) = takes_leave
            .then(|| Leave::new(symbols.communication_fleet.allowed))
            .unzip();
        let navigator = Box::new(plan.navigator().map_err(Failure::refused)?);
        let machine = navigator.machine().clone();
        let chain = symbols.chain;
        let activities = compose_chain(plan, navigator, chain, &mut ports, ends, end)
            .map_err(Failure::refused)?;
        handles.retain(|handle| activities.iter().any(|(kind, _)| *kind == handle.kind));
        let activities = by_thread(plan, activities, wiring.scans).map_err(Failure::refused)?;
        let threads = { plan.robot.threads.iter().zip(activities) }
            .filter_map(|(table, own)| stepped_thread(table, own, &mut random, now_ns))
            .collect();
        let lidar_settings = plan.lidar_settings().map_err(Failure::refused)?;
        Ok(Self {
            drive: SteppedDrive::new(robot, plan.drive_settings(), symbols.drive),
            lidar: SteppedLidar::new(world, robot, lidar_settings, symbols.lidar, now_ns),
            threads,
            supervisor: Supervisor::new(handles, machine),
            supervisor_next_ns: now_ns,
            notes: Vec::new(),
            leave,
            insight: Insight::open(id, &runtime.place()).map_err(Failure::refused)?,
            _idle: Idle {
                _ports: ports,
                _threads: wiring.threads,
                _reload: reload,
                _table: wiring.table,
            },
        })
    }

    /// Everything that is due at `now_ns`, which advances by a millisecond each time: bus, motion, scan, navigation.
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
            self.supervisor_next_ns = now_ns + SUPERVISOR_NS;
            let notes = &mut self.notes;
            self.supervisor.cycle(|note| notes.push((now_ns, note)));
        }
    }

    /// What it believes.
    pub fn belief(&mut self) -> Belief {
        self.insight.look()
    }

    /// Gives leave for areas, in the site's order. Only a robot composed for it heeds that.
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

    /// Gives its machine an event with parameters; false when the machine does not know it.
    pub fn instruct(&mut self, instruction: &Instruction<String>) -> bool {
        let Some(event) = self.supervisor.event(&instruction.event) else {
            return false;
        };
        let command = Command::Instruct(instruction.with_event(event));
        self.tell(ActivityKind::Navigation, command);
        true
    }

    /// A command of an operator or of the supervisor.
    pub fn tell(&mut self, activity: ActivityKind, command: Command) {
        self.supervisor
            .tell(command, |handle| handle.kind == activity);
    }

    /// What its activities have reported since the last call, with the time it was heard.
    pub fn take_notes(&mut self) -> Vec<(u64, Note)> {
        std::mem::take(&mut self.notes)
    }

    /// Commands that were lost because a queue was full; must be 0.
    #[must_use]
    pub fn lost_commands(&self) -> u64 {
        self.supervisor.lost()
    }
}

impl Clock {
    fn is_due(&mut self, now_ns: u64, scanned: bool) -> bool {
        match self {
            Self::Period { period_ns, next_ns } => {
                let due = now_ns >= *next_ns;
                if due {
                    *next_ns += *period_ns;
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
        }
    }
}

/// A thread of the robot file with those of its activities that run here, or `None` without any.
fn stepped_thread(
    thread: &ThreadConfig,
    activities: ThreadActivities,
    random: &mut Random,
    now_ns: u64,
) -> Option<Thread> {
    let phase_ns = |random: &mut Random, period_ns: u64| {
        let slots = (period_ns / MILLISECOND_NS).max(1);
        now_ns + (random.unit() * slots as f64) as u64 * MILLISECOND_NS
    };
    let clock = match thread.trigger {
        _ if activities.is_empty() => return None,
        Trigger::Period { period } => {
            let period_ns = u64::try_from(period.as_nanos()).unwrap_or(u64::MAX);
            Clock::Period {
                period_ns,
                next_ns: phase_ns(random, period_ns),
            }
        }
        Trigger::Scan { at_least } => {
            let at_least_ns = u64::try_from(at_least.as_nanos()).unwrap_or(u64::MAX);
            Clock::Scan {
                at_least_ns,
                next_ns: phase_ns(random, at_least_ns),
            }
        }
        // The file's check leaves no other trigger to activities that run here.
        _ => return None,
    };
    Some(Thread { clock, activities })
}
