//! The dead-man of a keyboard.
//!
//! A plain terminal tells no release: a key counts as held while it repeats, so that a robot begins to drive when the
//! repetition has begun and stops [`REPEAT`] after the last one. A terminal with the kitty keyboard protocol tells press and
//! release; there, too, a key that has not repeated for [`LOST`] counts as let go, for a release can get lost.

use std::io;
use std::time::{Duration, Instant};

use crossterm::event::{Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers, poll, read};
use description::geometry::Twist2;

use super::input::Input;

/// Keys that are held repeat at least this often.
const REPEAT: Duration = Duration::from_millis(200);
/// The first repetition of a key comes before this.
const LOST: Duration = Duration::from_millis(1000);

/// Speeds that can be chosen, metres per second. The robot may allow less.
const SPEEDS_M_S: [f64; 6] = [0.05, 0.10, 0.15, 0.20, 0.30, 0.40];
/// Curves that can be chosen, 1/m. The robot may allow less.
const CURVES_1_M: [f64; 3] = [0.5, 1.25, 2.5];

/// How fast, and on what curves, the keys drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Setting {
    pub(super) speed_m_s: f64,
    pub(super) curve_1_m: f64,
}

/// A direction to drive in: forward or backward, and to which side.
type Direction = (f64, f64);

/// Which key is held.
#[derive(Clone, Copy, Debug)]
struct Held {
    direction: Direction,
    seen: Instant,
    /// It has repeated, or the terminal would tell its release.
    sure: bool,
}

/// The keyboard.
pub(super) struct Keyboard {
    tells_releases: bool,
    held: Option<Held>,
    speed: usize,
    curve: usize,
}

impl Keyboard {
    pub(super) fn new(tells_releases: bool) -> Self {
        Self {
            tells_releases,
            held: None,
            speed: 1,
            curve: 1,
        }
    }

    pub(super) fn setting(&self) -> Setting {
        Setting {
            speed_m_s: SPEEDS_M_S[self.speed],
            curve_1_m: CURVES_1_M[self.curve],
        }
    }

    /// Takes in what was typed, after waiting for at most `patience`.
    pub(super) fn poll(&mut self, patience: Duration) -> io::Result<Input> {
        let mut patience = patience;
        let mut resets = false;
        // All that has come counts, so that old repetitions do not pile up.
        while poll(patience)? {
            patience = Duration::ZERO;
            match self.take(&read()?, Instant::now()) {
                Input::Leaves => return Ok(Input::Leaves),
                Input::Reset => resets = true,
                Input::Wants(_) | Input::Nothing => {}
            }
        }
        if resets {
            self.held = None;
            return Ok(Input::Reset);
        }
        Ok(Input::Wants(self.wish(Instant::now())))
    }

    /// One event of the terminal.
    fn take(&mut self, event: &Event, now: Instant) -> Input {
        match event {
            Event::Key(key) => self.take_key(key, now),
            Event::FocusLost => {
                self.held = None;
                Input::Nothing
            }
            _ => Input::Nothing,
        }
    }

    fn take_key(&mut self, key: &KeyEvent, now: Instant) -> Input {
        let direction = direction(key.code);
        if key.kind == KeyEventKind::Release {
            // The newest key counts, whatever else is let go.
            if self
                .held
                .is_some_and(|held| Some(held.direction) == direction)
            {
                self.held = None;
            }
            return Input::Nothing;
        }
        if let Some(direction) = direction {
            let again = { self.held }.filter(|held| held.direction == direction);
            let repeats = again.is_some_and(|held| now - held.seen <= REPEAT);
            self.held = Some(Held {
                direction,
                seen: now,
                sure: self.tells_releases || repeats,
            });
            return Input::Nothing;
        }
        // Whatever else is pressed lets go.
        self.held = None;
        let ends = key.modifiers.contains(KeyModifiers::CONTROL) && key.code == KeyCode::Char('c');
        match key.code {
            _ if ends => return Input::Leaves,
            KeyCode::Esc | KeyCode::Char('x') => return Input::Leaves,
            KeyCode::Char('r') if key.kind == KeyEventKind::Press => return Input::Reset,
            KeyCode::Char('+' | '=') => self.speed = (self.speed + 1).min(SPEEDS_M_S.len() - 1),
            KeyCode::Char('-') => self.speed = self.speed.saturating_sub(1),
            KeyCode::Char('1') => self.curve = 0,
            KeyCode::Char('2') => self.curve = 1,
            KeyCode::Char('3') => self.curve = 2,
            _ => {}
        }
        Input::Nothing
    }

    /// What is wanted now.
    fn wish(&mut self, now: Instant) -> Twist2 {
        let longest = if self.tells_releases { LOST } else { REPEAT };
        let Some(held) = self
            .held
            .filter(|held| held.sure && now - held.seen <= longest)
        else {
            return Twist2::default();
        };
        let (forward, left) = held.direction;
        let setting = self.setting();
        let speed_m_s = forward * setting.speed_m_s;
        // As with a steering wheel, backward as well: the robot goes to the side of the key.
        Twist2::new(speed_m_s, speed_m_s * left * setting.curve_1_m)
    }
}

/// The direction that a key stands for.
fn direction(code: KeyCode) -> Option<Direction> {
    Some(match code {
        KeyCode::Char('w' | 'W') | KeyCode::Up => (1.0, 0.0),
        KeyCode::Char('q' | 'Q') => (1.0, 1.0),
        KeyCode::Char('e' | 'E') => (1.0, -1.0),
        KeyCode::Char('s' | 'S') | KeyCode::Down => (-1.0, 0.0),
        KeyCode::Char('a' | 'A') => (-1.0, 1.0),
        KeyCode::Char('d' | 'D') => (-1.0, -1.0),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(code: char, kind: KeyEventKind) -> Event {
        Event::Key(KeyEvent::new_with_kind(
            KeyCode::Char(code),
            KeyModifiers::NONE,
            kind,
        ))
    }

    fn press(code: char) -> Event {
        key(code, KeyEventKind::Press)
    }

    const fn ms(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    #[test]
    fn on_a_plain_terminal_a_key_is_held_while_it_repeats() {
        let (mut keyboard, begin) = (Keyboard::new(false), Instant::now());
        keyboard.take(&press('w'), begin);
        assert_eq!(
            keyboard.wish(begin),
            Twist2::default(),
            "a tap moves nothing"
        );
        // The first repetition comes late, the others fast.
        keyboard.take(&press('w'), begin + ms(500));
        assert_eq!(keyboard.wish(begin + ms(500)), Twist2::default());
        keyboard.take(&press('w'), begin + ms(533));
        assert_eq!(keyboard.wish(begin + ms(533)), Twist2::new(0.1, 0.0));
        assert_eq!(keyboard.wish(begin + ms(733)), Twist2::new(0.1, 0.0));
        assert_eq!(keyboard.wish(begin + ms(734)), Twist2::default(), "let go");
        keyboard.take(&press('w'), begin + ms(800));
        assert_eq!(keyboard.wish(begin + ms(800)), Twist2::default());
    }

    #[test]
    fn another_key_lets_go_on_a_plain_terminal() {
        let (mut keyboard, begin) = (Keyboard::new(false), Instant::now());
        for at in [0, 30] {
            keyboard.take(&press('w'), begin + ms(at));
        }
        assert!(keyboard.wish(begin + ms(30)).v_m_s > 0.0);
        keyboard.take(&press('s'), begin + ms(60));
        assert_eq!(keyboard.wish(begin + ms(60)), Twist2::default());
        keyboard.take(&press('s'), begin + ms(90));
        assert_eq!(keyboard.wish(begin + ms(90)), Twist2::new(-0.1, 0.0));
        keyboard.take(&press(' '), begin + ms(100));
        assert_eq!(keyboard.wish(begin + ms(100)), Twist2::default());
    }

    #[test]
    fn where_releases_are_told_a_key_is_held_from_press_to_release() {
        let (mut keyboard, begin) = (Keyboard::new(true), Instant::now());
        keyboard.take(&press('q'), begin);
        assert_eq!(keyboard.wish(begin + ms(600)), Twist2::new(0.1, 0.125));
        assert_eq!(
            keyboard.wish(begin + ms(1001)),
            Twist2::default(),
            "a lost release"
        );
        keyboard.take(&key('q', KeyEventKind::Repeat), begin + ms(1010));
        assert!(keyboard.wish(begin + ms(1020)).v_m_s > 0.0);
        keyboard.take(&key('q', KeyEventKind::Release), begin + ms(1030));
        assert_eq!(keyboard.wish(begin + ms(1030)), Twist2::default());
        keyboard.take(&press('a'), begin + ms(1100));
        keyboard.take(&press('w'), begin + ms(1110));
        keyboard.take(&key('a', KeyEventKind::Release), begin + ms(1120));
        assert!(
            keyboard.wish(begin + ms(1120)).v_m_s > 0.0,
            "the newest key is held"
        );
        keyboard.take(&Event::FocusLost, begin + ms(1130));
        assert_eq!(keyboard.wish(begin + ms(1130)), Twist2::default());
    }

    #[test]
    fn speed_and_curve_are_chosen_and_keys_end_it() {
        let (mut keyboard, now) = (Keyboard::new(true), Instant::now());
        for code in ['+', '+', '3', 'd'] {
            assert_eq!(keyboard.take(&press(code), now), Input::Nothing);
        }
        // Backward to the right, it turns to the left.
        let wish = keyboard.wish(now);
        assert!((wish.v_m_s, wish.omega_rad_s) == (-0.2, 0.5), "{wish:?}");
        assert_eq!(keyboard.take(&press('r'), now), Input::Reset);
        assert_eq!(keyboard.take(&press('x'), now), Input::Leaves);
        let control = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
        assert_eq!(keyboard.take(&Event::Key(control), now), Input::Leaves);
    }
}
