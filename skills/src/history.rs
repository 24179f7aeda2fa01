//! The last few seconds of odometry, so that a measurement can be placed where the robot was when it was taken.
//!
//! A ring of fixed capacity: `push` overwrites the oldest entry, `at` interpolates. Neither allocates; both may run
//! in a real-time thread. Poses are of `base_link` in `odom`, stamps in nanoseconds of the monotonic clock.

use description::geometry::{Pose2, Twist2};
use thiserror::Error;

/// How far past the newest entry `at` extrapolates with the newest twist.
pub const MAX_EXTRAPOLATION_NS: u64 = 50_000_000;

/// Entries a history holds unless told otherwise: 2.5 s at 5 ms.
pub const DEFAULT_CAPACITY: usize = 512;

/// Why an entry was not taken.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum HistoryError {
    /// The stamp is not newer than the newest entry.
    #[error("odometry stamp {stamp_ns} ns is not after the newest, {newest_ns} ns")]
    NotAfter { stamp_ns: u64, newest_ns: u64 },
    /// A number is NaN or infinite.
    #[error("odometry at {stamp_ns} ns is not finite")]
    NotFinite { stamp_ns: u64 },
}

/// Odometry at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "symbols", derive(bytemuck::Pod, bytemuck::Zeroable))]
#[repr(C)]
pub struct OdometrySample {
    /// When it was true, monotonic.
    pub stamp_ns: u64,
    /// `base_link` in `odom`.
    pub pose: Pose2,
    /// Of `base_link`.
    pub twist: Twist2,
}

/// A bounded history of odometry, ordered by time.
#[derive(Clone, Debug)]
pub struct OdometryHistory {
    entries: Box<[OdometrySample]>,
    /// Where the next entry goes.
    next: usize,
    len: usize,
    rejected: u64,
}

impl Default for OdometryHistory {
    fn default() -> Self {
        Self::new(DEFAULT_CAPACITY)
    }
}

impl OdometryHistory {
    /// An empty history of at least two entries' capacity. Allocates, once.
    #[must_use]
    pub fn new(capacity: usize) -> Self {
        Self {
            entries: vec![OdometrySample::default(); capacity.max(2)].into_boxed_slice(),
            next: 0,
            len: 0,
            rejected: 0,
        }
    }

    /// Takes the newest pose and twist; the oldest entry goes when the ring is full. What is refused is counted.
    ///
    /// # Errors
    /// [`HistoryError`] when a number is not finite or the stamp is not after the newest; the history stays as it was.
    pub fn push(&mut self, stamp_ns: u64, pose: Pose2, twist: Twist2) -> Result<(), HistoryError> {
        if !pose.is_finite() || !twist.is_finite() {
            self.rejected += 1;
            return Err(HistoryError::NotFinite { stamp_ns });
        }
        let newest_ns = self.newest_entry().map(|newest| newest.stamp_ns);
        if let Some(newest_ns) = newest_ns
            && stamp_ns <= newest_ns
        {
            self.rejected += 1;
            return Err(HistoryError::NotAfter {
                stamp_ns,
                newest_ns,
            });
        }
        self.entries[self.next] = OdometrySample {
            stamp_ns,
            pose,
            twist,
        };
        self.next = (self.next + 1) % self.entries.len();
        self.len = (self.len + 1).min(self.entries.len());
        Ok(())
    }

    /// The pose at a time: interpolated between entries, extrapolated at most [`MAX_EXTRAPOLATION_NS`] past the
    /// newest, `None` before the oldest or later than that.
    #[must_use]
    pub fn at(&self, stamp_ns: u64) -> Option<Pose2> {
        let newest = self.newest_entry()?;
        if stamp_ns >= newest.stamp_ns {
            let ahead_ns = stamp_ns - newest.stamp_ns;
            return (ahead_ns <= MAX_EXTRAPOLATION_NS)
                .then(|| newest.pose.advance(newest.twist, ahead_ns as f64 * 1e-9));
        }
        // The first entry, counted from the oldest, that is later than the stamp.
        let (mut low, mut high) = (0, self.len - 1);
        while low < high {
            let middle = (low + high) / 2;
            if self.entry(middle).stamp_ns > stamp_ns {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        let after = self.entry(low);
        let before = self.entry(low.checked_sub(1)?);
        let span_ns = (after.stamp_ns - before.stamp_ns) as f64;
        let fraction = (stamp_ns - before.stamp_ns) as f64 / span_ns;
        Some(before.pose.interpolate(after.pose, fraction))
    }

    /// The newest stamp, pose and twist.
    #[must_use]
    pub fn newest(&self) -> Option<(u64, Pose2, Twist2)> {
        self.newest_entry()
            .map(|entry| (entry.stamp_ns, entry.pose, entry.twist))
    }

    /// The oldest stamp that can still be answered.
    #[must_use]
    pub fn oldest_stamp_ns(&self) -> Option<u64> {
        (self.len > 0).then(|| self.entry(0).stamp_ns)
    }

    /// Entries held.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Nothing was pushed yet.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Entries refused since construction.
    #[must_use]
    pub fn rejected(&self) -> u64 {
        self.rejected
    }

    /// Forgets all entries, as when dead reckoning restarts.
    pub fn clear(&mut self) {
        self.next = 0;
        self.len = 0;
    }

    /// OdometrySample `index`, counted from the oldest.
    fn entry(&self, index: usize) -> &OdometrySample {
        let capacity = self.entries.len();
        &self.entries[(self.next + capacity - self.len + index) % capacity]
    }

    fn newest_entry(&self) -> Option<&OdometrySample> {
        (self.len > 0).then(|| self.entry(self.len - 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn straight(entries: u64, capacity: usize) -> OdometryHistory {
        let mut history = OdometryHistory::new(capacity);
        for i in 1..=entries {
            let pose = Pose2::new(0.002 * i as f64, 0.0, 0.0);
            history
                .push(5 * MS * i, pose, Twist2::new(0.4, 0.0))
                .unwrap();
        }
        history
    }

    #[test]
    fn between_two_entries_lies_the_interpolated_pose() {
        let history = straight(10, 512);
        let pose = history.at(12_500_000).unwrap();
        assert!((pose.x_m - 0.005).abs() < 1e-12);
        assert_eq!(history.at(5 * MS).unwrap().x_m, 0.002);
        assert_eq!(history.at(50 * MS).unwrap().x_m, 0.02);
    }

    #[test]
    fn past_the_newest_it_extrapolates_a_little() {
        let history = straight(10, 512);
        assert!((history.at(60 * MS).unwrap().x_m - 0.024).abs() < 1e-12);
        assert_eq!(history.at(50 * MS + MAX_EXTRAPOLATION_NS + 1), None);
    }

    #[test]
    fn before_the_oldest_there_is_nothing() {
        let history = straight(10, 4);
        assert_eq!(history.len(), 4);
        assert_eq!(history.oldest_stamp_ns(), Some(35 * MS));
        assert_eq!(history.at(35 * MS - 1), None);
        assert!(history.at(35 * MS).is_some());
        assert_eq!(OdometryHistory::default().at(0), None);
    }

    #[test]
    fn the_ring_answers_the_same_wherever_it_starts() {
        for entries in 1..40 {
            let history = straight(entries, 8);
            let newest_ns = 5 * MS * entries;
            for back in 0..entries.min(7) {
                let pose = history.at(newest_ns - 5 * MS * back).unwrap();
                assert!((pose.x_m - 0.002 * (entries - back) as f64).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn time_backwards_and_nonsense_are_refused_and_counted() {
        let mut history = straight(3, 8);
        let twist = Twist2::default();
        assert!(matches!(
            history.push(15 * MS, Pose2::IDENTITY, twist),
            Err(HistoryError::NotAfter { .. })
        ));
        assert!(matches!(
            history.push(20 * MS, Pose2::new(f64::NAN, 0.0, 0.0), twist),
            Err(HistoryError::NotFinite { .. })
        ));
        assert_eq!((history.rejected(), history.len()), (2, 3));
    }

    #[test]
    fn the_angle_takes_the_short_way() {
        let mut history = OdometryHistory::new(4);
        let twist = Twist2::default();
        history.push(MS, Pose2::new(0.0, 0.0, 3.1), twist).unwrap();
        history
            .push(3 * MS, Pose2::new(0.0, 0.0, -3.1), twist)
            .unwrap();
        let theta_rad = history.at(2 * MS).unwrap().theta_rad;
        assert!((theta_rad.abs() - std::f64::consts::PI).abs() < 1e-9);
    }
}
