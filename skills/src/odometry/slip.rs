//! Wheels that slip: their difference then says another turn than the pivot does.
//!
//! Both hub wheels sit on one pivot. Geometry gives the difference of their ways from the way of the unit and the pivot's
//! turn; what is left of it was not driven by both. How far both slipped alike cannot be seen: it is taken to be as much.

/// Over this way of the wheels what was seen before loses two thirds of its weight, metres.
const WINDOW_M: f64 = 0.3;
/// Over a shorter way nothing is said, metres.
const LEAST_M: f64 = 0.1;
/// Wheels differ by two per cent when each is worn by one, which is no slip.
const SHARE: f64 = 0.035;

/// Compares what the wheels say with what the pivot says.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SlipWatch {
    /// Of the way below, what only one wheel has driven, positive to the right one.
    off_m: f64,
    /// Mean way of both rims.
    rim_m: f64,
    slips: bool,
}

impl SlipWatch {
    /// Takes in a step: the mean way of both rims, and what of the wheels' difference geometry does not explain. Returns how
    /// much of the way may not have been driven.
    pub(super) fn step(&mut self, rim_m: f64, unexplained_m: f64) -> f64 {
        let keep = (-rim_m / WINDOW_M).exp();
        self.off_m = keep * self.off_m + unexplained_m;
        self.rim_m = keep * self.rim_m + rim_m;
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
}
