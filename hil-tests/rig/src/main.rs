//! Starts simulated devices and robots as processes, and judges them by the world's truth.

use std::ffi::OsString;
use std::process::ExitCode;

fn main() -> ExitCode {
    // SAFETY: no other thread runs yet.
    unsafe { contract::network::carry_links_on_one_thread() };
    let arguments: Vec<OsString> = std::env::args_os().collect();
    // Robots and the mediator are this very program, told to be one: one `cargo run` builds all there is.
    let told = arguments.get(1).and_then(|first| first.to_str());
    let named =
        |name: &str| std::iter::once(OsString::from(name)).chain(arguments.iter().skip(2).cloned());
    match told {
        Some(rig::process::robot::SUBCOMMAND) => return onboard::main_from(named("onboard")),
        Some(rig::process::mediator::SUBCOMMAND) => {
            return mediator::main_from(named("mediator"));
        }
        Some(rig::process::janitor::SUBCOMMAND) => {
            return rig::process::janitor::main_from(arguments.into_iter().skip(2));
        }
        _ => {}
    }
    rig::cli::main_from(arguments)
}
