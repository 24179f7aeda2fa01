//! Wheels that slip: their difference then says another turn than the pivot does.
//!
//! Both hub wheels sit on one pivot. Geometry gives the difference of their ways from the way of the unit and the pivot's
//! turn; what is left of it was not driven by both. How far both slipped alike cannot be seen: it is taken to be as much.

use std::fmt;

/// Over this way of the wheels what was seen before loses two thirds of its weight, metres.
const WINDOW_M: f64 = 0.3;
/// Over a shorter way nothing is said, metres.
const LEAST_M: f64 = 0.1;
/// Wheels differ by two per cent when each is worn by one, which is no slip.
const SHARE: f64 = 0.035;

/// A wheel has turned farther than the other wheel and the pivot say that it can have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slip {
    /// It is the right wheel, else the left one.
    pub right: bool,
    /// How far its rim has moved lately by what the other wheel and the pivot say, metres.
    pub expected_m: f64,
    /// And by its own encoder, metres.
    pub found_m: f64,
}

impl fmt::Display for Slip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let wheel = if self.right { "right" } else { "left" };
        let (expected_m, found_m) = (self.expected_m, self.found_m);
        write!(
            f,
            "the {wheel} wheel slips: lately it has turned by {found_m:.3} m, expected {expected_m:.3} m by the other wheel and the pivot"
        )
    }
}

/// One step, metres.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SlipStep {
    /// Mean way of both rims, either way.
    pub rim_m: f64,
    /// The same, forward positive.
    pub unit_m: f64,
    /// By how much the right rim moved farther than the left one as geometry has it,
    pub explained_m: f64,
    /// and beyond that.
    pub unexplained_m: f64,
}

/// Compares what the wheels say with what the pivot says.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SlipWatch {
    /// Of the way below, what only one wheel has driven, positive to the right one.
    off_m: f64,
    /// Mean way of both rims.
    rim_m: f64,
    /// The same, forward positive.
    unit_m: f64,
    /// What geometry explains of the wheels' difference.
    explained_m: f64,
    slips: bool,
}

impl SlipWatch {
    /// Takes in a step. Returns how much of the way may not have been driven.
    pub(super) fn step(&mut self, step: SlipStep) -> f64 {
        let rim_m = step.rim_m;
        let keep = (-rim_m / WINDOW_M).exp();
        self.off_m = keep * self.off_m + step.unexplained_m;
        self.rim_m = keep * self.rim_m + rim_m;
        self.unit_m = keep * self.unit_m + step.unit_m;
        self.explained_m = keep * self.explained_m + step.explained_m;
        if rim_m == 0.0 || self.rim_m < LEAST_M {
            return 0.0;
        }
        let share = self.off_m.abs() / self.rim_m;
        let slipped = self.slips;
        self.slips = share > SHARE;
        match (slipped, self.slips) {
            (_, false) => 0.0,
            // It began before it could be told.
            (false, true) => share * self.rim_m,
            (true, true) => share * rim_m,
        }
    }

    /// The wheels slip.
    pub(super) fn slips(&self) -> bool {
        self.slips
    }

    /// The wheel that has turned too far, while one slips.
    pub(super) fn found(&self) -> Option<Slip> {
        let half_m = 0.5 * (self.explained_m + self.off_m);
        let (left_m, right_m) = (self.unit_m - half_m, self.unit_m + half_m);
        let right = Slip {
            right: true,
            expected_m: left_m + self.explained_m,
            found_m: right_m,
        };
        let left = Slip {
            right: false,
            expected_m: right_m - self.explained_m,
            found_m: left_m,
        };
        let too_far = right.found_m.abs() > right.expected_m.abs();
        self.slips.then_some(if too_far { right } else { left })
    }
}
