//! A panic anywhere stops the robot: it raises a flag that the drive activity obeys.
//!
//! The flag is one robot's: a process may step several robots on a simulated clock.

use std::backtrace::{Backtrace, BacktraceStatus};
use std::fmt::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use crate::realtime::guard;

/// So many bytes of what a real-time thread has to say are kept.
const MOST_BYTES: usize = 512;

/// Whether a part of one robot's program has panicked. Its clones are one flag; once raised it stays.
#[derive(Clone, Debug, Default)]
pub struct Panicked(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    raised: AtomicBool,
    words: Mutex<Words>,
}

impl Panicked {
    /// A part has panicked. Takes no lock, and does not allocate.
    pub fn raise(&self) {
        self.0.raised.store(true, Ordering::SeqCst);
    }

    /// Whether any has.
    #[must_use]
    pub fn is_raised(&self) -> bool {
        self.0.raised.load(Ordering::Relaxed)
    }

    /// Keeps what a real-time thread has to say until somebody has time to log it: the first one's words. Waits for nobody, and does
    /// not allocate.
    fn keep(&self, words: fmt::Arguments<'_>) {
        if let Ok(mut kept) = self.0.words.try_lock()
            && kept.length == 0
        {
            // What is too long is cut.
            let _ = kept.write_fmt(words);
        }
    }

    /// What a real-time thread had to say, once.
    pub fn take_words(&self) -> Option<String> {
        let mut kept = self.0.words.lock().unwrap_or_else(PoisonError::into_inner);
        let length = std::mem::take(&mut kept.length);
        (length > 0).then(|| String::from_utf8_lossy(&kept.bytes[..length]).into_owned())
    }
}

struct Words {
    bytes: [u8; MOST_BYTES],
    length: usize,
}

impl Default for Words {
    fn default() -> Self {
        Self {
            bytes: [0; MOST_BYTES],
            length: 0,
        }
    }
}

impl fmt::Debug for Words {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bytes", self.length)
    }
}

impl Write for Words {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let left = &mut self.bytes[self.length..];
        let fits = text.len().min(left.len());
        left[..fits].copy_from_slice(&text.as_bytes()[..fits]);
        self.length += fits;
        if fits < text.len() {
            return Err(fmt::Error);
        }
        Ok(())
    }
}

/// Installs the hook of a process that is one robot: whatever thread panics raises the flag, before it says anything. What the hook has
/// to say goes to the log: printing it here could hold up the thread that has to stop the robot. A real-time thread leaves even that to
/// the supervisor.
pub fn install_hook(panicked: &Panicked) {
    let panicked = panicked.clone();
    std::panic::set_hook(Box::new(move |info| {
        panicked.raise();
        let real_time = guard::lift_for_panic();
        let thread = std::thread::current();
        let name = thread.name().unwrap_or("?");
        if real_time {
            panicked.keep(format_args!("thread '{name}' {info}"));
            return;
        }
        let trace = Backtrace::capture();
        if trace.status() == BacktraceStatus::Captured {
            tracing::error!("thread '{name}' {info}\n{trace}");
        } else {
            tracing::error!("thread '{name}' {info}");
        }
    }));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_words_of_a_real_time_thread_are_kept_once_and_cut_where_they_are_too_long() {
        let panicked = Panicked::default();
        assert_eq!(panicked.take_words(), None);
        panicked.keep(format_args!("thread '{}' panicked", "fieldbus"));
        panicked.keep(format_args!("another one"));
        let words = panicked.clone().take_words();
        assert_eq!(words.as_deref(), Some("thread 'fieldbus' panicked"));
        assert_eq!(panicked.take_words(), None);
        // Its last letter has two bytes, of which one fits.
        let long = "x".repeat(MOST_BYTES - 1) + "ä and more";
        panicked.keep(format_args!("{long}"));
        let words = panicked.take_words().expect("kept");
        assert!(words.starts_with("xxx") && words.len() <= MOST_BYTES + 2);
    }

    #[test]
    fn whoever_keeps_words_waits_for_nobody() {
        let panicked = Panicked::default();
        let held = panicked.0.words.lock().expect("not poisoned");
        panicked.keep(format_args!("in vain"));
        drop(held);
        assert_eq!(panicked.take_words(), None);
    }
}
