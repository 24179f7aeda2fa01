//! Folders of the robot: room on disk, and memory for what is written ten times a second. And the computer's watchdog.

use std::path::Path;

use rustix::fs::{Access, access, statfs};
use rustix::io::Errno;

use super::finding::{Finding, quoted};

/// Notes and logs need a fraction of it.
const LEAST_ROOM_MIB: u64 = 64;
/// `TMPFS_MAGIC` and `RAMFS_MAGIC` of `linux/magic.h`.
const IN_MEMORY: [u64; 2] = [0x0102_1994, 0x8584_58f6];

/// All of them. `watchdog`: the device that the robot file names.
pub fn findings(runtime: &Path, state: &Path, watchdog: Option<&str>) -> Vec<Finding> {
    let mut found = vec![memory(runtime), room(state)];
    found.extend(watchdog.map(dog));
    found
}

fn memory(runtime: &Path) -> Finding {
    const SUBJECT: &str = "runtime folder";
    let shown = runtime.display();
    match statfs(runtime) {
        Ok(found) if IN_MEMORY.contains(&(found.f_type as u64 & 0xffff_ffff)) => {
            Finding::good(SUBJECT, format!("{shown} is in memory"))
        }
        Ok(_) => Finding::weak(
            SUBJECT,
            format!("{shown} is on a disk, which is written ten times a second"),
            "a folder in memory: $XDG_RUNTIME_DIR, or --runtime",
        )
        .with("export ONBOARD_RUNTIME_DIR=/dev/shm/onboard-$(id -u)"),
        Err(error) => missing(SUBJECT, runtime, error),
    }
}

fn missing(subject: &'static str, folder: &Path, error: Errno) -> Finding {
    let shown = folder.display();
    Finding::bad(
        subject,
        format!("{shown}: {error}"),
        "a folder of this user alone",
    )
    .with(format!(
        "sudo install -d -m 0700 -o \"$USER\" {}",
        quoted(&shown.to_string())
    ))
}

fn room(state: &Path) -> Finding {
    const SUBJECT: &str = "room on disk";
    let shown = state.display();
    match statfs(state) {
        Ok(found) => {
            let mib = found.f_bavail.saturating_mul(found.f_bsize as u64) >> 20;
            let is = format!("{mib} MiB in {shown}");
            if mib >= LEAST_ROOM_MIB {
                Finding::good(SUBJECT, is)
            } else {
                Finding::bad(
                    SUBJECT,
                    is,
                    format!(
                        "{LEAST_ROOM_MIB} MiB: a robot that cannot note where it was waits for an operator"
                    ),
                )
                .with("sudo journalctl --vacuum-size=100M; sudo du -xh --max-depth 3 / | sort -h | tail   # what takes it")
            }
        }
        Err(error) => missing(SUBJECT, state, error),
    }
}

fn dog(device: &str) -> Finding {
    const SUBJECT: &str = "watchdog";
    // Opening it would start it.
    match access(device, Access::WRITE_OK) {
        Ok(()) => Finding::good(SUBJECT, format!("{device} may be written")),
        Err(error) => Finding::bad(
            SUBJECT,
            format!("{device}: {error}"),
            "a watchdog that this user may write",
        )
        .with(format!(
            "sudo chgrp robots {device} && sudo chmod g+w {device}"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::super::finding::Verdict;
    use super::*;

    #[test]
    fn folders_in_memory_and_missing_ones_are_told_apart() {
        assert_eq!(memory(Path::new("/dev/shm")).verdict, Verdict::Good);
        assert_eq!(memory(Path::new("/proc")).verdict, Verdict::Weak);
        let missing = findings(
            Path::new("/no/such"),
            Path::new("/no/such"),
            Some("/no/dog"),
        );
        assert!(
            missing
                .iter()
                .all(|found| found.verdict == Verdict::Bad && found.command.is_some()),
            "{missing:?}"
        );
    }

    #[test]
    fn a_file_system_without_room_is_bad() {
        // It has none at all.
        assert_eq!(room(Path::new("/proc")).verdict, Verdict::Bad);
        assert_eq!(dog("/dev/null").verdict, Verdict::Good);
    }
}
