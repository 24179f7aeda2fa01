//! Reads scans and odometry once for all activities of a thread, and aligns each scan to the motion during its turn.
//!
//! Real-time contract: after construction nothing here allocates, locks or makes a system call.

use coordination::symbols::Stamped;
use skills::history::OdometryHistory;
use skills::scan::{AlignError, AlignedScan, ScanGeometry, ScanGeometryError};

use crate::symbols::values::{MAX_STEPS, OdometryTrace, RangeScan};
use crate::symbols::wiring::ScanSymbols;

/// A thread's copy of the last scan, and of the odometry that goes with it.
pub struct ScanIntake {
    symbols: ScanSymbols,
    history: OdometryHistory,
    aligned: AlignedScan,
    raw: Box<Stamped<RangeScan>>,
    trace: Box<Stamped<OdometryTrace>>,
    seen_samples: u64,
    /// A scan for which odometry has not come yet: tried once more at the next look.
    waiting: bool,
    /// What became of the scan that the last look found, if it found one.
    found: Option<Result<(), AlignError>>,
}

impl ScanIntake {
    /// An empty one. Allocates all its memory.
    ///
    /// # Errors
    /// [`ScanGeometryError`] for an impossible geometry.
    pub fn new(geometry: ScanGeometry, symbols: ScanSymbols) -> Result<Self, ScanGeometryError> {
        Ok(Self {
            symbols,
            history: OdometryHistory::default(),
            aligned: AlignedScan::new(geometry)?,
            raw: Box::default(),
            trace: Box::default(),
            seen_samples: 0,
            waiting: false,
            found: None,
        })
    }

    /// Looks at the symbols: once in each cycle of the thread, before its activities run.
    pub fn look(&mut self) {
        self.found = self.take();
    }

    fn take(&mut self) -> Option<Result<(), AlignError>> {
        let seen_stamp_ns = self.raw.stamp_ns;
        *self.raw = self.symbols.scan.read();
        *self.trace = self.symbols.trace.read();
        for sample in self.trace.value.since(self.seen_samples) {
            // A refused sample is counted by the history; the ones around it serve.
            let _ = self
                .history
                .push(sample.stamp_ns, sample.pose, sample.twist);
        }
        self.seen_samples = self.trace.value.written;
        if self.raw.stamp_ns == seen_stamp_ns && !self.waiting {
            return None;
        }
        let count = (self.raw.value.count as usize).min(MAX_STEPS);
        let result = self.aligned.align(
            &self.raw.value.ranges_mm[..count],
            self.raw.stamp_ns,
            &self.history,
        );
        let early = matches!(result, Err(AlignError::NoOdometry { .. }));
        self.waiting = early && !self.waiting;
        (!self.waiting).then_some(result)
    }

    /// The scan that the last look brought, aligned.
    #[must_use]
    pub fn fresh(&self) -> Option<&AlignedScan> {
        matches!(self.found, Some(Ok(()))).then_some(&self.aligned)
    }

    /// Whether the last look brought a scan that cannot be placed, because odometry of its time is missing.
    #[must_use]
    pub fn is_unplaced(&self) -> bool {
        matches!(self.found, Some(Err(AlignError::NoOdometry { .. })))
    }

    /// The sequence number of the scan that the last look brought, if it was broken.
    #[must_use]
    pub fn broken(&self) -> Option<u64> {
        match self.found {
            // Without odometry no scan can be aligned: that is not the lidar's fault.
            None | Some(Ok(()) | Err(AlignError::NoOdometry { .. })) => None,
            Some(Err(_)) => Some(self.raw.value.sequence),
        }
    }

    /// The sequence number of the scan that the last look brought, if it repeated the one before although the robot had moved.
    #[must_use]
    pub fn frozen(&self) -> Option<u64> {
        let frozen = matches!(self.found, Some(Err(AlignError::Frozen { .. })));
        frozen.then_some(self.raw.value.sequence)
    }
}
