//! Takes in scans and odometry, and aligns each scan to the robot's motion during its turn.

use coordination::symbols::{Reader, Stamped};
use skills::history::OdometryHistory;
use skills::scan::{AlignError, AlignedScan, ScanGeometry, ScanGeometryError};

use crate::symbols::values::{MAX_STEPS, OdometryTrace, RangeScan};

/// What one look at the symbols brought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Intake {
    /// No scan since the last look.
    Nothing,
    /// A scan, aligned.
    Aligned,
    /// A scan that cannot be used.
    Refused(AlignError),
}

/// A reader's own copy of the last scan, and of the odometry that goes with it.
pub struct ScanIntake {
    history: OdometryHistory,
    aligned: AlignedScan,
    raw: Box<Stamped<RangeScan>>,
    trace: Box<Stamped<OdometryTrace>>,
    seen_samples: u64,
    // A scan for which odometry has not come yet: tried once more at the next look.
    waiting: bool,
}

impl ScanIntake {
    /// An empty one. Takes all its memory.
    ///
    /// # Errors
    /// [`ScanGeometryError`] for a geometry that is none.
    pub fn new(geometry: ScanGeometry) -> Result<Self, ScanGeometryError> {
        Ok(Self {
            history: OdometryHistory::default(),
            aligned: AlignedScan::new(geometry)?,
            raw: Box::default(),
            trace: Box::default(),
            seen_samples: 0,
            waiting: false,
        })
    }

    /// Looks at the symbols.
    pub fn take(
        &mut self,
        scan: &mut Reader<RangeScan>,
        trace: &mut Reader<OdometryTrace>,
    ) -> Intake {
        let seen_stamp_ns = self.raw.stamp_ns;
        *self.raw = scan.read();
        *self.trace = trace.read();
        for sample in self.trace.value.since(self.seen_samples) {
            // A refused sample is counted by the history; the ones around it serve.
            let _ = self
                .history
                .push(sample.stamp_ns, sample.pose, sample.twist);
        }
        self.seen_samples = self.trace.value.written;
        if self.raw.stamp_ns == seen_stamp_ns && !self.waiting {
            return Intake::Nothing;
        }
        let count = (self.raw.value.count as usize).min(MAX_STEPS);
        match self.aligned.align(
            &self.raw.value.ranges_mm[..count],
            self.raw.stamp_ns,
            &self.history,
        ) {
            Ok(()) => {
                self.waiting = false;
                Intake::Aligned
            }
            Err(AlignError::NoOdometry { .. }) if !self.waiting => {
                self.waiting = true;
                Intake::Nothing
            }
            Err(error) => {
                self.waiting = false;
                Intake::Refused(error)
            }
        }
    }

    /// The last scan that was aligned.
    #[must_use]
    pub fn aligned(&self) -> &AlignedScan {
        &self.aligned
    }

    /// Sequence number of the last scan.
    #[must_use]
    pub fn sequence(&self) -> u64 {
        self.raw.value.sequence
    }
}
