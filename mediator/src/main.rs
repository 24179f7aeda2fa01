//! The mediator's program. See `mediator --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    mediator::main_from(std::env::args_os())
}
