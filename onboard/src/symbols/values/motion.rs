//! The motion that was, is wanted, and is safe.

use description::geometry::{MotionCommand, Twist2};
use serde::{Serialize, Serializer};
use skills::history::OdometrySample;
use skills::tubes::Room;

/// Samples in [`OdometryTrace`]: a third of a second at 5 ms.
pub const TRACE_SAMPLES: usize = 64;

value! {
    /// The last samples of dead reckoning, so that a reader that comes every tenth of a second misses none.
    OdometryTrace, "odometry_trace" {
        /// Samples written since start; the newest lies at `(written - 1) % TRACE_SAMPLES`.
        written: u64,
        /// A ring.
        #[serde(serialize_with = "newest")]
        samples: [OdometrySample; TRACE_SAMPLES],
    }
}

impl OdometryTrace {
    /// Adds a sample in place of the oldest.
    pub fn push(&mut self, sample: OdometrySample) {
        self.samples[(self.written % TRACE_SAMPLES as u64) as usize] = sample;
        self.written += 1;
    }

    /// Samples after the first `seen`, oldest first, as far as they are still there.
    pub fn since(&self, seen: u64) -> impl Iterator<Item = &OdometrySample> {
        let first = seen.max(self.written.saturating_sub(TRACE_SAMPLES as u64));
        (first..self.written).map(|index| &self.samples[(index % TRACE_SAMPLES as u64) as usize])
    }
}

/// The newest sample stands for all.
fn newest<S: Serializer>(
    samples: &[OdometrySample; TRACE_SAMPLES],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Newest {
        samples: usize,
        newest_x_m: f64,
        newest_y_m: f64,
        newest_theta_rad: f64,
    }
    let newest = samples.iter().max_by_key(|sample| sample.stamp_ns);
    let pose = newest.map(|sample| sample.pose).unwrap_or_default();
    Newest {
        samples: samples.len(),
        newest_x_m: pose.x_m,
        newest_y_m: pose.y_m,
        newest_theta_rad: pose.theta_rad,
    }
    .serialize(serializer)
}

value! {
    /// The motion that navigation wants, and the path that it is on.
    WantedMotion, "wanted_motion" {
        /// The motion.
        #[serde(flatten)]
        command: MotionCommand,
        /// Where the robot is relative to its path, and how far from it it may be.
        #[serde(flatten)]
        room: Room,
        /// 1: the newest scan shows nothing where the map has walls, and is not to be believed.
        blind: u64,
        /// 1: somebody drives by hand, and nothing else is to be driven than what that is.
        by_hand: u64,
    }
}

value! {
    /// What a teleoperator wants, while one is connected.
    TeleopWish, "teleop_wish" {
        /// Number of the session, 0 before the first.
        session: u64,
        /// 1 while the teleoperator is connected.
        open: u64,
        /// When the robot heard this wish; it is good for a short time only.
        heard_ns: u64,
        /// The motion.
        #[serde(flatten)]
        wish: Twist2,
        /// 1: somebody sees to it that the robot enters no area that others use, while it does not know its place.
        without_borders: u64,
    }
}

value! {
    /// The motion that the motion tubes let through.
    SafeCommand, "motion_command" {
        /// The motion.
        #[serde(flatten)]
        command: MotionCommand,
        /// 1: stop with the stop deceleration.
        stop: u64,
    }
}

impl SafeCommand {
    /// Drive.
    #[must_use]
    pub fn drive(command: MotionCommand) -> Self {
        Self { command, stop: 0 }
    }

    /// Stop with the stop deceleration, steering held.
    #[must_use]
    pub fn stop(curvature_1_m: f64) -> Self {
        Self {
            command: MotionCommand {
                speed_m_s: 0.0,
                curvature_1_m,
            },
            stop: 1,
        }
    }
}

value! {
    /// What the motion tubes make of the command.
    TubeState, "tube_state" {
        /// 0 free, 1 shifted, 2 slowed, 3 stopped.
        verdict: u64,
        /// Why it is not driven as wanted: number of the reason, see `skills::tubes::Reason`.
        reason: u64,
        /// Index of the chosen tube, `u64::MAX` for none.
        tube: u64,
        /// Free tubes at the last scan.
        free_tubes: u64,
        /// Tubes in the set.
        tubes: u64,
        /// Age of the scan that was judged.
        scan_age_ns: u64,
        /// Time the last evaluation took.
        evaluation_ns: u64,
        /// From the footprint to the nearest point of the last scan.
        clearance_m: f64,
        /// Sequence number of the last scan that repeated the one before although the robot had moved; 0 for none.
        frozen_scan: u64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trace_gives_what_is_new_and_still_there() {
        let mut trace = OdometryTrace::default();
        for stamp_ns in 1..=100 {
            trace.push(OdometrySample {
                stamp_ns,
                ..OdometrySample::default()
            });
        }
        let stamps = |seen| {
            trace
                .since(seen)
                .map(|sample| sample.stamp_ns)
                .collect::<Vec<_>>()
        };
        assert_eq!(stamps(97), [98, 99, 100]);
        assert_eq!((stamps(0).len(), stamps(0)[0]), (TRACE_SAMPLES, 37));
        assert!(stamps(100).is_empty());
    }
}
