//! What the process before has left to a robot's supervisor, and what this one leaves to the next.

use super::holders::Who;
use super::keeper::Known;
use super::supervision::Supervisor;
use crate::process::checkpoints::{Left, Waited};
use crate::symbols::faults::Fault;
use crate::symbols::values::Mode;

/// Navigation has heard where the robot was put when it takes it to be so near.
const PLACED_M: f64 = 0.5;
const PLACED_RAD: f64 = 0.3;

impl Supervisor {
    /// The process before was stopped, or paused, by people, or by a fault that waits for them: so is this one. Where it ended nobody
    /// knows: this one waits to be told, and only then to be reset, so that a hand may drive it meanwhile.
    pub fn heed(&mut self, left: &Left, now_ns: u64) {
        self.operator_paused = left.paused;
        self.lost = left.lost;
        if let Some(before) = &left.place {
            (self.goes_on, self.unmeasured_m) = (true, before.odometry.unmeasured_m);
        }
        if left.lost {
            self.raise(Who::Supervisor, Fault::PlaceUnknown, 0.0, now_ns);
        } else if left.stopped {
            self.raise(Who::Supervisor, Fault::OperatorStop, 0.0, now_ns);
        }
    }

    /// Keeps where the robot is, as one that is in this mode, or that waits for people whatever its mode is.
    pub(super) fn keep(&mut self, mode: u64, now_ns: u64) {
        if let Some(placed) = self.placed {
            let way = placed.between(self.symbols.whereabouts.read().value.at.pose);
            let is_there = way.x_m.hypot(way.y_m) < PLACED_M && way.theta_rad.abs() < PLACED_RAD;
            self.placed = (!is_there).then_some(placed);
        }
        // One that never had its drive may begin afresh.
        let has_begun = self.symbols.odometry.read().stamp_ns != 0;
        let gone = self.drive_gone().filter(|_| has_begun);
        let waits_for = self.stopped_by().chain(gone);
        let known = Known {
            mode: gone.map_or(mode, |_| Mode::Stopped as u64),
            paused: self.operator_paused,
            lost: self.is_lost() || self.placed.is_some(),
            stopped_by: waits_for.fold(0, |all, fault| all | 1 << fault as u64),
        };
        self.keeper.keep(&mut self.symbols, known, now_ns);
    }

    /// A robot of which a computer that is switched off would know nothing does not drive.
    pub(super) fn judge_keeping(&mut self, now_ns: u64) {
        if self.keeper.is_noted() {
            self.clear(Who::Supervisor, Fault::NoteUnwritten, now_ns);
        } else if self.keeper.is_overdue(now_ns) {
            self.raise(Who::Supervisor, Fault::NoteUnwritten, 0.0, now_ns);
        }
    }

    /// The robot has ended as it was asked to: the next one begins afresh, and waits for what this one waited for.
    pub fn arrive(&mut self) {
        let stopped = self.mode_of_itself() == Mode::Stopped;
        let waited = Waited {
            for_reset: stopped || self.drive_gone().is_some(),
            to_resume: self.operator_paused,
        };
        // Whoever starts it again knows no better where it is.
        if !self.is_lost() && self.placed.is_none() {
            self.keeper.arrive(waited, &self.machine);
        }
    }

    /// The next process is in nobody's hands.
    pub(super) fn mode_to_keep(&self) -> u64 {
        match self.lease {
            Some(_) => self.mode_of_itself() as u64,
            None => self.mode_value.mode,
        }
    }

    /// While the drive is gone nobody knows what is the matter with it: an emergency stop may take its supply. A process that ends then
    /// leaves it to people.
    pub(super) fn drive_gone(&self) -> Option<Fault> {
        let is_gone = self.table.state(Fault::BusLost).active != 0;
        is_gone.then_some(Fault::BusLost)
    }
}
