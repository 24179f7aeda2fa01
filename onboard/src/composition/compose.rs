//! Composition: the plan's parts, the symbols' ends and the ports become activities.

use std::sync::Arc;

use coordination::fsm::Machine;
use coordination::symbols::SymbolTable;
use description::robot::Link;
use description::threads::ActivityKind;
use drivers::ethercat::{Link as FrameLink, RawLink, UdpLink};
use drivers::hokuyo::TtyLine;
use skills::navigator::Navigator;

use crate::activities::communication::{
    Communication, MembershipSetup, OpenSession, Settings, zenoh_session,
};
use crate::activities::control::Control;
use crate::activities::drive::{Drive, OpenLink};
use crate::activities::fleet_link::{self, NavigationEnd};
use crate::activities::lidar::{self, Lidar, OpenLine};
use crate::activities::motion_tube::MotionTube;
use crate::activities::navigation::{Navigation, Part};
use crate::activities::news::Alarm;
use crate::activities::port::Port;
use crate::activities::proprioception::Proprioception;
use crate::activities::robot_activity::{RobotActivity, ThreadActivities};
use crate::activities::scans::ScanIntake;
use crate::composition::beginning::Beginning;
use crate::composition::checkpoint::Checkpoint;
use crate::composition::plan::{Plan, PlanError, ns_from_ms};
use crate::composition::replacement::ReloadEnds;
use crate::fleet::{Began, Setup};
use crate::realtime::clock::{Clock, Monotonic, now_ns};
use crate::realtime::log::LogSender;
use crate::realtime::panic::Panicked;
use crate::realtime::wake::Wake;
use crate::symbols::wiring::{
    ChainSymbols, CommunicationFleetSymbols, CommunicationSymbols, DriveSymbols, LidarSymbols,
    ScanSymbols, SupervisorSymbols, TeleopSymbols, Wiring,
};

/// Activities with their names in the thread table.
pub type Named = Vec<(ActivityKind, Box<dyn RobotActivity>)>;

/// What composition yields.
pub struct Composed {
    /// The activities of each thread, in the order of the thread table.
    pub threads: Vec<ThreadActivities>,
    /// The supervisor's symbols.
    pub supervisor: SupervisorSymbols,
    /// Those of the teleoperator's desk.
    pub teleop: TeleopSymbols,
    /// The robot's machine, for its names.
    pub machine: Machine,
    /// Wakes the thread of communication.
    pub alarm: Alarm,
    /// Wakes the thread that waits for scans.
    pub scan_wake: Wake,
    /// Keeps the shared memory.
    pub table: SymbolTable,
}

/// Composes the robot. Every activity needs a port.
///
/// # Errors
/// [`PlanError`] when a part cannot be built.
pub fn compose(
    plan: &Plan,
    wiring: Wiring,
    mut ports: Vec<(ActivityKind, Port)>,
    (reload, left, began): (ReloadEnds, Option<&Checkpoint>, Began),
    boot_epoch: u64,
    (log, panicked): (&LogSender, &Panicked),
) -> Result<Composed, PlanError> {
    let (symbols, beginning) = (wiring.symbols, Beginning::of(plan, left, began, log)?);
    let navigator = &beginning.navigator;
    let (machine, goes_on) = (navigator.machine().clone(), beginning.left.is_some());
    let (alarm, scan_wake) = (Alarm::default(), Wake::default());
    let known = (boot_epoch, beginning.began.clone());
    let (navigation_end, membership) = membership(plan, navigator, known, &alarm).unzip();
    let mut activities = compose_chain(
        plan,
        beginning,
        symbols.chain,
        &mut ports,
        reload,
        navigation_end,
    )?;
    activities.extend(compose_devices(
        plan,
        (symbols.drive, symbols.lidar),
        &mut ports,
        Devices::of(plan)?,
        goes_on,
        &scan_wake,
        (log, panicked),
    )?);
    let settings = plan.communication_settings(boot_epoch);
    let communication = compose_communication(
        settings.clone(),
        port(&mut ports, ActivityKind::Communication),
        (symbols.communication, symbols.communication_fleet),
        membership,
        zenoh_session(settings),
        (log, &alarm),
        now_ns(),
    );
    activities.push((ActivityKind::Communication, Box::new(communication)));
    Ok(Composed {
        threads: by_thread(plan, activities, wiring.scans)?,
        supervisor: symbols.supervisor,
        teleop: symbols.teleop,
        machine,
        alarm,
        scan_wake,
        table: wiring.table,
    })
}

/// The queues between navigation and communication: navigation's end, and what communication needs. `None` where nobody
/// manages the areas.
#[must_use]
pub fn membership(
    plan: &Plan,
    navigator: &Navigator,
    (boot_epoch, began): (u64, Began),
    alarm: &Alarm,
) -> Option<(NavigationEnd, MembershipSetup)> {
    let setup = Setup {
        began,
        ..plan.fleet_setup(navigator, boot_epoch)?
    };
    let (navigation_end, link) = fleet_link::link(alarm.wake.clone());
    let machine = navigator.machine().clone();
    let setup = MembershipSetup {
        setup,
        link,
        machine,
    };
    Some((navigation_end, setup))
}

/// Composes the chain of activities from encoders and scans to wheel setpoints, which need no device and no network:
/// the same ones run on a simulated clock. They go on from a checkpoint, if there is one. With `leave` the robot may only be
/// where the mediator lets it.
///
/// # Errors
/// [`PlanError`] when a part cannot be built.
pub fn compose_chain(
    plan: &Plan,
    beginning: Beginning<'_>,
    symbols: ChainSymbols,
    ports: &mut Vec<(ActivityKind, Port)>,
    reload: ReloadEnds,
    leave: Option<NavigationEnd>,
) -> Result<Named, PlanError> {
    let mut port = |kind| port(ports, kind);
    let command_timeout_ns = ns_from_ms(plan.robot.control.command_timeout_ms);
    let Beginning {
        navigator,
        start,
        left,
        began: _,
    } = beginning;
    let mut reckoning = plan.dead_reckoning()?;
    let mut tubes = Box::new(plan.motion_tubes()?);
    if let Some(left) = left {
        reckoning.resume(&left.odometry);
        if !tubes.resume(&left.floor) {
            tubes.assume_nothing();
        }
    }
    let proprioception = Proprioception::new(
        port(ActivityKind::Proprioception),
        symbols.proprioception,
        reckoning,
    );
    let mut navigation = Navigation::new(
        port(ActivityKind::Navigation),
        symbols.navigation,
        Box::new(Part::new(navigator, start, plan.robot.teleop)),
        reload.navigator,
    );
    if let Some(link) = leave {
        navigation = navigation.managed(symbols.navigation_fleet, link);
    }
    let motion_tube = MotionTube::new(
        port(ActivityKind::MotionTube),
        symbols.motion_tube,
        tubes,
        reload.tubes,
        command_timeout_ns,
    )
    .remembering(left.map_or(0, |left| left.odometry.breaks));
    let control = Control::new(
        port(ActivityKind::Control),
        symbols.control,
        plan.wheel_controller()?,
        reload.controller,
        command_timeout_ns,
    );
    Ok(vec![
        (ActivityKind::Proprioception, Box::new(proprioception)),
        (ActivityKind::Navigation, Box::new(navigation)),
        (ActivityKind::MotionTube, Box::new(motion_tube)),
        (ActivityKind::Control, Box::new(control)),
    ])
}

/// The ways to a robot's devices, each with the clock of its deadlines.
pub struct Devices {
    /// To the bus.
    pub bus: (OpenLink, Arc<dyn Clock>),
    /// To the lidar.
    pub lidar: (OpenLine, Arc<dyn Clock>),
}

impl Devices {
    /// Those that the robot file names.
    ///
    /// # Errors
    /// As [`Plan::lidar_settings`].
    pub fn of(plan: &Plan) -> Result<Self, PlanError> {
        let open_link = open_link(&plan.robot.ethercat.link);
        let open_line = open_line(plan.lidar_settings()?);
        Ok(Self {
            bus: (open_link, Arc::new(Monotonic)),
            lidar: (open_line, Arc::new(Monotonic)),
        })
    }
}

/// Composes the activities of the drive and the lidar, of a robot that `goes_on` from another process's checkpoint, or not.
///
/// # Errors
/// [`PlanError`] when a part cannot be built.
pub fn compose_devices(
    plan: &Plan,
    symbols: (DriveSymbols, LidarSymbols),
    ports: &mut Vec<(ActivityKind, Port)>,
    devices: Devices,
    goes_on: bool,
    scan_wake: &Wake,
    (log, panicked): (&LogSender, &Panicked),
) -> Result<Named, PlanError> {
    let drive = Drive::new(
        port(ports, ActivityKind::Drive),
        plan.drive_settings(),
        symbols.0,
        devices.bus,
        log.clone(),
    )
    .going_on(goes_on)
    .heeding(panicked.clone());
    let lidar = Lidar::new(
        port(ports, ActivityKind::Lidar),
        plan.lidar_settings()?,
        symbols.1,
        devices.lidar,
        scan_wake.clone(),
        log.clone(),
    );
    Ok(vec![
        (ActivityKind::Drive, Box::new(drive)),
        (ActivityKind::Lidar, Box::new(lidar)),
    ])
}

/// Composes communication, and makes a first attempt to open its session: before any thread is promoted.
#[must_use]
pub fn compose_communication(
    settings: Settings,
    port: Port,
    symbols: (CommunicationSymbols, CommunicationFleetSymbols),
    membership: Option<MembershipSetup>,
    open_session: OpenSession,
    (log, alarm): (&LogSender, &Alarm),
    now_ns: u64,
) -> Communication {
    let mut communication = Communication::new(
        port,
        settings,
        symbols,
        open_session,
        (log.clone(), alarm.news.clone()),
        membership,
        now_ns,
    );
    communication.open_network(now_ns);
    communication
}

/// Puts activities on the threads of the table, in its order; a thread that looks at scans gets one intake for all of its activities.
///
/// # Errors
/// As [`Plan::scan_geometry`].
pub fn by_thread(
    plan: &Plan,
    mut activities: Named,
    mut scans: Vec<(ActivityKind, ScanSymbols)>,
) -> Result<Vec<ThreadActivities>, PlanError> {
    let threads = plan.robot.threads.iter().map(|thread| {
        let kinds = || thread.activities.iter().copied();
        let scans = { kinds().find_map(|kind| take(&mut scans, kind)) }
            .map(|symbols| {
                ScanIntake::new(plan.scan_geometry()?, symbols)
                    .map(Box::new)
                    .map_err(|error| PlanError::Lidar(error.to_string()))
            })
            .transpose()?;
        let activities = kinds().filter_map(|kind| take(&mut activities, kind));
        Ok(ThreadActivities::new(activities.collect(), scans))
    });
    threads.collect()
}

/// Takes out what belongs to an activity.
fn take<T>(all: &mut Vec<(ActivityKind, T)>, kind: ActivityKind) -> Option<T> {
    let index = all.iter().position(|(own, _)| *own == kind)?;
    Some(all.swap_remove(index).1)
}

/// Takes out the port of an activity.
///
/// # Panics
/// When it was taken before.
pub fn port(ports: &mut Vec<(ActivityKind, Port)>, kind: ActivityKind) -> Port {
    // Every kind is in `ACTIVITIES`; the test below holds them together.
    take(ports, kind).expect("every activity has a port")
}

/// How the drive activity opens its link, at first and after each loss.
fn open_link(link: &Link) -> OpenLink {
    let link = link.clone();
    Box::new(move || {
        let opened: Result<Box<dyn FrameLink>, _> = match &link {
            Link::Interface(name) => RawLink::open(name).map(|link| Box::new(link) as _),
            Link::Udp(address) => UdpLink::open(*address).map(|link| Box::new(link) as _),
        };
        opened.map_err(|error| error.to_string())
    })
}

/// How the lidar activity opens its line, at first and after each loss.
fn open_line(settings: lidar::Settings) -> OpenLine {
    Box::new(move || {
        let line = TtyLine::open(&settings.device, settings.options.bit_rate)?;
        Ok(Box::new(line))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::symbols::wiring::ACTIVITIES;

    #[test]
    fn every_activity_has_a_port() {
        let (mut all, mut wired) = (ActivityKind::ALL.to_vec(), ACTIVITIES);
        all.sort_unstable();
        wired.sort_unstable();
        assert_eq!(all, wired);
    }
}
