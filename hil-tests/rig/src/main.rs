//! Starts simulated devices and robots as processes, and judges them by the world's truth.

use std::ffi::OsString;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<OsString> = std::env::args_os().collect();
    // Robots and the mediator are this very program, told to be one: one `cargo run` builds all there is.
    if arguments
        .get(1)
        .is_some_and(|first| first == rig::robot::SUBCOMMAND)
    {
        return onboard::main_from(
            std::iter::once(OsString::from("onboard")).chain(arguments.into_iter().skip(2)),
        );
    }
    if arguments
        .get(1)
        .is_some_and(|first| first == rig::fleet::mediator_process::SUBCOMMAND)
    {
        return mediator::main_from(
            std::iter::once(OsString::from("mediator")).chain(arguments.into_iter().skip(2)),
        );
    }
    rig::cli::main_from(arguments)
}
