//! The robot's program. See `onboard --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    // SAFETY: no other thread runs yet.
    unsafe { contract::network::carry_links_on_one_thread() };
    onboard::main_from(std::env::args_os())
}
