//! Composition: the plan's parts, the symbols' ends and the ports become activities.

use coordination::symbols::SymbolTable;
use description::robot::Link;
use description::threads::ActivityKind;
use drivers::ethercat::{Link as FrameLink, RawLink, UdpLink};

use crate::activities::communication::{Communication, MembershipSetup};
use crate::activities::control::Control;
use crate::activities::drive::{Drive, OpenLink};
use crate::activities::fleet_link;
use crate::activities::lidar::Lidar;
use crate::activities::machine_names::MachineNames;
use crate::activities::motion_tube::MotionTube;
use crate::activities::navigation::Navigation;
use crate::activities::news::Alarm;
use crate::activities::port::Port;
use crate::activities::proprioception::Proprioception;
use crate::activities::robot_activity::RobotActivity;
use crate::activities::scans::ScanIntake;
use crate::composition::failure::Failure;
use crate::composition::plan::{Plan, PlanError, ns_from_ms};
use crate::composition::replacement::ReloadEnds;
use crate::realtime::clock::now_ns;
use crate::realtime::log::LogSender;
use crate::realtime::wake::Wake;
use crate::symbols::wiring::{ACTIVITIES, SupervisorSymbols, Wiring};

/// All activities, until their threads take them.
pub struct Activities(Vec<(ActivityKind, Box<dyn RobotActivity>)>);

impl Activities {
    /// Takes one out. The configuration has each of them on exactly one thread.
    pub fn take(&mut self, kind: ActivityKind) -> Option<Box<dyn RobotActivity>> {
        let index = self.0.iter().position(|(own, _)| *own == kind)?;
        Some(self.0.swap_remove(index).1)
    }
}

/// What composition yields.
pub struct Composed {
    /// The activities.
    pub activities: Activities,
    /// The supervisor's symbols.
    pub supervisor: SupervisorSymbols,
    /// Names of the robot's machine.
    pub names: MachineNames,
    /// Wakes the thread of communication.
    pub alarm: Alarm,
    /// Wakes the thread that waits for scans.
    pub scan_wake: Wake,
    /// Keeps the shared memory.
    pub table: SymbolTable,
}

/// Composes the robot. `ports` are in the order of [`ACTIVITIES`].
///
/// # Errors
/// [`Failure::Refused`] when a part cannot be built.
pub fn compose(
    plan: &Plan,
    wiring: Wiring,
    ports: Vec<Port>,
    reload: ReloadEnds,
    boot_epoch: u64,
    log: &LogSender,
) -> Result<Composed, Failure> {
    build(plan, wiring, ports, reload, boot_epoch, log).map_err(Failure::refused)
}

fn build(
    plan: &Plan,
    wiring: Wiring,
    ports: Vec<Port>,
    reload: ReloadEnds,
    boot_epoch: u64,
    log: &LogSender,
) -> Result<Composed, PlanError> {
    let mut ports: Vec<(ActivityKind, Port)> = ACTIVITIES.into_iter().zip(ports).collect();
    let mut port = |kind: ActivityKind| {
        let index = ports.iter().position(|(own, _)| *own == kind);
        // Every kind is in `ACTIVITIES`; the test below holds them together.
        ports
            .swap_remove(index.expect("every activity has a port"))
            .1
    };
    let intake = || {
        ScanIntake::new(plan.scan_geometry()?).map_err(|error| PlanError::Lidar(error.to_string()))
    };
    let command_timeout_ns = ns_from_ms(plan.robot.control.command_timeout_ms);
    let navigator = Box::new(plan.navigator()?);
    let start = plan.start(navigator.machine().state());
    let names = MachineNames::of(&navigator);
    let (alarm, scan_wake) = (Alarm::default(), Wake::default());
    let fleet = plan.fleet_setup(&navigator, boot_epoch).map(|setup| {
        let (navigation_end, link) = fleet_link::link(alarm.wake.clone());
        let names = names.clone();
        (navigation_end, MembershipSetup { setup, link, names })
    });
    let (navigation_end, membership) = fleet.unzip();
    let drive = Drive::new(
        port(ActivityKind::Drive),
        plan.drive_settings(),
        wiring.drive,
        open_link(&plan.robot.ethercat.link),
        log.clone(),
    );
    let proprioception = Proprioception::new(
        port(ActivityKind::Proprioception),
        wiring.proprioception,
        plan.dead_reckoning()?,
    );
    let lidar = Lidar::new(
        port(ActivityKind::Lidar),
        plan.lidar_settings()?,
        wiring.lidar,
        scan_wake.clone(),
        log.clone(),
    );
    let mut navigation = Navigation::new(
        port(ActivityKind::Navigation),
        wiring.navigation,
        intake()?,
        navigator,
        reload.navigator,
        start,
    );
    if let Some(link) = navigation_end {
        navigation = navigation.managed(wiring.navigation_fleet, link);
    }
    let motion_tube = MotionTube::new(
        port(ActivityKind::MotionTube),
        wiring.motion_tube,
        intake()?,
        Box::new(plan.motion_tubes()?),
        reload.tubes,
        command_timeout_ns,
    );
    let control = Control::new(
        port(ActivityKind::Control),
        wiring.control,
        plan.wheel_controller()?,
        command_timeout_ns,
    )
    .reloading(reload.controller);
    let mut communication = Communication::new(
        port(ActivityKind::Communication),
        plan.communication_settings(boot_epoch),
        (wiring.communication, wiring.communication_fleet),
        log.clone(),
        alarm.news.clone(),
        membership,
        now_ns(),
    );
    communication.open_network(now_ns());
    let activities: Vec<(ActivityKind, Box<dyn RobotActivity>)> = vec![
        (ActivityKind::Drive, Box::new(drive)),
        (ActivityKind::Proprioception, Box::new(proprioception)),
        (ActivityKind::Lidar, Box::new(lidar)),
        (ActivityKind::Navigation, Box::new(navigation)),
        (ActivityKind::MotionTube, Box::new(motion_tube)),
        (ActivityKind::Control, Box::new(control)),
        (ActivityKind::Communication, Box::new(communication)),
    ];
    Ok(Composed {
        activities: Activities(activities),
        supervisor: wiring.supervisor,
        names,
        alarm,
        scan_wake,
        table: wiring.table,
    })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_activity_has_a_port() {
        let (mut all, mut wired) = (ActivityKind::ALL.to_vec(), ACTIVITIES);
        all.sort_unstable();
        wired.sort_unstable();
        assert_eq!(all, wired);
    }
}
