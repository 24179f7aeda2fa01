//! When the pose is not to be trusted, and when it is again.

/// So many scans in a row whose walls are all refused end trust.
pub(super) const REFUSED_SCANS: u32 = 10;
/// So many that show none of the walls that should be in view do the same;
pub(super) const BLIND_SCANS: u32 = 15;
/// and so many that look through walls.
pub(super) const CONTRADICTED_SCANS: u32 = 5;
/// So many good scans in a row bring it back,
pub(super) const GOOD_SCANS: u32 = 3;
/// when the standard deviations are below this share of their limits.
const RECOVERED: f64 = 0.8;

/// What a scan did for the pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScanVerdict {
    /// A wall corrected it.
    Corrected,
    /// Walls were seen, all of them too improbable.
    Refused,
    /// None of the expected walls was seen.
    Blind,
    /// No wall should be in view, and none was recognised.
    Nothing,
    /// The scan looks through walls: pose or map is wrong.
    Contradicted,
}

/// Rows of scans of one kind, and what follows from them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Doubt {
    refused: u32,
    blind: u32,
    contradicted: u32,
    good: u32,
    uncertain: bool,
}

impl Doubt {
    /// Counts a scan; `true`: the walls have insisted on another pose for so long that the covariance should grow.
    pub(super) fn scan(&mut self, verdict: ScanVerdict) -> bool {
        let before = *self;
        let more = |count: u32| count.saturating_add(1);
        *self = Self {
            uncertain: before.uncertain,
            ..Self::default()
        };
        match verdict {
            ScanVerdict::Corrected => self.good = more(before.good),
            ScanVerdict::Refused => self.refused = more(before.refused),
            ScanVerdict::Blind => self.blind = more(before.blind),
            ScanVerdict::Contradicted => self.contradicted = more(before.contradicted),
            // Says nothing for or against: doubts stay as they are.
            ScanVerdict::Nothing => *self = before,
        }
        self.insisted()
    }

    /// Decides; `worst` is the larger standard deviation as a share of its limit.
    pub(super) fn judge(&mut self, worst: f64) {
        let bad = worst > 1.0
            || worst.is_nan()
            || self.blind >= BLIND_SCANS
            || self.refused >= REFUSED_SCANS
            || self.contradicted >= CONTRADICTED_SCANS;
        let recovered = worst <= RECOVERED && self.good >= GOOD_SCANS;
        self.uncertain = bad || (self.uncertain && !recovered);
    }

    pub(super) fn is_uncertain(&self) -> bool {
        self.uncertain
    }

    /// Walls have been refused or looked through until the pose itself came into doubt.
    pub(super) fn insisted(&self) -> bool {
        self.refused >= REFUSED_SCANS || self.contradicted >= CONTRADICTED_SCANS
    }
}
