//! `rig devices`: the devices of one robot alone, for any program that speaks their protocols.

use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Duration;

use clap::Args;
use description::robot::Link;
use onboard::cli::Failure;

use crate::output::end_flag;
use crate::testbed::{BusPlace, Devices, start_pose, world};

/// How often the truth is printed.
const SAY: Duration = Duration::from_secs(1);

/// Which devices, and where.
#[derive(Args, Clone, Debug)]
pub struct Setup {
    /// Robot file
    #[arg(long, value_name = "FILE")]
    pub robot: PathBuf,
    /// Site file that says where the walls are
    #[arg(
        long,
        value_name = "FILE",
        default_value = "config/sites/corridor.toml"
    )]
    pub site: PathBuf,
    /// Where the bus is: a network interface, or udp:ADDRESS [default: what the robot file says]
    #[arg(long, value_name = "IFACE|udp:ADDR")]
    pub ethercat: Option<String>,
    /// Symbolic link to make to the lidar's terminal
    #[arg(long, value_name = "PATH")]
    pub lidar: Option<PathBuf>,
    /// Decides wheel errors and noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
}

/// Runs the devices until Ctrl-C.
///
/// # Errors
/// [`Failure::Refused`] naming what is wrong or taken.
pub fn devices(setup: &Setup) -> Result<(), Failure> {
    let asked_to_end = end_flag()?;
    let report = |error| Failure::Refused(miette::Report::new(error));
    let robot = config::load_robot(&setup.robot, &[]).map_err(report)?;
    let site = config::load_site(&setup.site, &[]).map_err(report)?;
    let start = start_pose(&site, &robot.identity.id)?;
    let world = world(&site, &[(&robot, start)], setup.seed)?;
    let place = bus_place(setup.ethercat.as_deref(), &robot.ethercat.link)?;
    let devices = Devices::start(&world, &robot, &place, setup.lidar.clone(), setup.seed)?;
    match (&place, devices.bus.local_addr()) {
        (BusPlace::Interface(name), _) => {
            onboard::say!("EtherCAT: raw frames on the other end of interface {name}")
        }
        (_, Some(address)) => {
            onboard::say!("EtherCAT: UDP to {address} (--set 'ethercat.udp=\"{address}\"')")
        }
        (_, None) => onboard::say!("EtherCAT: served"),
    }
    if let Some(path) = devices.lidar.path() {
        onboard::say!("lidar: {0} (--set 'lidar.device=\"{0}\"')", path.display());
    }
    onboard::say!("Ctrl-C ends it");
    let truth = world.robot(&robot.identity.id).map_err(Failure::refused)?;
    let mut said = 0_u64;
    while !asked_to_end.load(Ordering::Relaxed) {
        std::thread::sleep(SAY / 10);
        let now = truth.truth();
        let setpoints = devices.drive.statistics().setpoints;
        if now.time_ns / 1_000_000_000 != said && setpoints > 0 {
            said = now.time_ns / 1_000_000_000;
            onboard::say!(
                "x {:6.3} m  y {:6.3} m  heading {:6.3} rad  speed {:6.3} m/s  pivot {:6.3} rad  setpoints {setpoints}",
                now.pose.x_m,
                now.pose.y_m,
                now.pose.theta_rad,
                now.twist.v_m_s,
                now.pivot_rad
            );
        }
    }
    Ok(())
}

fn bus_place(wanted: Option<&str>, file: &Link) -> Result<BusPlace, Failure> {
    match wanted {
        None => Ok(match file {
            Link::Interface(name) => BusPlace::Interface(name.clone()),
            Link::Udp(address) => BusPlace::Udp(*address),
        }),
        Some(text) => match text.strip_prefix("udp:") {
            None => Ok(BusPlace::Interface(text.to_owned())),
            Some(address) => address.parse().map(BusPlace::Udp).map_err(|error| {
                Failure::refused(format_args!(
                    "--ethercat {text}: {error}; expected udp:ADDRESS:PORT"
                ))
            }),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bus_is_where_the_setup_or_the_file_say() {
        let file = Link::Interface("eth0".into());
        assert!(
            bus_place(None, &file).is_ok_and(|place| place == BusPlace::Interface("eth0".into()))
        );
        assert!(
            bus_place(Some("veth1"), &file)
                .is_ok_and(|place| place == BusPlace::Interface("veth1".into()))
        );
        let udp = BusPlace::Udp(([127, 0, 0, 1], 9).into());
        assert!(bus_place(Some("udp:127.0.0.1:9"), &file).is_ok_and(|place| place == udp));
        assert!(bus_place(Some("udp:here"), &file).is_err());
    }
}
