//! How many files this program may have open: each link is one, and so is each connection that has not said yet who it is.
//!
//! zenoh's listener with certificates closes a connection that says nothing after ten seconds. But it looks at those only when there is no
//! other one to take in (`poll_accept` of tls-listener 0.11, as zenoh 1.10.2 has it): where no file is left for that one, it finds
//! just this again and again, and closes none, not even of somebody who has long gone. So some files are kept for when none is left.

use std::fs;
use std::os::fd::AsFd;
use std::time::{Duration, Instant};

use rustix::io::{Errno, fcntl_dupfd_cloexec};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// Programs may often have a thousand unless they ask for more.
const WANTED: u64 = 16_384;
/// More than the kernel keeps for a listener of zenoh's until they are taken in, which is 1,024.
const KEPT: u64 = 2_048;
/// Longer than a connection may say nothing.
const STUCK_AFTER: Duration = Duration::from_secs(12);
/// How often it is said that none is left.
const WARN_PAUSE: Duration = Duration::from_secs(60);

/// The limit of this process, and when it was reached.
pub(super) struct Files {
    usual: u64,
    /// What it may allow itself.
    most: u64,
    allowed: u64,
    none_left_since: Option<Instant>,
    warns_again: Instant,
}

impl Files {
    /// Asks for as many as are wanted, or for what may be had without those that are kept.
    pub(super) fn allow_many() -> Self {
        let own = getrlimit(Resource::Nofile);
        let most = own.maximum.unwrap_or(u64::MAX);
        let had = own.current.unwrap_or(most);
        let usual = had.max(WANTED).min(most - KEPT.min(most / 2));
        let mut files = Self {
            usual,
            most,
            allowed: had,
            none_left_since: None,
            warns_again: Instant::now(),
        };
        files.allow(usual);
        files
    }

    /// Called once a second. Returns whether the network has to be opened anew: nothing else closes those that say nothing.
    pub(super) fn look(&mut self, now: Instant) -> bool {
        if is_one_left() {
            self.none_left_since = None;
            if self.allowed > self.usual && open_files().is_some_and(|open| open < self.usual) {
                self.allow(self.usual);
            }
            return false;
        }
        let since = *self.none_left_since.get_or_insert(now);
        if now >= self.warns_again {
            self.warns_again = now + WARN_PAUSE;
            tracing::warn!(
                "none of {} files that may be open is left; connections that do not say who they are may have them, which are closed after 10 s: see who opens them, and keep him from this port",
                self.allowed
            );
        }
        if self.allowed < self.most {
            self.allow(self.allowed.saturating_add(KEPT).min(self.most));
            return false;
        }
        let is_stuck = now >= since + STUCK_AFTER;
        if is_stuck {
            tracing::warn!(
                "the fleet network is opened anew: no file was left for {STUCK_AFTER:?}"
            );
            self.none_left_since = None;
        }
        is_stuck
    }

    fn allow(&mut self, files: u64) {
        let limit = Rlimit {
            current: Some(files),
            ..getrlimit(Resource::Nofile)
        };
        match setrlimit(Resource::Nofile, limit) {
            Ok(()) => self.allowed = files,
            Err(error) => {
                tracing::warn!("no more files than {} can be open: {error}", self.allowed);
                // Not to be tried again every second.
                (self.usual, self.most) = (self.allowed, self.allowed);
            }
        }
    }
}

/// Whether one more file could be opened.
fn is_one_left() -> bool {
    !matches!(
        fcntl_dupfd_cloexec(std::io::stderr().as_fd(), 0),
        Err(Errno::MFILE)
    )
}

/// How many are open; none where that cannot be known.
fn open_files() -> Option<u64> {
    let open = fs::read_dir("/proc/self/fd").ok()?;
    Some(open.count() as u64)
}
