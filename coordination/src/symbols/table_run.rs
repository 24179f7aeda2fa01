//! One run of a robot's table: what is called after it.
//!
//! A run has a random word that is part of the name of everything the run creates, so that it can be
//! found and removed.

use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher, Hasher};
use std::path::{Path, PathBuf};
use std::process;

/// One life of a table: what its files and its shared memory are called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct TableRun {
    pub(super) root: PathBuf,
    pub(super) robot: String,
    /// Twelve hexadecimal digits, different for every run.
    pub(super) word: String,
}

impl TableRun {
    pub(super) fn new(root: &Path, robot: &str) -> Self {
        // The keys of a `RandomState` come from the system's random numbers.
        let mut hasher = RandomState::new().build_hasher();
        hasher.write_u32(process::id());
        let word = format!("{:012x}", hasher.finish() & 0xffff_ffff_ffff);
        Self::of(root, robot, &word)
    }

    pub(super) fn of(root: &Path, robot: &str, word: &str) -> Self {
        Self {
            root: root.to_owned(),
            robot: robot.to_owned(),
            word: word.to_owned(),
        }
    }

    /// The folder of what iceoryx2 keeps outside shared memory.
    pub(super) fn folder(&self) -> PathBuf {
        self.root.join(format!("{}.{}", self.robot, self.word))
    }

    pub(super) fn is_word(text: &str) -> bool {
        let hexadecimal = |byte: u8| matches!(byte, b'0'..=b'9' | b'a'..=b'f');
        text.len() == 12 && text.bytes().all(hexadecimal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_differ() {
        let run = || TableRun::new(Path::new("/r"), "a").word;
        let (first, second) = (run(), run());
        assert!(TableRun::is_word(&first) && TableRun::is_word(&second));
        assert_ne!(first, second);
    }
}
