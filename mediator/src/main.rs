//! The mediator's program. See `mediator --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    // SAFETY: no other thread runs yet.
    unsafe { contract::network::carry_links_on_one_thread() };
    // The library of decision diagrams, by which large nets are analysed, wants a GiB for the stack of a thread that has nothing to do here.
    #[cfg(target_pointer_width = "32")]
    if std::env::var_os("OXIDD_STACK_SIZE").is_none() {
        // SAFETY: the same.
        unsafe { std::env::set_var("OXIDD_STACK_SIZE", "1048576") };
    }
    mediator::main_from(std::env::args_os())
}
