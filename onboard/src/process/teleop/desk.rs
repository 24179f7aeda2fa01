//! The desk: hears wishes and writes the newest one, while the robot is in its hands. It has no socket and no clock.

use description::geometry::Twist2;
use serde::{Deserialize, Serialize};

use super::status::{Chain, Status, stopping};
use crate::process::ctl::Teleop;
use crate::realtime::clock::SECOND_NS;
use crate::symbols::faults::Fault;
use crate::symbols::values::TeleopWish;
use crate::symbols::wiring::TeleopSymbols;

/// A robot that does not come into the desk's hands in this time does not.
const LENT_NS: u64 = SECOND_NS;
/// Who says nothing for this long has left.
const SILENT_NS: u64 = 5 * SECOND_NS;

/// Why a session is over.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "over", content = "why")]
pub enum Over {
    /// The supervisor has taken the robot back.
    #[error("{0}")]
    TakenBack(String),
    /// No wish came for too long.
    #[error("nothing was heard for 5 s")]
    Silent,
    /// A line is no wish.
    #[error("{0:?} is no wish; expected `FORWARD_M_S TURN_RAD_S`, such as `0.15 -0.1`")]
    Unreadable(String),
}

/// The desk, between sessions or in one.
pub struct Desk {
    symbols: TeleopSymbols,
    said: TeleopWish,
    /// What was heard, before it was armed.
    asked: Twist2,
    armed: bool,
    /// The robot has been in its hands.
    lent: bool,
    begun_ns: u64,
}

impl Desk {
    /// A desk without a session.
    #[must_use]
    pub fn new(symbols: TeleopSymbols) -> Self {
        Self {
            symbols,
            said: TeleopWish::default(),
            asked: Twist2::default(),
            armed: false,
            lent: false,
            begun_ns: 0,
        }
    }

    /// Somebody sits down.
    pub fn open(&mut self, session: u64, teleop: Teleop, now_ns: u64) {
        self.said = TeleopWish {
            session,
            open: 1,
            heard_ns: now_ns,
            wish: Twist2::default(),
            without_borders: u64::from(teleop.without_borders),
        };
        (self.asked, self.armed, self.lent) = (Twist2::default(), false, false);
        self.begun_ns = now_ns;
        self.symbols.wish.write(now_ns, &self.said);
    }

    /// A wish is heard: it counts at once.
    pub fn hear(&mut self, wish: Twist2, now_ns: u64) {
        let stands = wish.v_m_s == 0.0;
        self.armed |= stands && stopping(&self.symbols.faults.read().value).is_none();
        self.asked = wish;
        self.said.wish = if self.armed { wish } else { Twist2::default() };
        self.said.heard_ns = now_ns;
        self.symbols.wish.write(now_ns, &self.said);
    }

    /// The same, as it stands on the socket.
    ///
    /// # Errors
    /// [`Over::Unreadable`]: it is none.
    pub fn hear_line(&mut self, line: &str, now_ns: u64) -> Result<(), Over> {
        let wish = read(line).ok_or_else(|| Over::Unreadable(line.to_owned()))?;
        self.hear(wish, now_ns);
        Ok(())
    }

    /// Says that the desk lives, and looks what the robot does.
    ///
    /// # Errors
    /// [`Over`]: the session is over.
    pub fn look(&mut self, now_ns: u64) -> Result<Status, Over> {
        let faults = self.symbols.faults.read().value;
        if stopping(&faults).is_some() {
            self.armed = false;
            self.said.wish = Twist2::default();
        }
        self.symbols.wish.write(now_ns, &self.said);
        let mode = self.symbols.mode.read().value;
        let mine = mode.teleop == self.said.session;
        self.lent |= mine;
        if !mine && (self.lent || now_ns.saturating_sub(self.begun_ns) > LENT_NS) {
            let stopped = faults.state(Fault::OperatorStop).active != 0;
            let who = if stopped {
                "an operator has stopped the robot"
            } else {
                "the robot was taken back"
            };
            return Err(Over::TakenBack(who.to_owned()));
        }
        if now_ns.saturating_sub(self.said.heard_ns) > SILENT_NS {
            return Err(Over::Silent);
        }
        let pose = self.symbols.pose.read().value;
        let navigation = self.symbols.navigation.read().value;
        let chain = Chain {
            faults: &faults,
            asked_m_s: self.asked.v_m_s,
            release_first: !self.armed,
            navigation: &navigation,
            wanted_m_s: self.symbols.wanted.read().value.command.speed_m_s,
            tube: &self.symbols.tube.read().value,
            safe: &self.symbols.safe.read().value,
        };
        Ok(Status {
            asked: self.asked,
            allowed_m_s: chain.allowed_m_s(),
            limit: chain.limit(),
            moves: self.symbols.odometry.read().value.twist,
            pose: pose.pose,
            std_m: pose.std_x_m.max(pose.std_y_m),
            uncertain: pose.uncertain != 0,
            state: navigation.state.as_str().to_owned(),
            faults: faults
                .active()
                .map(|fault| fault.name().to_owned())
                .collect(),
            release_first: !self.armed,
        })
    }

    /// Who sat here has left: the robot stops.
    pub fn close(&mut self, now_ns: u64) {
        self.said.open = 0;
        self.said.wish = Twist2::default();
        self.symbols.wish.write(now_ns, &self.said);
    }
}

/// A line `FORWARD_M_S TURN_RAD_S`.
fn read(line: &str) -> Option<Twist2> {
    let mut words = line.split_ascii_whitespace();
    let mut number = || {
        words
            .next()?
            .parse()
            .ok()
            .filter(|number: &f64| number.is_finite())
    };
    let wish = Twist2::new(number()?, number()?);
    words.next().is_none().then_some(wish)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wish_is_two_numbers() {
        assert_eq!(read("0.15 -0.1"), Some(Twist2::new(0.15, -0.1)));
        assert_eq!(read("  0 0\r"), Some(Twist2::default()));
        for bad in [
            "",
            "0.1",
            "0.1 0.2 0.3",
            "fast left",
            "nan 0",
            "0 inf",
            "0,1 0",
        ] {
            assert_eq!(read(bad), None, "{bad:?}");
        }
    }
}
