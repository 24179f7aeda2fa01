//! A set of tubes, flat in memory, and its evaluation.

use crate::scan::{MAX_BEAMS, ScanGeometry};
use crate::tubes::memory::grid::NearGrid;
use crate::tubes::memory::known::KnownRanges;
use description::geometry::{Footprint, Twist2};
use description::robot::{Horizon, Tubes};

/// A tube, as an index into its set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TubeId(pub u32);

/// A row of tubes of one horizon, their curvatures evenly spread and growing with the index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::tubes) struct Row {
    pub horizon: Horizon,
    pub backward: bool,
    pub length_m: f64,
    pub curvature_step_1_m: f64,
}

/// Where a tube's samples and mask are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::tubes) struct Tube {
    pub first_sample: u32,
    pub samples: u32,
    pub first_word: u32,
    pub words: u32,
    /// The grid's word that the mask begins with.
    pub grid_word: u32,
    pub refused: bool,
    /// Floor out of view must be known to be free; ahead it may be assumed.
    pub backward: bool,
}

/// What is known of the floor around the robot that the sensor does not see, as bits of [`TubeSet::grid`].
#[derive(Clone, Copy, Debug)]
pub struct Surroundings<'a> {
    /// Something was seen there.
    pub occupied: &'a [u64],
    /// It was neither seen free nor driven over.
    pub unknown: &'a [u64],
    /// Neither that, nor assumed free where the robot was put down.
    pub unassumed: &'a [u64],
}

impl<'a> Surroundings<'a> {
    fn missing(&self, backward: bool) -> &'a [u64] {
        if backward {
            self.unknown
        } else {
            self.unassumed
        }
    }
}

/// All tubes of a robot. Made once; evaluation reads it only.
#[derive(Clone, Debug)]
pub struct TubeSet {
    pub(in crate::tubes) parameters: Tubes,
    pub(in crate::tubes) footprint: Footprint,
    pub(in crate::tubes) geometry: ScanGeometry,
    pub(in crate::tubes) grid: NearGrid,
    /// Rows ahead, the longest first, then rows behind, the longest first; `steps` tubes each.
    pub(in crate::tubes) rows: Box<[Row]>,
    /// Rows ahead.
    pub(in crate::tubes) ahead: usize,
    pub(in crate::tubes) steps: usize,
    pub(in crate::tubes) tubes: Box<[Tube]>,
    pub(in crate::tubes) sample_beams: Box<[u16]>,
    pub(in crate::tubes) sample_ranges_m: Box<[f32]>,
    pub(in crate::tubes) mask_words: Box<[u64]>,
    /// The slowest row of each direction, with the margin of driving by hand, where that is smaller.
    pub(in crate::tubes) narrow: Option<Box<TubeSet>>,
}

impl TubeSet {
    /// How many tubes, the refused ones among them.
    #[must_use]
    pub fn len(&self) -> usize {
        self.tubes.len()
    }

    /// There is no tube.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.tubes.is_empty()
    }

    /// All tubes.
    pub fn ids(&self) -> impl Iterator<Item = TubeId> + use<> {
        (0..self.tubes.len() as u32).map(TubeId)
    }

    /// The horizon of a tube.
    #[must_use]
    pub fn horizon(&self, id: TubeId) -> Horizon {
        self.rows[self.row_of(id)].horizon
    }

    /// The curvature of a tube.
    #[must_use]
    pub fn curvature_1_m(&self, id: TubeId) -> f64 {
        self.row_curvature_1_m(self.row_of(id), id.0 as usize % self.steps)
    }

    /// The tightest curvature of all tubes.
    #[must_use]
    pub fn most_curvature_1_m(&self) -> f64 {
        let last = self.steps - 1;
        (0..self.rows.len())
            .map(|row| self.row_curvature_1_m(row, last))
            .fold(0.0, f64::max)
    }

    /// How far a path between a tube and the next of its row stays inside the two.
    ///
    /// Towards their ends they part: the front edges must still overlap, and the sharper turn reaches farther around
    /// than the other. The length of a tube itself is that of its horizon.
    #[must_use]
    pub fn length_between_m(&self, id: TubeId) -> f64 {
        let row = self.row_of(id);
        let step = id.0 as usize % self.steps;
        let outer_1_m = self.row_curvature_1_m(row, step).abs().max(
            self.row_curvature_1_m(row, (step + 1).min(self.steps - 1))
                .abs(),
        );
        let Row {
            length_m,
            curvature_step_1_m: apart_1_m,
            ..
        } = self.rows[row];
        let width_m = self.footprint.width_m();
        let front_m = if self.rows[row].backward {
            self.footprint.rear_m
        } else {
            self.footprint.front_m
        };
        // apart · (s² / 2 + front · s): how far apart the front edges are after s.
        let overlap_m = (front_m * front_m + 2.0 * width_m / apart_1_m).sqrt() - front_m;
        let s_m = length_m.min(overlap_m);
        let turn_rad = (outer_1_m * s_m).min(std::f64::consts::PI);
        let slack_m = apart_1_m * s_m * (s_m * turn_rad / 12.0 + width_m / 4.0);
        (s_m - slack_m).max(0.0)
    }

    /// The twist that drives a tube at its horizon's speed.
    #[must_use]
    pub fn twist(&self, id: TubeId) -> Twist2 {
        let sign = if self.is_backward(id) { -1.0 } else { 1.0 };
        let speed_m_s = sign * self.horizon(id).speed_m_s;
        Twist2::new(speed_m_s, speed_m_s * self.curvature_1_m(id))
    }

    /// The tube is driven backwards.
    #[must_use]
    pub fn is_backward(&self, id: TubeId) -> bool {
        self.tubes[id.0 as usize].backward
    }

    /// Some tube that is driven backwards is not refused.
    #[must_use]
    pub fn has_backward(&self) -> bool {
        self.tubes.iter().any(|tube| tube.backward && !tube.refused)
    }

    /// The sensor cannot judge this tube; it is never free.
    #[must_use]
    pub fn is_refused(&self, id: TubeId) -> bool {
        self.tubes[id.0 as usize].refused
    }

    /// Samples of a tube after those of one beam are merged.
    #[must_use]
    pub fn samples(&self, id: TubeId) -> usize {
        self.tubes[id.0 as usize].samples as usize
    }

    /// The comparisons of a tube: beam, and the range beyond which it must measure.
    pub fn compared(&self, id: TubeId) -> impl Iterator<Item = (usize, f32)> + '_ {
        let tube = &self.tubes[id.0 as usize];
        let samples = tube.first_sample as usize..(tube.first_sample + tube.samples) as usize;
        let beams = self.sample_beams[samples.clone()].iter();
        beams
            .zip(&self.sample_ranges_m[samples])
            .map(|(&beam, &range_m)| (usize::from(beam), range_m))
    }

    /// What it was made of.
    #[must_use]
    pub fn parameters(&self) -> &Tubes {
        &self.parameters
    }

    /// Whose tubes they are.
    #[must_use]
    pub fn footprint(&self) -> &Footprint {
        &self.footprint
    }

    /// The sensor that judges them.
    #[must_use]
    pub fn geometry(&self) -> &ScanGeometry {
        &self.geometry
    }

    /// The grid that remembered points are laid on.
    #[must_use]
    pub fn grid(&self) -> NearGrid {
        self.grid
    }

    /// The cells of the grid, as bits, whose floor must be known before some tube is free.
    #[must_use]
    pub fn floor_mask(&self) -> Vec<u64> {
        let mut all = vec![0; self.grid.words()];
        for tube in &self.tubes {
            let first = tube.first_word as usize;
            let mask = &self.mask_words[first..first + tube.words as usize];
            for (all, word) in all[tube.grid_word as usize..].iter_mut().zip(mask) {
                *all |= word;
            }
        }
        all
    }

    /// Whether a tube is free: every sample's beam is known to be free beyond the sample, and where the sensor does not
    /// look nothing is remembered, and the floor is known.
    #[must_use]
    pub fn is_free(&self, id: TubeId, known: &KnownRanges, near: Surroundings<'_>) -> bool {
        let tube = &self.tubes[id.0 as usize];
        !tube.refused
            && self.samples_free(tube, known.as_array())
            && self.mask_free(tube, near.occupied)
            && self.mask_free(tube, near.missing(tube.backward))
    }

    /// The tube would be free if the floor out of view were known.
    pub(in crate::tubes) fn lacks_floor(
        &self,
        id: TubeId,
        known: &KnownRanges,
        near: Surroundings<'_>,
    ) -> bool {
        let tube = &self.tubes[id.0 as usize];
        !tube.refused
            && self.samples_free(tube, known.as_array())
            && self.mask_free(tube, near.occupied)
            && !self.mask_free(tube, near.missing(tube.backward))
    }

    #[inline]
    fn samples_free(&self, tube: &Tube, known_m: &[f32; MAX_BEAMS]) -> bool {
        let samples = tube.first_sample as usize..(tube.first_sample + tube.samples) as usize;
        let beams = &self.sample_beams[samples.clone()];
        let ranges_m = &self.sample_ranges_m[samples];
        // Blocks without a branch inside, with an early exit between them. NaN is not free.
        let free = |(&beam, &range_m): (&u16, &f32)| known_m[beam as usize % MAX_BEAMS] > range_m;
        const BLOCK: usize = 16;
        let mut beam_blocks = beams.chunks_exact(BLOCK);
        let mut range_blocks = ranges_m.chunks_exact(BLOCK);
        for (beams, ranges_m) in beam_blocks.by_ref().zip(range_blocks.by_ref()) {
            let all = beams
                .iter()
                .zip(ranges_m)
                .fold(true, |all, sample| all & free(sample));
            if !all {
                return false;
            }
        }
        beam_blocks
            .remainder()
            .iter()
            .zip(range_blocks.remainder())
            .fold(true, |all, sample| all & free(sample))
    }

    #[inline]
    fn mask_free(&self, tube: &Tube, occupied: &[u64]) -> bool {
        let first = tube.first_word as usize;
        let mask = &self.mask_words[first..first + tube.words as usize];
        let Some(occupied) = occupied.get(tube.grid_word as usize..) else {
            return tube.words == 0;
        };
        occupied.len() >= mask.len()
            && mask
                .iter()
                .zip(occupied)
                .fold(0, |hits, (mask, occupied)| hits | (mask & occupied))
                == 0
    }

    /// The row of this set that is the one ahead or behind of [`narrow`](Self::narrow).
    pub(in crate::tubes) fn slowest(&self, backward: bool) -> usize {
        (if backward {
            self.rows.len()
        } else {
            self.ahead
        }) - 1
    }

    pub(in crate::tubes) fn id(&self, row: usize, step: usize) -> TubeId {
        TubeId((row * self.steps + step) as u32)
    }

    pub(in crate::tubes) fn row_of(&self, id: TubeId) -> usize {
        id.0 as usize / self.steps
    }

    pub(in crate::tubes) fn row_curvature_1_m(&self, row: usize, step: usize) -> f64 {
        let middle = (self.steps / 2) as f64;
        (step as f64 - middle) * self.rows[row].curvature_step_1_m
    }
}
