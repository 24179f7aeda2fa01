//! A robot that was moved while nobody measured whereto: pushed between two processes, or while its encoders said what cannot be.

use super::holders::Who;
use super::supervision::Supervisor;
use crate::symbols::faults::Fault;

/// From here on walls that agree with the pose may be others than it takes them for.
const MOVED_M: f64 = 0.5;

impl Supervisor {
    /// Looks at what dead reckoning could not measure since it was looked at last.
    pub(super) fn heed_moved(&mut self, now_ns: u64) {
        let odometry = self.symbols.odometry.read();
        if odometry.stamp_ns == 0 {
            return;
        }
        let unmeasured_m = odometry.value.unmeasured_m;
        let moved_m = unmeasured_m - std::mem::replace(&mut self.unmeasured_m, unmeasured_m);
        if moved_m > MOVED_M {
            tracing::error!(
                "the robot was moved by about {moved_m:.1} m while nobody measured whereto: stopping"
            );
            self.lost = true;
            self.raise(Who::Supervisor, Fault::PlaceUnknown, moved_m, now_ns);
        }
    }
}
