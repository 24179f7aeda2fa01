//! Wishes as lines of standard input, for tests and other programs: the dead-man is that they keep coming.

use std::io::{Read, Write, stdin, stdout};
use std::sync::atomic::{AtomicBool, Ordering};

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::link::Link;
use crate::composition::failure::Failure;

/// Longest time without a look at whether to end.
const LOOK: Timespec = Timespec {
    tv_sec: 0,
    tv_nsec: 50_000_000,
};
/// No wish is longer.
const LONGEST_LINE: usize = 256;

/// Passes lines on as they come, each once, and prints what the robot says. Ends with the input.
pub(super) fn drive(mut link: Link, ends: &AtomicBool) -> Result<(), Failure> {
    let mut pending = Vec::new();
    let mut bytes = [0; 4096];
    while !ends.load(Ordering::Relaxed) {
        let (input, comes) = (stdin(), PollFlags::IN);
        let mut ready = [PollFd::new(&input, comes), PollFd::new(&link, comes)];
        match poll(&mut ready, Some(&LOOK)) {
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(error) => return Err(Failure::failed(error)),
        }
        let read = !ready[0].revents().is_empty();
        if read {
            let count = input.lock().read(&mut bytes).map_err(Failure::failed)?;
            if count == 0 {
                return Ok(());
            }
            pending.extend_from_slice(&bytes[..count]);
            while let Some(end) = pending.iter().position(|&byte| byte == b'\n') {
                let line: Vec<u8> = pending.drain(..=end).collect();
                link.say_line(String::from_utf8_lossy(&line).trim())?;
            }
            if pending.len() > LONGEST_LINE {
                return Err(Failure::failed(
                    "a line of standard input is too long for a wish",
                ));
            }
        }
        if let Some(status) = link.hear()? {
            let mut out = stdout().lock();
            let text = serde_json::to_string(&status).unwrap_or_default();
            if writeln!(out, "{text}").and_then(|()| out.flush()).is_err() {
                return Ok(()); // who reads has left
            }
        }
    }
    Ok(())
}
