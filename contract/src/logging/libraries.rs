//! What libraries log, bounded: whoever can make them log, as any party of the network can make zenoh, fills no disk with it.

use std::io::Write;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use tracing::{Event, Metadata, Subscriber};
use tracing_subscriber::layer::{Context, Filter};

/// Their lines in a minute.
const MOST: u32 = 30;
const MINUTE: Duration = Duration::from_secs(60);
/// Lines of these are our own, which bound them where they come about.
const OURS: [&str; 8] = [
    "config",
    "contract",
    "coordination",
    "description",
    "drivers",
    "mediator",
    "onboard",
    "skills",
];

/// Lets lines of our own pass, and so many of others.
pub(super) struct Libraries<W> {
    said: Mutex<Said>,
    /// Where it says how many it left out.
    writer: Mutex<W>,
}

impl<W: Write> Libraries<W> {
    pub(super) fn new(writer: W) -> Self {
        Self {
            said: Mutex::default(),
            writer: Mutex::new(writer),
        }
    }
}

#[derive(Debug, Default)]
struct Said {
    since: Option<Instant>,
    lines: u32,
    left_out: u64,
}

impl Said {
    /// Whether a line of this target may pass now, and how many were left out in a minute that is over.
    fn look(&mut self, target: &str, now: Instant) -> (bool, u64) {
        let over = self.since.is_none_or(|since| now >= since + MINUTE);
        let left_out = if over { self.left_out } else { 0 };
        if over {
            *self = Self {
                since: Some(now),
                ..Self::default()
            };
        }
        if is_ours(target) {
            return (true, left_out);
        }
        let passes = self.lines < MOST;
        if passes {
            self.lines += 1;
        } else {
            self.left_out += 1;
        }
        (passes, left_out)
    }
}

fn is_ours(target: &str) -> bool {
    let name = target.split("::").next().unwrap_or_default();
    OURS.contains(&name)
}

impl<S: Subscriber, W: Write + Send + 'static> Filter<S> for Libraries<W> {
    fn enabled(&self, _metadata: &Metadata<'_>, _context: &Context<'_, S>) -> bool {
        true
    }

    fn event_enabled(&self, event: &Event<'_>, _context: &Context<'_, S>) -> bool {
        let (passes, left_out) = {
            let mut said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
            said.look(event.metadata().target(), Instant::now())
        };
        if left_out > 0 {
            let mut writer = self.writer.lock().unwrap_or_else(PoisonError::into_inner);
            // A closed pipe must stop nobody.
            let _ = writeln!(
                writer,
                " WARN {left_out} lines of libraries more than {MOST} in a minute were left out: \
                 somebody on the network may flood this program"
            );
        }
        passes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_libraries_are_few_in_a_minute_and_the_others_are_counted() {
        let (mut said, begin) = (Said::default(), Instant::now());
        let zenoh = "zenoh::net::routing::dispatcher::face";
        let at = |seconds| begin + Duration::from_secs(seconds);
        let passed = (0..5_000).filter(|line| said.look(zenoh, at(line / 100)).0);
        assert_eq!(passed.count(), MOST as usize);
        for target in ["mediator::runtime", "onboard", "contract::network"] {
            assert_eq!(said.look(target, at(59)), (true, 0), "{target}");
        }
        assert!(
            !said.look("zenoh_transport::unicast", at(59)).0,
            "of all libraries"
        );
        assert!(!said.look("mediatory", at(59)).0, "another crate");
        let left_out = 5_000 - u64::from(MOST) + 2;
        assert_eq!(
            said.look("mediator", at(60)),
            (true, left_out),
            "told with the next line"
        );
        assert_eq!(said.look(zenoh, at(61)), (true, 0));
        assert_eq!(
            said.look("mediator", at(121)),
            (true, 0),
            "nothing was left out"
        );
    }
}
