//! How many files this program may have open: each link is one, and so is each connection that has not said yet who it is.
//!
//! zenoh's listener with certificates closes a connection that says nothing after ten seconds. But where it cannot take in another one
//! it looks at none of those that wait (`poll_accept` of tls-listener 0.11, as zenoh 1.10.2 has it): where no file is left it tries just
//! that one again and again, and closes nobody, not even who has long gone. So some files are kept for when none is left. Where those
//! are gone as well, only another listener helps, which costs every robot its link.

use std::fs::{self, File};
use std::time::{Duration, Instant};

use rustix::io::Errno;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// Twice as many as zenoh takes sessions. Programs may often have a thousand unless they ask for more.
const WANTED: u64 = 8_192;
/// More than the kernel keeps for a listener of zenoh's until they are taken in, which is 1,024.
const KEPT: u64 = 2_048;
/// Longer than a connection may say nothing. Doubled each time that another listener did not help.
const STUCK_AFTER: Duration = Duration::from_secs(12);
/// While somebody goes on, robots have their links for so long at a time.
const MOST_PAUSE: Duration = Duration::from_secs(600);
/// How often it is said that none is left.
const WARN_PAUSE: Duration = Duration::from_secs(60);

/// The limit of this process, and whether it is reached.
pub(super) struct Files {
    reserve: Reserve,
    warns_again: Instant,
}

impl Files {
    /// Asks for as many as are wanted, or for what may be had without those that are kept. `robots`: links that there may honestly be;
    /// `opens_anew`: the listener is one that has to be, where nothing else helps.
    pub(super) fn allow_many(robots: usize, opens_anew: bool) -> Self {
        let own = getrlimit(Resource::Nofile);
        let most = own.maximum.unwrap_or(u64::MAX);
        let mut files = Self {
            reserve: Reserve::of(own.current.unwrap_or(most), most, robots, opens_anew),
            warns_again: Instant::now(),
        };
        files.allow(files.reserve.usual);
        files
    }

    /// Called once a second. Returns whether the network has to be opened anew.
    pub(super) fn look(&mut self, now: Instant) -> bool {
        let is_one_left = is_one_left();
        if !is_one_left && now >= self.warns_again {
            self.warns_again = now + WARN_PAUSE;
            tracing::warn!(
                "none of {} files that may be open is left for another link. Connections that do not say who they are are closed after 10 s: if there are such, keep whoever opens them from this port; if not, allow more files (`ulimit -n`, LimitNOFILE)",
                self.reserve.allowed
            );
        }
        match self.reserve.look(is_one_left, open_files, now) {
            Deed::Nothing => false,
            Deed::Allow(files) => {
                self.allow(files);
                false
            }
            Deed::OpenAnew => true,
        }
    }

    fn allow(&mut self, files: u64) {
        let limit = Rlimit {
            current: Some(files),
            ..getrlimit(Resource::Nofile)
        };
        match setrlimit(Resource::Nofile, limit) {
            Ok(()) => self.reserve.allowed = files,
            Err(error) => {
                let allowed = self.reserve.allowed;
                tracing::warn!("no other number of files than {allowed} may be open: {error}");
                self.reserve.is_refused();
            }
        }
    }
}

/// What is to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Deed {
    Nothing,
    /// So many files may be open.
    Allow(u64),
    /// The listener has to be another one.
    OpenAnew,
}

/// How many files may usually be open, how many when none of them is left, and now.
struct Reserve {
    usual: u64,
    most: u64,
    allowed: u64,
    opens_anew: bool,
    none_left_since: Option<Instant>,
    pause: Duration,
}

impl Reserve {
    /// Of a process that may have `had` files open, and allow itself `most`.
    fn of(had: u64, most: u64, robots: usize, opens_anew: bool) -> Self {
        let usual = WANTED.min(most - KEPT.min(most / 2));
        let most = most.min(usual + KEPT);
        Self {
            usual,
            most,
            allowed: had,
            // Where the files are too few for the site's robots, it may be those that have them.
            opens_anew: opens_anew && (robots as u64) < usual,
            none_left_since: None,
            pause: STUCK_AFTER,
        }
    }

    /// The limit stays what it is.
    fn is_refused(&mut self) {
        (self.usual, self.most) = (self.allowed, self.allowed);
    }

    fn look(
        &mut self,
        is_one_left: bool,
        open: impl FnOnce() -> Option<u64>,
        now: Instant,
    ) -> Deed {
        if is_one_left {
            self.none_left_since = None;
            if self.allowed > self.usual && open().is_some_and(|open| open < self.usual) {
                self.pause = STUCK_AFTER;
                return Deed::Allow(self.usual);
            }
            return Deed::Nothing;
        }
        if self.allowed < self.most {
            return Deed::Allow(self.most);
        }
        let since = *self.none_left_since.get_or_insert(now);
        if !self.opens_anew || now < since + self.pause {
            return Deed::Nothing;
        }
        self.none_left_since = None;
        self.pause = (2 * self.pause).min(MOST_PAUSE);
        Deed::OpenAnew
    }
}

/// Whether one more file could be opened, by this process and on this computer.
fn is_one_left() -> bool {
    let opened = File::open("/dev/null");
    let error = opened.err().and_then(|error| error.raw_os_error());
    error.is_none_or(|number| {
        ![Errno::MFILE, Errno::NFILE].contains(&Errno::from_raw_os_error(number))
    })
}

/// How many are open; none where that cannot be known.
fn open_files() -> Option<u64> {
    let open = fs::read_dir("/proc/self/fd").ok()?;
    Some(open.count() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some(open: u64) -> impl FnOnce() -> Option<u64> {
        move || Some(open)
    }

    fn allowed(mut reserve: Reserve) -> Reserve {
        reserve.allowed = reserve.usual;
        reserve
    }

    #[test]
    fn it_asks_for_what_it_wants_and_keeps_some() {
        let of = |had, most| {
            let reserve = Reserve::of(had, most, 3, true);
            (reserve.usual, reserve.most)
        };
        assert_eq!(of(1_024, u64::MAX), (8_192, 10_240), "no limit");
        assert_eq!(of(1_024, 524_288), (8_192, 10_240));
        assert_eq!(of(524_288, 524_288), (8_192, 10_240), "not all of them");
        assert_eq!(of(1_024, 4_096), (2_048, 4_096));
        assert_eq!(of(256, 1_024), (512, 1_024));
        assert_eq!((of(1, 1), of(0, 0)), ((1, 1), (0, 0)));
    }

    #[test]
    fn when_none_is_left_it_takes_those_that_were_kept_until_others_are_free() {
        let mut reserve = allowed(Reserve::of(1_024, 4_096, 3, true));
        let now = Instant::now();
        assert_eq!(reserve.look(true, some(2_000), now), Deed::Nothing);
        assert_eq!(reserve.look(false, some(2_048), now), Deed::Allow(4_096));
        reserve.allowed = 4_096;
        assert_eq!(reserve.look(true, some(2_500), now), Deed::Nothing);
        assert_eq!(reserve.look(true, || None, now), Deed::Nothing);
        assert_eq!(reserve.look(true, some(2_000), now), Deed::Allow(2_048));
    }

    #[test]
    fn when_those_are_gone_it_opens_the_network_anew_less_and_less_often() {
        let mut reserve = allowed(Reserve::of(1_024, 4_096, 3, true));
        reserve.allowed = reserve.most;
        let begun = Instant::now();
        let opened = (0..4_000).filter(|&second| {
            let now = begun + Duration::from_secs(second);
            reserve.look(false, some(4_096), now) == Deed::OpenAnew
        });
        let expected = [12, 37, 86, 183, 376, 761, 1_362, 1_963, 2_564, 3_165, 3_766];
        assert!(opened.eq(expected));
        // It is over.
        let now = begun + Duration::from_secs(4_000);
        assert_eq!(reserve.look(true, some(50), now), Deed::Allow(2_048));
        assert_eq!(reserve.pause, STUCK_AFTER);
    }

    #[test]
    fn links_are_not_cut_where_that_is_of_no_use() {
        let open_listener = Reserve::of(1_024, 4_096, 3, false);
        let many_robots = Reserve::of(1_024, 4_096, 2_048, true);
        for mut reserve in [open_listener, many_robots] {
            reserve.allowed = reserve.most;
            let begun = Instant::now();
            for second in 0..1_000 {
                let now = begun + Duration::from_secs(second);
                assert_eq!(reserve.look(false, some(4_096), now), Deed::Nothing);
            }
        }
    }

    #[test]
    fn a_limit_that_cannot_be_changed_is_not_tried_again() {
        let mut reserve = Reserve::of(1_024, 4_096, 3, true);
        reserve.is_refused();
        let now = Instant::now();
        assert_eq!(reserve.look(false, some(1_024), now), Deed::Nothing);
        assert_eq!(reserve.look(true, some(20), now), Deed::Nothing);
    }
}
