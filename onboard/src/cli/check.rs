//! `onboard check`: validates the files and prints the resolved plan, touching no device.

use std::time::{SystemTime, UNIX_EPOCH};

use config::{RobotConfig, SiteConfig};
use contract::private;
use coordination::symbols::Namespace;
use description::robot::Link;
use description::threads::{ActivityKind, Core, Scheduling, Trigger};

use crate::activities::communication::read_identity;
use crate::composition::failure::Failure;
use crate::composition::files::Files;
use crate::composition::plan::{Budget, Plan, thread_names};
use crate::realtime::clock::now_ns;
use crate::symbols::wiring::Wiring;

/// Validates and prints.
///
/// # Errors
/// [`Failure::Refused`] with every problem of the files.
pub fn check(files: &Files) -> Result<(), Failure> {
    let plan = Plan::load(files)?;
    print_robot(&plan.robot, &plan.site);
    print_threads(&plan.robot);
    print_symbols(&plan.robot)?;
    print_machine(&plan);
    crate::say!("\n{}", plan.tube_report);
    crate::say!("\n{}", Budget::of(&plan));
    crate::say!("\nok: nothing was started");
    Ok(())
}

fn print_robot(robot: &RobotConfig, site: &SiteConfig) {
    let role = site
        .robots
        .get(&robot.identity.id)
        .map_or("?", |robot| robot.role.as_str());
    crate::say!(
        "robot {} ({}), role {role}, site {}",
        robot.identity.id,
        robot.identity.model,
        site.name
    );
    match &robot.ethercat.link {
        Link::Interface(name) => crate::say!("EtherCAT on interface {name}, raw frames"),
        Link::Udp(address) => crate::say!("EtherCAT over UDP to {address}"),
    }
    if let Some(path) = &robot.fleet.keys {
        // It may be on another computer.
        match read_identity(path.as_ref(), &robot.identity.id) {
            Ok(identity) => crate::say!(
                "certificate of {}, for another {:.1} days",
                identity.name(),
                days_until(identity.expires_unix_s())
            ),
            Err(error) => crate::say!("certificate: {error}"),
        }
    }
    crate::say!(
        "lidar on {} at {} bit/s",
        robot.lidar.device.display(),
        robot.lidar.bit_rate
    );
}

/// By this computer's clock.
fn days_until(unix_s: i64) -> f64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    (unix_s as f64 - now.unwrap_or_default().as_secs_f64()) / 86_400.0
}

fn print_threads(robot: &RobotConfig) {
    crate::say!(
        "\n{:<15} {:<16} {:<10} {:<8} activities",
        "thread",
        "runs",
        "policy",
        "core"
    );
    for thread in &robot.threads {
        let runs = match thread.trigger {
            Trigger::Period { period } => format!("every {period:?}"),
            Trigger::Lidar => "on data".to_owned(),
            Trigger::Scan { at_least } => format!("scan or {at_least:?}"),
            Trigger::Async => "asynchronous".to_owned(),
        };
        let policy = match thread.scheduling {
            Scheduling::Fifo { priority } => format!("fifo {priority}"),
            Scheduling::Normal => "normal".to_owned(),
        };
        let core = match thread.core {
            Core::Any => "any".to_owned(),
            Core::Big => "big".to_owned(),
            Core::Little => "little".to_owned(),
            Core::Number(number) => number.to_string(),
        };
        let activities: Vec<&str> = thread
            .activities
            .iter()
            .map(|activity| activity.name())
            .collect();
        crate::say!(
            "{:<15} {runs:<16} {policy:<10} {core:<8} {}",
            thread.name,
            activities.join(", ")
        );
    }
    debug_assert_eq!(
        robot
            .threads
            .iter()
            .map(|thread| thread.activities.len())
            .sum::<usize>(),
        ActivityKind::ALL.len()
    );
}

/// Builds the real table in a folder of its own, and lists it: what is printed is what `run` does.
fn print_symbols(robot: &RobotConfig) -> Result<(), Failure> {
    // Others see the number of a process in time to take such a name.
    let name = format!("onboard-check-{}-{}", std::process::id(), now_ns());
    let folder = std::env::temp_dir().join(name);
    private::folder(&folder).map_err(Failure::refused)?;
    let place = Namespace::new(&folder, format!("chk{:x}_", std::process::id()));
    let wiring = Wiring::build(&robot.identity.id, &place, &thread_names(robot));
    let listed = wiring.map(|wiring| wiring.table.directory());
    // Empty by now; what is left of it is no reason to fail.
    let _ = std::fs::remove_dir_all(&folder);
    let symbols = listed.map_err(Failure::refused)?;
    crate::say!(
        "\n{:<34} {:<22} readers",
        "symbol (datatype/model)",
        "owner"
    );
    for symbol in symbols {
        let id = format!("{}/{}", symbol.datatype, symbol.model);
        crate::say!(
            "{id:<34} {:<22} {}",
            symbol.owner,
            symbol.readers.join(", ")
        );
    }
    Ok(())
}

fn print_machine(plan: &Plan) {
    crate::say!(
        "\nstate machine of role {} (initial {})",
        plan.role,
        plan.fsm.initial
    );
    crate::say!(
        "{:<16} {:<24} {:<12} {:<16} transitions",
        "state",
        "areas",
        "lane",
        "skill"
    );
    for state in &plan.fsm.states {
        let transitions: Vec<String> = plan
            .fsm
            .transitions
            .iter()
            .filter(|transition| transition.from == state.name)
            .map(|transition| match transition.outputs.as_slice() {
                [] => format!("{} -> {}", transition.on, transition.to),
                outputs => format!(
                    "{} / {} -> {}",
                    transition.on,
                    outputs.join(" "),
                    transition.to
                ),
            })
            .collect();
        let areas: Vec<&str> = state.areas().collect();
        let own = state.lane.as_deref();
        let lane = own.or(plan
            .site
            .area(&state.area)
            .and_then(|area| area.lane.as_deref()));
        crate::say!(
            "{:<16} {:<24} {:<12} {:<16} {}",
            state.name,
            areas.join(" "),
            lane.unwrap_or("-"),
            state.skill,
            transitions.join(", ")
        );
    }
    crate::say!(
        "\n{:<16} {:<14} {:<12} monitors",
        "skill",
        "controller",
        "perception"
    );
    for skill in &plan.site.skills {
        crate::say!(
            "{:<16} {:<14} {:<12} {}",
            skill.id,
            skill.controller.name(),
            skill.perception,
            skill.monitors.join(", ")
        );
    }
}
