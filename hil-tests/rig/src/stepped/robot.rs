//! One robot's activities on a simulated clock.

use std::path::Path;

use coordination::activity::event_loop_once;
use coordination::event::EventId;
use coordination::symbols::{Reader, SymbolTable, Writer};
use description::geometry::Pose2;
use description::threads::{ActivityKind, ThreadConfig, Trigger};
use onboard::activities::control::Control;
use onboard::activities::fleet_link::NavigationEnd;
use onboard::activities::motion_tube::MotionTube;
use onboard::activities::navigation::Navigation;
use onboard::activities::port::Command;
use onboard::activities::proprioception::Proprioception;
use onboard::activities::robot_activity::RobotActivity;
use onboard::activities::scans::ScanIntake;
use onboard::cli::Files;
use onboard::composition::plan::{Plan, PlanError, ns_from_ms};
use onboard::composition::replacement::ReloadEnds;
use onboard::process::reload::Reload;
use onboard::process::runtime::Runtime;
use onboard::symbols::values::{ActivityState, ThreadReport};
use onboard::symbols::wiring::{
    ACTIVITIES, ControlSymbols, MotionTubeSymbols, NavigationFleetSymbols, NavigationSymbols,
    ProprioceptionSymbols, Wiring,
};
use sim::world::{Random, World};
use skills::borders::AreaSet;

use super::drive::SteppedDrive;
use super::leave::Leave;
use super::lidar::SteppedLidar;
use super::supervisor::{Note, Supervisor};
use crate::belief::{Belief, Insight};
use crate::stand_ins::operator::Instruction;
use onboard::cli::Failure;

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

/// Activities with their names in the thread table.
type Activities = Vec<(ActivityKind, Box<dyn RobotActivity>)>;

struct Thread {
    clock: Clock,
    activities: Vec<Box<dyn RobotActivity>>,
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
    // The external events of its machine.
    events: Vec<(String, EventId)>,
    leave: Option<Leave>,
    // What nothing reads or writes here, and the shared memory itself.
    _idle: Idle,
}

/// Ends of symbols that have no user, kept until the robot ends.
struct Idle {
    _states: Vec<Writer<ActivityState>>,
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
        let mut supervisor = Supervisor::default();
        let (reload, ends) = Reload::new(files.clone(), plan);
        let mut states: Vec<_> = ACTIVITIES.into_iter().zip(wiring.states).collect();
        let mut events = Vec::new();
        let (leave, end) = takes_leave
            .then(|| Leave::new(wiring.communication_fleet.allowed))
            .unzip();
        let mut activities = compose(
            plan,
            &mut supervisor,
            &mut states,
            &mut events,
            ends,
            Ends {
                proprioception: wiring.proprioception,
                navigation: wiring.navigation,
                managed: end.map(|end| (wiring.navigation_fleet, end)),
                motion_tube: wiring.motion_tube,
                control: wiring.control,
            },
        )
        .map_err(Failure::refused)?;
        let threads = plan
            .robot
            .threads
            .iter()
            .filter_map(|thread| stepped_thread(thread, &mut activities, &mut random, now_ns))
            .collect();
        supervisor.configure();
        let lidar_settings = plan.lidar_settings().map_err(Failure::refused)?;
        Ok(Self {
            drive: SteppedDrive::new(robot, plan.drive_settings(), wiring.drive),
            lidar: SteppedLidar::new(world, robot, lidar_settings, wiring.lidar, now_ns),
            threads,
            supervisor,
            supervisor_next_ns: now_ns,
            notes: Vec::new(),
            events,
            leave,
            insight: Insight::open(id, &runtime.place()).map_err(Failure::refused)?,
            _idle: Idle {
                _states: states.into_iter().map(|(_, state)| state).collect(),
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
                for activity in &mut thread.activities {
                    event_loop_once(activity.as_mut(), now_ns);
                }
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
        let mut areas = AreaSet::EMPTY;
        for (index, _) in granted.iter().enumerate().filter(|(_, granted)| **granted) {
            areas.insert(index);
        }
        if let Some(leave) = &mut self.leave {
            leave.give(areas);
        }
    }

    /// Gives its machine an event with parameters; false when the machine does not know it.
    pub fn instruct(&mut self, instruction: &Instruction) -> bool {
        let known = self
            .events
            .iter()
            .find(|(name, _)| *name == instruction.event);
        let Some((_, event)) = known else {
            return false;
        };
        let command = Command::Instruct(skills::navigator::Instruction {
            event: *event,
            speed_limit_m_s: instruction.speed_limit_m_s,
            stop_at: instruction
                .stop_at
                .map(|pose| Pose2::new(pose.x_m, pose.y_m, pose.theta_rad)),
        });
        self.supervisor.tell(ActivityKind::Navigation, command);
        true
    }

    /// A command of an operator or of the supervisor.
    pub fn tell(&mut self, activity: ActivityKind, command: Command) {
        self.supervisor.tell(activity, command);
    }

    /// What its activities have reported since the last call, with the time it was heard.
    pub fn take_notes(&mut self) -> Vec<(u64, Note)> {
        std::mem::take(&mut self.notes)
    }

    /// Commands that were lost because a queue was full; none are.
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
    activities: &mut Activities,
    random: &mut Random,
    now_ns: u64,
) -> Option<Thread> {
    let mut mine = Vec::new();
    for kind in &thread.activities {
        if let Some(index) = activities.iter().position(|(other, _)| other == kind) {
            mine.push(activities.swap_remove(index).1);
        }
    }
    let phase_ns = |random: &mut Random, period_ns: u64| {
        let slots = (period_ns / MILLISECOND_NS).max(1);
        now_ns + (random.unit() * slots as f64) as u64 * MILLISECOND_NS
    };
    let clock = match thread.trigger {
        _ if mine.is_empty() => return None,
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
    Some(Thread {
        clock,
        activities: mine,
    })
}

/// Ends of the symbols of the activities that run here.
struct Ends {
    proprioception: ProprioceptionSymbols,
    navigation: NavigationSymbols,
    /// Where leave is withheld.
    managed: Option<(NavigationFleetSymbols, NavigationEnd)>,
    motion_tube: MotionTubeSymbols,
    control: ControlSymbols,
}

/// The robot's own activities, of its own parts.
fn compose(
    plan: &Plan,
    supervisor: &mut Supervisor,
    states: &mut Vec<(ActivityKind, Writer<ActivityState>)>,
    events: &mut Vec<(String, EventId)>,
    reload: ReloadEnds,
    ends: Ends,
) -> Result<Activities, PlanError> {
    let mut port = |kind: ActivityKind| {
        let index = states.iter().position(|(own, _)| *own == kind);
        let (_, state) = states.swap_remove(index.expect("every activity has a state symbol"));
        supervisor.port(kind, state)
    };
    let intake = || {
        ScanIntake::new(plan.scan_geometry()?).map_err(|error| PlanError::Lidar(error.to_string()))
    };
    let command_timeout_ns = ns_from_ms(plan.robot.control.command_timeout_ms);
    let navigator = Box::new(plan.navigator()?);
    let start = plan.start(navigator.machine().state());
    for name in &plan.fsm.external {
        events.extend(
            navigator
                .machine()
                .input(name)
                .map(|event| (name.clone(), event)),
        );
    }
    let names = navigator
        .machine()
        .states()
        .map(|(_, name)| name.to_owned())
        .collect();
    let proprioception = Proprioception::new(
        port(ActivityKind::Proprioception),
        ends.proprioception,
        plan.dead_reckoning()?,
    );
    let mut navigation = Navigation::new(
        port(ActivityKind::Navigation),
        ends.navigation,
        intake()?,
        navigator,
        reload.navigator,
        start,
    );
    if let Some((symbols, end)) = ends.managed {
        navigation = navigation.managed(symbols, end);
    }
    let motion_tube = MotionTube::new(
        port(ActivityKind::MotionTube),
        ends.motion_tube,
        intake()?,
        Box::new(plan.motion_tubes()?),
        reload.tubes,
        command_timeout_ns,
    );
    let control = Control::new(
        port(ActivityKind::Control),
        ends.control,
        plan.wheel_controller()?,
        command_timeout_ns,
    );
    supervisor.name_states(names);
    Ok(vec![
        (ActivityKind::Proprioception, Box::new(proprioception) as _),
        (ActivityKind::Navigation, Box::new(navigation) as _),
        (ActivityKind::MotionTube, Box::new(motion_tube) as _),
        (ActivityKind::Control, Box::new(control) as _),
    ])
}
