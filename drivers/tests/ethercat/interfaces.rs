//! Pairs of virtual network interfaces that vanish with the thread that uses them.

use std::io;
use std::process::Command;

use crate::support::in_own_thread;

pub const MAIN_DEVICE: &str = "ecat-main";
pub const SEGMENT: &str = "ecat-segment";

/// Runs `test` in a thread with a network of its own: a pair of connected interfaces and a loopback interface that is
/// down. Says so and returns when that is not permitted here.
pub fn with_own_network(test: impl FnOnce() + Send + 'static) {
    in_own_thread(move || {
        if let Err(reason) = enter() {
            eprintln!("SKIPPED: needs a network namespace and `ip`: {reason}");
            return;
        }
        test();
    });
}

fn enter() -> Result<(), String> {
    // SAFETY: changes the network of this thread only; threads and processes it starts inherit it.
    if unsafe { libc::unshare(libc::CLONE_NEWNET) } != 0 {
        return Err(io::Error::last_os_error().to_string());
    }
    ip(&[
        "link",
        "add",
        MAIN_DEVICE,
        "type",
        "veth",
        "peer",
        "name",
        SEGMENT,
    ])?;
    ip(&["link", "set", MAIN_DEVICE, "up"])?;
    ip(&["link", "set", SEGMENT, "up"])
}

pub fn ip(arguments: &[&str]) -> Result<(), String> {
    run("ip", arguments)
}

/// Has the interface refuse every frame (`ENOBUFS`), or take them again. Of the same package as `ip`.
pub fn refuse_frames(refuse: bool) -> Result<(), String> {
    let verb = if refuse { "add" } else { "del" };
    let mut arguments = vec!["qdisc", verb, "dev", MAIN_DEVICE, "root"];
    arguments.extend(refuse.then_some(["pfifo", "limit", "0"]).iter().flatten());
    run("tc", &arguments)
}

fn run(program: &str, arguments: &[&str]) -> Result<(), String> {
    let output = Command::new(program)
        .args(arguments)
        .output()
        .map_err(|error| error.to_string())?;
    match output.status.success() {
        true => Ok(()),
        false => Err(String::from_utf8_lossy(&output.stderr).into_owned()),
    }
}
