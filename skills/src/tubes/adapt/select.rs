//! Which tube serves a wanted command best.
//!
//! A wanted curvature between two tubes of a row is served when both are free: a path between them stays inside the
//! two until they part near their ends. Otherwise the nearest free tube of the row within the allowed band
//! serves, shifted, if it is at least two rows longer. Rows compete by cost: the shift of the curvature, and the speed
//! lost; of equals the longest wins. Backwards is served by the rows behind in the same way.

use crate::tubes::set::tube_set::{TubeId, TubeSet};
use description::geometry::MotionCommand;
use description::robot::AdaptPolicy;

/// A shift must lead into a tube at least this many rows longer than the longest unshifted one.
const SHIFT_BUYS_ROWS: usize = 2;

/// The tube chosen, and the curvature to drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Selection {
    pub tube: TubeId,
    pub row: usize,
    pub curvature_1_m: f64,
    /// From the wanted curvature.
    pub shift_1_m: f64,
    /// How far it is known to be free.
    pub length_m: f64,
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
        u32::from(self.streaks[id.0 as usize]) >= self.policy.free_scans
    }

    /// The best tube for `wanted`, given the one driven so far.
    pub fn search(&self, wanted: MotionCommand, driven: Option<Selection>) -> Search {
        let wanted_1_m = wanted.curvature_1_m;
        let mut best: Option<(f64, Selection)> = None;
        let mut offer = |selection: Selection| {
            let horizon = self.set.rows[selection.row].horizon;
            let lost_m_s = (wanted.speed_m_s.abs() - horizon.speed_m_s).max(0.0);
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
        let rows = if wanted.speed_m_s < 0.0 {
            self.set.ahead..self.set.rows.len()
        } else {
            self.ahead()
        };
        let mut longest_unshifted = None;
        for row in rows.clone() {
            if let Some(selection) = self.unshifted(row, wanted_1_m) {
                longest_unshifted.get_or_insert(row);
                offer(selection);
            }
        }
        // A bend before a wall across the lane gains at most one row; around an obstacle it gains several.
        let worth =
            longest_unshifted.map_or(rows.end, |row| (row + 1).saturating_sub(SHIFT_BUYS_ROWS));
        for row in rows.start..worth {
            let (below, above) = self.shifted(row, wanted_1_m);
            below.into_iter().chain(above).for_each(&mut offer);
        }
        match best {
            Some((_, selection)) => Search::Found(selection),
            None if rows.clone().any(|row| self.has_tubes_near(row, wanted_1_m)) => Search::Blocked,
            None => Search::BeyondTubes,
        }
    }

    /// The rows ahead, the longest first.
    pub fn ahead(&self) -> std::ops::Range<usize> {
        0..self.set.ahead
    }

    /// The speed of a selection's row.
    pub fn speed_m_s(&self, selection: &Selection) -> f64 {
        self.set.rows[selection.row].horizon.speed_m_s
    }

    /// A row is driven faster than a detour, or is the longest.
    pub fn is_long(&self, row: usize) -> bool {
        row == 0 || self.set.rows[row].horizon.speed_m_s > self.policy.detour.speed_m_s
    }

    /// A curvature is free ahead in a row that is driven faster than a detour, or in the longest.
    pub fn is_clear(&self, curvature_1_m: f64) -> bool {
        self.ahead()
            .take_while(|&row| self.is_long(row))
            .any(|row| self.unshifted(row, curvature_1_m).is_some())
    }

    /// How far a curvature is free on the newest scan alone; `None` beyond the tubes.
    pub fn free_length_m(&self, curvature_1_m: f64, backward: bool) -> Option<f64> {
        let rows = if backward {
            self.set.ahead..self.set.rows.len()
        } else {
            self.ahead()
        };
        let mut length_m = None;
        for row in rows {
            let Some((low, high)) = self.neighbours(row, curvature_1_m) else {
                continue;
            };
            let seen = |step| self.streaks[self.set.id(row, step).0 as usize] > 0;
            if seen(low) && seen(high) {
                return Some(self.unshifted_length_m(row, low, high));
            }
            length_m = Some(0.0);
        }
        length_m
    }

    /// The free tube of a row farthest from a wanted curvature on its left (+1) or right (−1).
    pub fn farthest_on_side(
        &self,
        row: usize,
        wanted_1_m: f64,
        side: f64,
        allowed: impl Fn(&Selection) -> bool,
    ) -> Option<Selection> {
        let serves = |&step: &usize| {
            let selection = self.on_tube(row, step, wanted_1_m);
            self.is_free(row, step) && selection.shift_1_m * side >= 0.0 && allowed(&selection)
        };
        let steps = 0..self.set.steps;
        let step = if side > 0.0 {
            steps.rev().find(serves)
        } else {
            { steps }.find(serves)
        };
        step.map(|step| self.on_tube(row, step, wanted_1_m))
    }

    /// The tube behind, of the shortest row, nearest to a curvature.
    pub fn nearest_behind(&self, curvature_1_m: f64) -> Option<TubeId> {
        let row = self.set.rows.len().checked_sub(1)?;
        let last = (self.set.steps - 1) as f64;
        let step = self.place(row, curvature_1_m).round().clamp(0.0, last) as usize;
        self.set.rows[row].backward.then(|| self.set.id(row, step))
    }

    /// The free tube of a row nearest to a wanted curvature on its left (+1) or right (−1), one tube away from what
    /// blocks the nearer ones where there is one.
    pub fn nearest_on_side(
        &self,
        row: usize,
        wanted_1_m: f64,
        side: f64,
        allowed: impl Fn(&Selection) -> bool,
    ) -> Option<Selection> {
        let place = self.place(row, wanted_1_m);
        let last = (self.set.steps - 1) as f64;
        let (first, step) = if side > 0.0 {
            ((place - 1e-6).ceil().max(0.0), 1.0)
        } else {
            ((place + 1e-6).floor().min(last), -1.0)
        };
        let served = |place: f64| -> Option<Selection> {
            if !(0.0..=last).contains(&place) {
                return None;
            }
            let step = place as usize;
            let selection = self.on_tube(row, step, wanted_1_m);
            (self.is_free(row, step) && allowed(&selection)).then_some(selection)
        };
        let count = self.set.steps;
        let nearest = (0..count)
            .map(|index| first + step * index as f64)
            .take_while(|place| (0.0..=last).contains(place))
            .find(|&place| served(place).is_some())?;
        let before = nearest - step;
        let edge_is_free = !(0.0..=last).contains(&before) || self.is_free(row, before as usize);
        if edge_is_free {
            return served(nearest);
        }
        served(nearest + step).or_else(|| served(nearest))
    }

    /// Where a curvature lies among the tubes of a row, as a fraction of their index.
    fn place(&self, row: usize, curvature_1_m: f64) -> f64 {
        curvature_1_m / self.set.rows[row].curvature_step_1_m + (self.set.steps / 2) as f64
    }

    /// The tubes of a row on both sides of a curvature; the same one twice for a curvature on a tube.
    fn neighbours(&self, row: usize, curvature_1_m: f64) -> Option<(usize, usize)> {
        let place = self.place(row, curvature_1_m);
        // Within rounding of a tube is on it.
        let (low, high) = ((place + 1e-6).floor(), (place - 1e-6).ceil());
        (low >= 0.0 && high <= (self.set.steps - 1) as f64).then_some((low as usize, high as usize))
    }

    fn unshifted_length_m(&self, row: usize, low: usize, high: usize) -> f64 {
        if low == high {
            self.set.rows[row].length_m
        } else {
            self.set.length_between_m(self.set.id(row, low))
        }
    }

    /// The wanted curvature itself, when the tubes on both sides of it are free.
    fn unshifted(&self, row: usize, wanted_1_m: f64) -> Option<Selection> {
        let (low, high) = self.neighbours(row, wanted_1_m)?;
        let nearest = self.place(row, wanted_1_m).round() as usize;
        (self.is_free(row, low) && self.is_free(row, high)).then(|| Selection {
            tube: self.set.id(row, nearest),
            row,
            curvature_1_m: wanted_1_m,
            shift_1_m: 0.0,
            length_m: self.unshifted_length_m(row, low, high),
        })
    }

    fn on_tube(&self, row: usize, step: usize, wanted_1_m: f64) -> Selection {
        let curvature_1_m = self.set.row_curvature_1_m(row, step);
        Selection {
            tube: self.set.id(row, step),
            row,
            curvature_1_m,
            shift_1_m: curvature_1_m - wanted_1_m,
            length_m: self.set.rows[row].length_m,
        }
    }

    /// Indices of the tubes of a row within the band, and where the wanted curvature divides them.
    fn band(&self, row: usize, wanted_1_m: f64) -> (usize, usize, usize) {
        let steps = self.set.steps as f64;
        let place = self.place(row, wanted_1_m);
        let half = self.policy.curvature_band_1_m / self.set.rows[row].curvature_step_1_m;
        let index = |place: f64| place.clamp(0.0, steps) as usize;
        let first = index((place - half).ceil());
        let end = index((place + half).floor() + 1.0).max(first);
        (first, index(place.ceil()).clamp(first, end), end)
    }

    /// The nearest free tubes of a row on both sides, within the band.
    fn shifted(&self, row: usize, wanted_1_m: f64) -> (Option<Selection>, Option<Selection>) {
        let (first, split, end) = self.band(row, wanted_1_m);
        let select = |step: usize| self.on_tube(row, step, wanted_1_m);
        let is_free = |step: &usize| self.is_free(row, *step);
        (
            (first..split).rev().find(is_free).map(select),
            (split..end).find(is_free).map(select),
        )
    }

    fn has_tubes_near(&self, row: usize, wanted_1_m: f64) -> bool {
        let (first, _, end) = self.band(row, wanted_1_m);
        let is_usable = |step: usize| !self.set.is_refused(self.set.id(row, step));
        (first..end).any(is_usable)
    }
}
