//! `onboard doctor`: looks at the computer that is to run the robot. For each thing: what is, what should be, and the command.
//!
//! Nothing is changed, and no device is opened but a socket for raw frames.

mod addresses;
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

use std::path::Path;

use description::robot::Link;

use crate::composition::failure::Failure;
use crate::composition::files::Files;
use crate::composition::plan::{Plan, wanted_scheduling};
use crate::process::runtime::Runtime;
use crate::realtime::own_cores::Room;
use crate::realtime::scheduling::fast_cores;

use computer::Computer;
use finding::{Finding, Verdict, quoted};

/// Looks, and prints: a table, or with `json` one object a line.
///
/// # Errors
/// [`Failure::Refused`] with every problem of the files; [`Failure::Failed`] when something is bad.
pub fn doctor(files: &Files, runtime: &Runtime, json: bool) -> Result<(), Failure> {
    let plan = Plan::load(files)?;
    let findings = look(&Computer::this(), &plan, runtime, &as_root(files))?;
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

/// The command that looks again, as root. In root's own folders: it is refused this user's.
fn as_root(files: &Files) -> String {
    let program = std::env::current_exe().unwrap_or_else(|_| "onboard".into());
    let path = |path: &Path| quoted(&path.to_string_lossy());
    let mut command = format!(
        "sudo {} doctor --robot {} --site {}",
        path(&program),
        path(&files.robot),
        path(&files.site)
    );
    for change in &files.set {
        command.push_str(" --set ");
        command.push_str(&quoted(change));
    }
    command
}

fn look(
    computer: &Computer,
    plan: &Plan,
    runtime: &Runtime,
    as_root: &str,
) -> Result<Vec<Finding>, Failure> {
    let robot = &plan.robot;
    let wanted: Vec<_> = robot.threads.iter().map(wanted_scheduling).collect();
    let priority = wanted
        .iter()
        .filter_map(|thread| thread.fifo_priority)
        .max();
    let mut found = kernel::findings(computer);
    found.extend(rights::findings(&robot.ethercat.link, priority));
    found.extend(cores::findings(computer, &Room::here(&wanted)));
    if let Link::Interface(interface) = &robot.ethercat.link {
        found.extend(interface::findings(computer, interface));
        let slow = cores::slow(computer, &fast_cores());
        found.extend(interrupts::findings(computer, interface, priority, &slow));
    }
    found.extend(serial::findings(computer, &robot.lidar.device, as_root));
    found.extend(disk::findings(
        runtime.folder(),
        runtime.lasting()?,
        robot.watchdog.device.as_deref(),
    ));
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn root_is_given_the_same_files_and_changes() {
        let files = Files {
            robot: "robots/amr-1.toml".into(),
            site: "my site.toml".into(),
            set: vec!["lidar.device=\"/dev/ttyACM0\"".to_owned()],
        };
        let command = as_root(&files);
        assert!(command.starts_with("sudo "), "{command}");
        let rest = "doctor --robot robots/amr-1.toml --site 'my site.toml' --set 'lidar.device=\"/dev/ttyACM0\"'";
        assert!(command.ends_with(rest), "{command}");
        assert_eq!(quoted("it's"), r"'it'\''s'");
    }
}
