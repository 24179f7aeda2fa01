//! A robot that was moved while nobody measured whereto: pushed between two processes, or while its encoders said what cannot be.

use super::ending::ENCODER_AGE_NS;
use super::holders::Who;
use super::supervision::Supervisor;
use crate::symbols::faults::Fault;

/// From here on walls that agree with the pose may be others than it takes them for.
const MOVED_M: f64 = 0.5;

/// Between two processes nobody is there who would be asked: what the second one remembers of the floor is worth nothing from here on.
const MOVED_UNSEEN_M: f64 = 0.05;

impl Supervisor {
    /// What moves the robot now shows only later, or never.
    pub(super) fn is_unmeasured(&mut self, now_ns: u64) -> bool {
        let is_active = |fault: &Fault| self.table.state(*fault).active != 0;
        let counted_ns = self.symbols.odometry.read().stamp_ns;
        let is_old = counted_ns != 0 && now_ns.saturating_sub(counted_ns) > ENCODER_AGE_NS;
        is_old || [Fault::BusLost, Fault::DriveStalled].iter().any(is_active)
    }

    /// Looks at what dead reckoning could not measure since it was looked at last.
    pub(super) fn heed_moved(&mut self, now_ns: u64) {
        let odometry = self.symbols.odometry.read();
        if odometry.stamp_ns == 0 {
            return;
        }
        let unmeasured_m = odometry.value.unmeasured_m;
        let moved_m = unmeasured_m - std::mem::replace(&mut self.unmeasured_m, unmeasured_m);
        let most_m = match std::mem::take(&mut self.goes_on) {
            true => MOVED_UNSEEN_M,
            false => MOVED_M,
        };
        if moved_m > most_m {
            tracing::error!(
                "the robot was moved by about {moved_m:.2} m while nobody measured whereto: stopping"
            );
            self.lost = true;
            self.raise(Who::Supervisor, Fault::PlaceUnknown, moved_m, now_ns);
        }
    }
}
