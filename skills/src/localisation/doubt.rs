//! When the pose becomes uncertain, and when it is certain again.

/// The pose becomes uncertain after this many scans in a row whose walls were all refused,
pub(super) const REFUSED_SCANS: u32 = 10;
/// or that show none of the walls that should be in view,
pub(super) const BLIND_SCANS: u32 = 15;
/// or that look through walls.
pub(super) const CONTRADICTED_SCANS: u32 = 5;
/// It is certain again after this many good scans in a row,
pub(super) const GOOD_SCANS: u32 = 3;
/// once the standard deviations are below this share of their limits.
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

impl ScanVerdict {
    /// In one word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Corrected => "corrected",
            Self::Refused => "refused",
            Self::Blind => "blind",
            Self::Nothing => "nothing",
            Self::Contradicted => "contradicted",
        }
    }
}

/// Counts consecutive scans of one kind and decides whether the pose is uncertain.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Doubt {
    refused: u32,
    blind: u32,
    contradicted: u32,
    good: u32,
    uncertain: bool,
}

impl Doubt {
    /// Counts a scan; `true`: the walls have contradicted the pose in enough scans that the covariance should grow.
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
            // No evidence either way: the counts stay.
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
