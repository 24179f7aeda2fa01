//! Lines of a program's log go to standard error, on a thread of their own: a terminal that was stopped, a full pipe or disk holds up
//! nobody else. What cannot be written is dropped and counted. Of libraries there are few lines in a minute, unless somebody asks for what
//! is logged.

mod libraries;

use std::io::IsTerminal;

use libraries::Libraries;
use tracing_appender::non_blocking::{NonBlockingBuilder, WorkerGuard};
use tracing_subscriber::filter::DynFilterFn;
use tracing_subscriber::fmt::layer;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{Layer, Registry};

pub use tracing_appender::non_blocking::ErrorCounter;
pub use tracing_subscriber::filter::{LevelFilter, Targets};

/// Lines that may wait to be written.
const WAITING: usize = 4096;

/// The log while the program runs. When it is dropped, what waits is written out, for a second at most.
#[derive(Debug)]
pub struct Logging {
    unwritten: ErrorCounter,
    _worker: WorkerGuard,
}

impl Logging {
    /// Starts the thread, and has everything that is logged from now on go there: what the variable of this name says, a level or levels
    /// of crates, or what is logged `by_default`. Nothing of a thread that may not log as it is now is looked at, whatever the variable
    /// says: a line allocates, and waits for others.
    #[must_use]
    pub fn start(variable: &str, by_default: &Targets, may_log: fn() -> bool) -> Self {
        let wanted = std::env::var(variable).ok();
        let asked = wanted.as_deref().map(str::parse::<Targets>);
        let (writer, worker) = NonBlockingBuilder::default()
            .buffered_lines_limit(WAITING)
            .lossy(true)
            .thread_name("log")
            .finish(std::io::stderr());
        let unwritten = writer.error_counter();
        let bound = asked.is_none().then(|| Libraries::new(writer.clone()));
        let lines = layer()
            .with_writer(writer)
            .with_ansi(std::io::stderr().is_terminal())
            .with_target(false)
            // A closed pipe must stop nobody.
            .log_internal_errors(false)
            .with_filter(bound);
        let used = match &asked {
            Some(Ok(asked)) => asked.clone(),
            Some(Err(_)) | None => by_default.clone(),
        };
        // Of what is below the level that somebody wants nobody is asked.
        let most = Layer::<Registry>::max_level_hint(&used).unwrap_or(LevelFilter::TRACE);
        let may_log = DynFilterFn::new(move |_, _| may_log()).with_max_level_hint(most);
        // A test that runs two of them in one process has one already.
        let _ = tracing_subscriber::registry()
            .with(lines)
            .with(used)
            .with(may_log)
            .try_init();
        if let (Some(wanted), Some(Err(why))) = (wanted, asked) {
            tracing::warn!(
                "{variable}=`{wanted}` is not used: {why}; it is a level, as `debug`, or levels of crates, as `info,zenoh=debug`"
            );
        }
        Self {
            unwritten,
            _worker: worker,
        }
    }

    /// Counts the lines that could not be written.
    #[must_use]
    pub fn unwritten(&self) -> ErrorCounter {
        self.unwritten.clone()
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    thread_local! {
        static MAY_LOG: Cell<bool> = const { Cell::new(true) };
    }

    /// The level is asked first, by one load: who may not log is not asked at what nobody wants to see.
    #[test]
    fn a_thread_that_may_not_log_does_not_and_what_is_not_wanted_costs_nothing() {
        let wanted = Targets::new().with_default(LevelFilter::INFO);
        let _logging = Logging::start("CONTRACT_TEST_LOG", &wanted, || MAY_LOG.get());
        assert_eq!(LevelFilter::current(), LevelFilter::INFO);
        for may_log in [true, false, true] {
            MAY_LOG.set(may_log);
            assert_eq!(tracing::enabled!(tracing::Level::INFO), may_log);
            assert!(!tracing::enabled!(tracing::Level::DEBUG));
        }
    }
}
