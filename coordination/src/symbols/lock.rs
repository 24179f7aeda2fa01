//! The instance file of a robot: who reads it, and how it is locked.
//!
//! The owner holds an exclusive lock on `<root>/<robot>.pid` as long as it lives; the kernel
//! releases it however the process ends. The file names the pid and the run.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::SymbolError;
use super::namespace::file_error;
use super::table_run::TableRun;

/// Somebody who only looks holds the lock for some microseconds; an owner for longer.
const LOCK_TRIES: u32 = 10;
const LOCK_PAUSE: Duration = Duration::from_millis(5);

/// What the instance file says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Content {
    pub(super) pid: Option<u32>,
    pub(super) word: Option<String>,
    /// Bits of a pointer of the process that owns it, on which the layout of shared memory depends.
    pub(super) bits: Option<u32>,
    pub(super) ready: bool,
}

impl Content {
    pub(super) fn to_text(&self) -> String {
        let pid = self.pid.unwrap_or_default();
        let word = self.word.as_deref().unwrap_or_default();
        let bits = self.bits.unwrap_or_default();
        let state = if self.ready { "ready" } else { "starting" };
        format!("pid {pid}\nrun {word}\nbits {bits}\n{state}\n")
    }

    fn from_text(text: &str) -> Self {
        let mut content = Self::default();
        for line in text.lines() {
            match line.split_once(' ') {
                Some(("pid", pid)) => content.pid = pid.parse().ok(),
                Some(("run", word)) => {
                    content.word = Some(word.to_owned()).filter(|word| TableRun::is_word(word));
                }
                Some(("bits", bits)) => content.bits = bits.parse().ok(),
                _ => content.ready |= line == "ready",
            }
        }
        content
    }
}

/// What somebody who is not the owner sees.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Seen {
    /// There is no instance file.
    Absent,
    /// The owner has ended without removing its file.
    Dead(Content),
    /// The owner lives.
    Alive(Content),
}

/// Looks at the instance file of `robot` without changing anything.
pub(super) fn look(root: &Path, robot: &str) -> Result<Seen, SymbolError> {
    let path = instance_path(root, robot);
    let file = match File::open(&path) {
        Ok(file) => file,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Seen::Absent),
        Err(error) => return Err(file_error("open", &path)(error)),
    };
    let content = read_content(&file).map_err(file_error("read", &path))?;
    match file.try_lock_shared() {
        Err(TryLockError::WouldBlock) => Ok(Seen::Alive(content)),
        Err(TryLockError::Error(error)) => Err(file_error("lock", &path)(error)),
        // A lock on a file that was just removed by its owner says nothing about the robot.
        Ok(()) if !is_same_file(&file, &path) => Ok(Seen::Absent),
        Ok(()) => Ok(Seen::Dead(content)),
    }
}

/// Locks the instance file, which is created if it is missing.
pub(super) fn lock_exclusively(robot: &str, path: &Path) -> Result<File, SymbolError> {
    let mut busy_pid = None;
    for attempt in 0..LOCK_TRIES {
        if attempt > 0 {
            std::thread::sleep(LOCK_PAUSE);
        }
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .mode(0o600)
            .open(path)
            .map_err(file_error("open", path))?;
        match file.try_lock() {
            // The former owner may have removed the file between our opening and locking it.
            Ok(()) if is_same_file(&file, path) => return Ok(file),
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                busy_pid = read_content(&file).ok().and_then(|content| content.pid);
            }
            Err(TryLockError::Error(error)) => return Err(file_error("lock", path)(error)),
        }
    }
    Err(SymbolError::AlreadyRuns {
        robot: robot.into(),
        pid: busy_pid,
    })
}

pub(super) fn instance_path(root: &Path, robot: &str) -> PathBuf {
    root.join(format!("{robot}.pid"))
}

/// The robot whose instance file has this name.
pub(super) fn robot_of(name: &str) -> Option<&str> {
    name.strip_suffix(".pid")
}

pub(super) fn read_content(mut file: &File) -> io::Result<Content> {
    // Longer than anything that we write; a foreign file is not read to its end.
    let mut bytes = Vec::new();
    file.rewind()?;
    file.take(256).read_to_end(&mut bytes)?;
    Ok(Content::from_text(&String::from_utf8_lossy(&bytes)))
}

fn is_same_file(file: &File, path: &Path) -> bool {
    match (file.metadata(), fs::metadata(path)) {
        (Ok(ours), Ok(theirs)) => (ours.dev(), ours.ino()) == (theirs.dev(), theirs.ino()),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_survives_the_file() {
        let content = Content {
            pid: Some(42),
            word: Some("0123456789ab".to_owned()),
            bits: Some(usize::BITS),
            ready: true,
        };
        assert_eq!(Content::from_text(&content.to_text()), content);
    }

    #[test]
    fn nonsense_in_the_file_is_no_content() {
        for text in [
            "",
            "pid x\nrun ../../etc\n",
            "run 0123456789AB",
            "\u{fffd}\n\n",
        ] {
            assert_eq!(Content::from_text(text), Content::default(), "{text}");
        }
    }
}
