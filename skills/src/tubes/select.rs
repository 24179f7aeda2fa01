//! Which tube serves a wanted command best.
//!
//! A wanted curvature between two tubes of a row is served when both are free: they overlap along their whole length,
//! so every path between them stays inside both. Otherwise the nearest free tube of the row within the allowed band
//! serves, shifted. Rows compete by cost: the shift of the curvature, and the speed lost; of equals the longest wins.

use super::parameters::AdaptPolicy;
use super::set::{TubeId, TubeSet};
use crate::geometry::MotionCommand;

/// Two curvatures are the same within this.
const SAME_CURVATURE_1_M: f64 = 1e-9;

/// The tube chosen, and the curvature to drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Selection {
    pub tube: TubeId,
    pub row: usize,
    pub curvature_1_m: f64,
    /// From the wanted curvature.
    pub shift_1_m: f64,
}

/// What a search found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Search {
    Found(Selection),
    /// Tubes reach there, and none is free.
    Blocked,
    /// No tube of the set comes near enough to the wanted curvature.
    BeyondTubes,
}

/// Free-scan counts of all tubes, and the policy that reads them.
pub(super) struct Selector<'a> {
    pub set: &'a TubeSet,
    pub policy: &'a AdaptPolicy,
    /// Free scans in a row, per tube.
    pub streaks: &'a [u8],
}

impl Selector<'_> {
    fn is_free(&self, row: usize, step: usize) -> bool {
        let id = self.set.id(row, step);
        self.streaks[id.0 as usize] >= self.policy.free_scans
    }

    fn exists(&self, row: usize, step: usize) -> bool {
        !self.set.is_refused(self.set.id(row, step))
    }

    /// The best tube for `wanted`, given the one driven so far.
    pub fn search(&self, wanted: MotionCommand, driven: Option<Selection>) -> Search {
        let mut best: Option<(f64, Selection)> = None;
        let mut any_exists = false;
        for row in 0..self.set.rows.len() {
            let lost_m_s = (wanted.speed_m_s - self.set.rows[row].horizon.speed_m_s).max(0.0);
            let mut offer = |selection: Selection| {
                let shift_1_m = selection.shift_1_m;
                let changes_side = driven.is_some_and(|driven| driven.shift_1_m * shift_1_m < 0.0);
                let reluctance_1_m = if changes_side {
                    self.policy.hysteresis_1_m
                } else {
                    0.0
                };
                let cost = shift_1_m.abs() + reluctance_1_m + self.policy.speed_weight * lost_m_s;
                if best.is_none_or(|(least, _)| cost < least - 1e-9) {
                    best = Some((cost, selection));
                }
            };
            any_exists |= self.offer_row(row, wanted.curvature_1_m, &mut offer);
        }
        match best {
            Some((_, selection)) => Search::Found(selection),
            None if any_exists => Search::Blocked,
            None => Search::BeyondTubes,
        }
    }

    /// Offers what a row has for a curvature; says whether it has any tube there.
    fn offer_row(&self, row: usize, wanted_1_m: f64, offer: &mut impl FnMut(Selection)) -> bool {
        let steps = self.set.steps;
        let spacing_1_m = self.set.rows[row].curvature_step_1_m;
        let place = wanted_1_m / spacing_1_m + (steps / 2) as f64;
        let last = (steps - 1) as f64;
        let (low, high) = (place.floor(), place.ceil());
        if low >= 0.0 && high <= last {
            let (low, high) = (low as usize, high as usize);
            if self.is_free(row, low) && self.is_free(row, high) {
                let nearest = place.round().clamp(0.0, last) as usize;
                offer(Selection {
                    tube: self.set.id(row, nearest),
                    row,
                    curvature_1_m: wanted_1_m,
                    shift_1_m: 0.0,
                });
                return true;
            }
        }
        // The nearest free tube to either side, within the band.
        let band = self.policy.curvature_band_1_m / spacing_1_m;
        let first = (place - band).ceil().clamp(0.0, steps as f64) as usize;
        let end = ((place + band).floor() + 1.0).clamp(0.0, steps as f64) as usize;
        let split = (high.clamp(0.0, steps as f64) as usize).clamp(first, end.max(first));
        let mut shifted = |step: usize| {
            let curvature_1_m = self.set.row_curvature_1_m(row, step);
            let shift_1_m = curvature_1_m - wanted_1_m;
            offer(Selection {
                tube: self.set.id(row, step),
                row,
                curvature_1_m,
                shift_1_m: if shift_1_m.abs() < SAME_CURVATURE_1_M {
                    0.0
                } else {
                    shift_1_m
                },
            });
        };
        if let Some(step) = (first..split).rev().find(|&step| self.is_free(row, step)) {
            shifted(step);
        }
        if let Some(step) = (split..end).find(|&step| self.is_free(row, step)) {
            shifted(step);
        }
        (first..end).any(|step| self.exists(row, step))
    }
}
