//! The robot's program. See `onboard --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    onboard::main_from(std::env::args_os())
}
