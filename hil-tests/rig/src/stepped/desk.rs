//! Who drives a robot by hand on the simulated clock: the robot's desk, and a person with a program at its other end.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use description::geometry::Twist2;
use onboard::process::ctl::Teleop;
use onboard::process::teleop::{BEAT_NS, Desk, Over, Status};
use onboard::symbols::wiring::TeleopSymbols;

/// The person's program says this often what is wanted.
const WISH_NS: u64 = 50_000_000;

/// The desk, and who sits there.
pub struct SteppedDesk {
    desk: Desk,
    /// Number of a session that has begun, 0 for none.
    lent: Arc<AtomicU64>,
    seated: bool,
    /// Whoever has asked for it last has left since.
    left: bool,
    teleop: Teleop,
    wish: Twist2,
    /// The program at the other end says nothing.
    mute: bool,
    beat_ns: u64,
    wish_ns: u64,
    status: Option<Status>,
    over: Option<Over>,
}

impl SteppedDesk {
    pub(super) fn new(symbols: TeleopSymbols) -> Self {
        Self {
            desk: Desk::new(symbols),
            lent: Arc::default(),
            seated: false,
            left: false,
            teleop: Teleop::default(),
            wish: Twist2::default(),
            mute: false,
            beat_ns: 0,
            wish_ns: 0,
            status: None,
            over: None,
        }
    }

    /// Where the number of a session goes that begins.
    pub(super) fn lent(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.lent)
    }

    /// How the person who comes next drives.
    pub fn ask(&mut self, teleop: Teleop) {
        self.teleop = teleop;
        self.left = false;
    }

    /// What the person wants from now on: forward, metres per second, and turning, radians per second. Nothing is wanted by
    /// who lets go of the dead-man.
    pub fn want(&mut self, forward_m_s: f64, turn_rad_s: f64) {
        self.wish = Twist2::new(forward_m_s, turn_rad_s);
        // The program says so at once.
        self.wish_ns = 0;
    }

    /// From now on the program says nothing, though it still wants what it wanted, as when it hangs.
    pub fn fall_silent(&mut self, silent: bool) {
        self.mute = silent;
    }

    /// The program ends, or is killed: its end of the connection closes.
    pub fn leave(&mut self, now_ns: u64) {
        if std::mem::take(&mut self.seated) {
            self.desk.close(now_ns);
        }
        self.left = true;
        self.wish = Twist2::default();
    }

    /// Whether somebody has the robot in hands.
    #[must_use]
    pub fn is_taken(&self) -> bool {
        self.seated
    }

    /// What the robot says.
    #[must_use]
    pub fn status(&self) -> Option<&Status> {
        self.status.as_ref()
    }

    /// Why the last session is over, if the robot said so.
    #[must_use]
    pub fn over(&self) -> Option<&Over> {
        self.over.as_ref()
    }

    pub(super) fn step(&mut self, now_ns: u64) {
        let lent = self.lent.swap(0, Ordering::Relaxed);
        if lent != 0 {
            self.desk.open(lent, self.teleop, now_ns);
            (self.seated, self.over) = (true, None);
            // A program says first that nothing is wanted.
            self.desk.hear(Twist2::default(), now_ns);
            self.wish_ns = now_ns + WISH_NS;
            if self.left {
                // The robot took so long to answer.
                self.leave(now_ns);
            }
        }
        if !self.seated {
            return;
        }
        if !self.mute && now_ns >= self.wish_ns {
            self.wish_ns = now_ns + WISH_NS;
            self.desk.hear(self.wish, now_ns);
        }
        if now_ns < self.beat_ns {
            return;
        }
        self.beat_ns = now_ns + BEAT_NS;
        match self.desk.look(now_ns) {
            Ok(status) => self.status = Some(status),
            Err(over) => {
                self.over = Some(over);
                self.leave(now_ns);
            }
        }
    }
}
