//! Two network interfaces joined by a virtual cable: a fieldbus without wires.

use std::process::{Command, Output, Stdio};

/// Two interfaces, removed when this is dropped.
#[derive(Debug)]
pub struct Pair {
    /// One end,
    pub near: String,
    /// and the other.
    pub far: String,
}

impl Pair {
    /// Makes one, and switches both ends on. Needs CAP_NET_ADMIN. `word` tells pairs of one process apart; interface names are short, so
    /// that it has at most three letters.
    ///
    /// # Errors
    /// What `ip` says.
    pub fn new(word: &str) -> Result<Self, String> {
        // A name of this process's own.
        let number = std::process::id();
        let pair = Self {
            near: format!("{word}n{number}"),
            far: format!("{word}f{number}"),
        };
        let (near, far) = (&pair.near, &pair.far);
        ip(&["link", "add", near, "type", "veth", "peer", "name", far])?;
        for name in [near, far] {
            // Frames of the kernel's own do not belong on a fieldbus.
            let key = format!("/proc/sys/net/ipv6/conf/{name}/disable_ipv6");
            let _ = std::fs::write(key, "1");
            ip(&["link", "set", name, "up"])?;
        }
        Ok(pair)
    }
}

impl Drop for Pair {
    fn drop(&mut self) {
        // Removing one end removes the other; not made is as good as removed.
        let _ = ip(&["link", "delete", &self.near]);
    }
}

fn ip(arguments: &[&str]) -> Result<Output, String> {
    said(Command::new("ip").args(arguments))
}

/// Runs a program to its end.
///
/// # Errors
/// The last line of what it said when it failed, or the system's reason.
pub fn said(command: &mut Command) -> Result<Output, String> {
    let output = command.stdin(Stdio::null()).output();
    let output = output.map_err(|error| error.to_string())?;
    if output.status.success() {
        Ok(output)
    } else {
        let said = String::from_utf8_lossy(&output.stderr);
        Err(said.lines().last().unwrap_or("it said nothing").to_owned())
    }
}
