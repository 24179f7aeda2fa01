//! The terminal, as long as somebody drives on it. It is given back as it was in every end but SIGKILL.

use std::io::{self, Write, stdout};
use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

use crossterm::cursor::{Hide, MoveTo, Show};
use crossterm::event::{
    DisableFocusChange, EnableFocusChange, KeyboardEnhancementFlags, PopKeyboardEnhancementFlags,
    PushKeyboardEnhancementFlags,
};
use crossterm::style::Print;
use crossterm::terminal::{
    Clear, ClearType, EnterAlternateScreen, LeaveAlternateScreen, disable_raw_mode,
    enable_raw_mode, size, supports_keyboard_enhancement,
};
use crossterm::{execute, queue};

/// The terminal is ours.
static TAKEN: AtomicBool = AtomicBool::new(false);
/// It tells releases of keys.
static ENHANCED: AtomicBool = AtomicBool::new(false);
static HOOK: Once = Once::new();

/// The terminal, ours until this is dropped.
pub(super) struct Terminal;

impl Terminal {
    /// Takes it. A panic gives it back before it says what happened.
    pub(super) fn take() -> io::Result<Self> {
        HOOK.call_once(|| {
            let before = std::panic::take_hook();
            std::panic::set_hook(Box::new(move |panic| {
                give_back();
                before(panic);
            }));
        });
        enable_raw_mode()?;
        TAKEN.store(true, Ordering::Relaxed);
        let terminal = Self;
        // A terminal that does not answer is a plain one.
        let enhanced = supports_keyboard_enhancement().unwrap_or(false);
        execute!(stdout(), EnterAlternateScreen, Hide, EnableFocusChange)?;
        if enhanced {
            let flags = KeyboardEnhancementFlags::DISAMBIGUATE_ESCAPE_CODES
                | KeyboardEnhancementFlags::REPORT_EVENT_TYPES
                | KeyboardEnhancementFlags::REPORT_ALL_KEYS_AS_ESCAPE_CODES;
            execute!(stdout(), PushKeyboardEnhancementFlags(flags))?;
            ENHANCED.store(true, Ordering::Relaxed);
        }
        Ok(terminal)
    }

    /// Whether it tells releases of keys.
    pub(super) fn tells_releases(&self) -> bool {
        ENHANCED.load(Ordering::Relaxed)
    }

    /// Shows lines in place of those before.
    pub(super) fn show(&mut self, lines: &[String]) -> io::Result<()> {
        let mut out = stdout().lock();
        // Not every terminal knows how wide it is.
        let columns = size().map_or(0, |(columns, _)| usize::from(columns));
        let columns = if columns == 0 { 80 } else { columns };
        queue!(out, MoveTo(0, 0))?;
        for line in lines {
            let line: String = line.chars().take(columns).collect();
            queue!(
                out,
                Print(line),
                Clear(ClearType::UntilNewLine),
                Print("\r\n")
            )?;
        }
        queue!(out, Clear(ClearType::FromCursorDown))?;
        out.flush()
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        give_back();
    }
}

/// Gives it back, once.
fn give_back() {
    if !TAKEN.swap(false, Ordering::Relaxed) {
        return;
    }
    let mut out = stdout();
    // A terminal that is gone needs nothing.
    if ENHANCED.swap(false, Ordering::Relaxed) {
        let _ = execute!(out, PopKeyboardEnhancementFlags);
    }
    let _ = execute!(out, DisableFocusChange, Show, LeaveAlternateScreen);
    let _ = disable_raw_mode();
}
