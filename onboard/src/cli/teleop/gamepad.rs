//! The dead-man of a gamepad: a shoulder button. The left stick drives, forward and aside.
//!
//! Events of `/dev/input` are read without a C library. A gamepad that is unplugged ends it, and the robot stops. One whose
//! radio is lost may say nothing for seconds; so the dead-man counts as let go when no event has come for [`FELT`].

use std::fmt;
use std::io::ErrorKind;
use std::time::{Duration, Instant};

use description::geometry::Twist2;
use evdev::{AbsInfo, AbsoluteAxisCode, Device, EventSummary, InputEvent, KeyCode};

use super::input::Input;

/// A hand that holds a stick moves it a little at least this often.
const FELT: Duration = Duration::from_secs(1);
/// Full deflection. The robot may allow less.
const SPEED_M_S: f64 = 0.4;
const CURVE_1_M: f64 = 2.5;
/// A stick nearer to its middle than this share is at rest.
const REST: f64 = 0.15;

/// The dead-man: one of these is held.
const SHOULDERS: [KeyCode; 4] = [
    KeyCode::BTN_TL,
    KeyCode::BTN_TR,
    KeyCode::BTN_TL2,
    KeyCode::BTN_TR2,
];

/// Values of a stick's axis.
#[derive(Clone, Copy, Debug)]
struct Axis {
    least: f64,
    most: f64,
    value: f64,
}

impl Axis {
    fn of(info: AbsInfo) -> Self {
        Self {
            least: f64::from(info.minimum()),
            most: f64::from(info.maximum()),
            value: f64::from(info.value()),
        }
    }

    /// From -1 to 1, 0 around the middle.
    fn share(&self) -> f64 {
        let half = (self.most - self.least) / 2.0;
        let share = (self.value - self.least - half) / half;
        // Also what is no number, of an axis without a range.
        if share.abs() >= REST {
            share.clamp(-1.0, 1.0)
        } else {
            0.0
        }
    }
}

/// What a gamepad's events have said so far.
#[derive(Clone, Debug)]
struct Pad {
    forward: Axis,
    aside: Axis,
    held: [bool; SHOULDERS.len()],
    felt: Instant,
}

impl Pad {
    fn new(forward: Axis, aside: Axis, now: Instant) -> Self {
        Self {
            forward,
            aside,
            held: [false; SHOULDERS.len()],
            felt: now,
        }
    }

    fn take(&mut self, event: InputEvent, now: Instant) {
        match event.destructure() {
            EventSummary::Key(_, key, value) => {
                let shoulder = SHOULDERS.iter().position(|own| *own == key);
                if let Some(held) = shoulder.and_then(|own| self.held.get_mut(own)) {
                    *held = value != 0;
                }
            }
            EventSummary::AbsoluteAxis(_, AbsoluteAxisCode::ABS_Y, value) => {
                self.forward.value = value.into();
            }
            EventSummary::AbsoluteAxis(_, AbsoluteAxisCode::ABS_X, value) => {
                self.aside.value = value.into();
            }
            _ => return,
        }
        self.felt = now;
    }

    fn wish(&self, now: Instant) -> Twist2 {
        if !self.held.contains(&true) || now - self.felt > FELT {
            return Twist2::default();
        }
        // Sticks count backward and to the right.
        let speed_m_s = -self.forward.share() * SPEED_M_S;
        Twist2::new(speed_m_s, -self.aside.share() * CURVE_1_M * speed_m_s)
    }
}

/// Why there is no gamepad to drive with.
#[derive(Debug)]
pub(super) enum GamepadError {
    NotFound,
    Unusable(String),
    Unplugged(std::io::Error),
}

impl fmt::Display for GamepadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFound => f.write_str(
                "no gamepad with a stick and shoulder buttons is in /dev/input; plug one in, or see that this user may read it",
            ),
            Self::Unusable(why) => write!(f, "the gamepad cannot be used: {why}"),
            Self::Unplugged(error) => write!(f, "the gamepad is gone, and the robot stops: {error}"),
        }
    }
}

/// A gamepad.
pub(super) struct Gamepad {
    device: Device,
    pad: Pad,
}

impl Gamepad {
    /// Opens the one of this path, or with an empty one the first there is.
    pub(super) fn open(path: &str) -> Result<Self, GamepadError> {
        if path.is_empty() {
            let mut all = evdev::enumerate().filter_map(|(_, device)| Self::of(device).ok());
            return all.next().ok_or(GamepadError::NotFound);
        }
        let device = Device::open(path)
            .map_err(|error| GamepadError::Unusable(format!("{path}: {error}")))?;
        Self::of(device)
    }

    fn of(device: Device) -> Result<Self, GamepadError> {
        let unusable = |error: std::io::Error| GamepadError::Unusable(error.to_string());
        let keys = device.supported_keys();
        let has_shoulder = keys.is_some_and(|keys| SHOULDERS.iter().any(|key| keys.contains(*key)));
        let axis = |code: AbsoluteAxisCode| {
            let info = device
                .get_absinfo()
                .map_err(unusable)?
                .find(|(own, _)| *own == code);
            info.map(|(_, info)| Axis::of(info))
                .ok_or_else(|| GamepadError::Unusable(format!("it has no {code:?}")))
        };
        if !has_shoulder {
            return Err(GamepadError::Unusable(
                "it has no shoulder button".to_owned(),
            ));
        }
        let pad = Pad::new(
            axis(AbsoluteAxisCode::ABS_Y)?,
            axis(AbsoluteAxisCode::ABS_X)?,
            Instant::now(),
        );
        device.set_nonblocking(true).map_err(unusable)?;
        Ok(Self { device, pad })
    }

    /// Takes in what has come.
    pub(super) fn poll(&mut self, now: Instant) -> Result<Input, GamepadError> {
        match self.device.fetch_events() {
            Ok(events) => events.for_each(|event| self.pad.take(event, now)),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {}
            Err(error) => return Err(GamepadError::Unplugged(error)),
        }
        Ok(Input::Wants(self.pad.wish(now)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use evdev::EventType;

    /// Events as a gamepad of the `xpad` driver sends them: type, code, value.
    const PRESS_LEFT_SHOULDER: [u16; 2] = [0x01, 0x136];
    const STICK_X: [u16; 2] = [0x03, 0x00];
    const STICK_Y: [u16; 2] = [0x03, 0x01];
    const RIGHT_STICK_X: [u16; 2] = [0x03, 0x03];

    fn axis() -> Axis {
        Axis {
            least: -32768.0,
            most: 32767.0,
            value: 0.0,
        }
    }

    fn pad(now: Instant) -> Pad {
        Pad::new(axis(), axis(), now)
    }

    fn take(pad: &mut Pad, [kind, code]: [u16; 2], value: i32, now: Instant) {
        pad.take(InputEvent::new(EventType(kind).0, code, value), now);
    }

    #[test]
    fn the_stick_drives_while_a_shoulder_button_is_held() {
        let now = Instant::now();
        let mut pad = pad(now);
        take(&mut pad, STICK_Y, -32768, now);
        assert_eq!(pad.wish(now), Twist2::default(), "no dead-man");
        take(&mut pad, PRESS_LEFT_SHOULDER, 1, now);
        assert_eq!(pad.wish(now), Twist2::new(0.4, 0.0));
        take(&mut pad, STICK_X, -32768, now);
        assert_eq!(pad.wish(now), Twist2::new(0.4, 1.0), "to the left");
        take(&mut pad, STICK_Y, 32767, now);
        assert_eq!(
            pad.wish(now),
            Twist2::new(-0.4, -1.0),
            "backward to the left"
        );
        take(&mut pad, PRESS_LEFT_SHOULDER, 0, now);
        assert_eq!(pad.wish(now), Twist2::default(), "let go");
    }

    #[test]
    fn a_stick_at_rest_wants_nothing() {
        let now = Instant::now();
        let mut pad = pad(now);
        take(&mut pad, PRESS_LEFT_SHOULDER, 1, now);
        for value in [0, 4000, -4000] {
            take(&mut pad, STICK_Y, value, now);
            assert_eq!(pad.wish(now), Twist2::default());
        }
        take(&mut pad, RIGHT_STICK_X, 32767, now);
        assert_eq!(pad.wish(now), Twist2::default());
        let flat = Axis {
            least: 0.0,
            most: 0.0,
            value: 0.0,
        };
        assert_eq!(flat.share(), 0.0);
    }

    #[test]
    fn a_gamepad_that_is_not_felt_any_more_lets_go() {
        let now = Instant::now();
        let mut pad = pad(now);
        take(&mut pad, PRESS_LEFT_SHOULDER, 1, now);
        take(&mut pad, STICK_Y, -20_000, now);
        assert!(pad.wish(now + FELT).v_m_s > 0.0);
        let later = now + FELT + Duration::from_millis(1);
        assert_eq!(pad.wish(later), Twist2::default());
        take(&mut pad, STICK_Y, -20_100, later);
        assert!(pad.wish(later).v_m_s > 0.0);
    }

    #[test]
    fn what_is_no_gamepad_is_refused_with_a_reason() {
        let why = Gamepad::open("/dev/null")
            .err()
            .map(|error| error.to_string());
        assert!(why.is_some_and(|why| why.contains("cannot be used: /dev/null")));
    }
}
