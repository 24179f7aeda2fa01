//! `onboard doctor`: looks at the computer that is to run the robot. For each thing: what is, what should be, and the command.
//!
//! Nothing is changed, and no device is opened but a socket for raw frames.

mod computer;
mod cores;
mod disk;
mod ethtool;
mod finding;
mod interface;
mod interrupts;
mod kernel;
mod rights;
mod serial;

use description::robot::Link;

use crate::composition::failure::Failure;
use crate::composition::files::Files;
use crate::composition::plan::{Plan, wanted_scheduling};
use crate::process::runtime::Runtime;
use crate::realtime::scheduling::{CoreClass, fast_cores};

use computer::Computer;
use finding::{Finding, Verdict};

/// Looks, and prints: a table, or with `json` one object a line.
///
/// # Errors
/// [`Failure::Refused`] with every problem of the files; [`Failure::Failed`] when something is bad.
pub fn doctor(files: &Files, runtime: &Runtime, json: bool) -> Result<(), Failure> {
    let plan = Plan::load(files)?;
    let findings = look(&Computer::this(), &plan, runtime)?;
    for finding in &findings {
        if json {
            crate::say!(
                "{}",
                serde_json::to_string(finding).map_err(Failure::failed)?
            );
        } else {
            crate::say!("{finding}");
        }
    }
    let count = |verdict| findings.iter().filter(|own| own.verdict == verdict).count();
    let (bad, weak) = (count(Verdict::Bad), count(Verdict::Weak));
    if bad > 0 {
        let others = if weak > 0 {
            format!(", and {weak} that may make it late")
        } else {
            String::new()
        };
        return Err(Failure::failed(format_args!(
            "{bad} things that stop the robot{others}: see above"
        )));
    }
    if !json {
        crate::say!("\nnothing stops the robot; {weak} things may make it late now and then");
    }
    Ok(())
}

fn look(computer: &Computer, plan: &Plan, runtime: &Runtime) -> Result<Vec<Finding>, Failure> {
    let robot = &plan.robot;
    let wanted: Vec<_> = robot.threads.iter().map(wanted_scheduling).collect();
    let real_time = { wanted.iter() }.filter(|thread| thread.fifo_priority.is_some());
    let big = real_time
        .filter(|thread| thread.cores == CoreClass::Big)
        .count();
    let priority = wanted
        .iter()
        .filter_map(|thread| thread.fifo_priority)
        .max();
    let mut found = kernel::findings(computer);
    found.extend(rights::findings(&robot.ethercat.link, priority));
    found.extend(cores::findings(computer, big, &fast_cores()));
    if let Link::Interface(interface) = &robot.ethercat.link {
        found.extend(interface::findings(computer, interface));
        let slow = cores::slow(computer, &fast_cores());
        found.extend(interrupts::findings(computer, interface, priority, &slow));
    }
    found.extend(serial::findings(computer, &robot.lidar.device));
    found.extend(disk::findings(
        runtime.folder(),
        runtime.lasting()?,
        robot.watchdog.device.as_deref(),
    ));
    Ok(found)
}
