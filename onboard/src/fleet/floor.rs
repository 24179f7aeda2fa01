//! The floor under the robot: which areas its footprint reaches into, and how far it is from others.

use description::areas::AreaIndex;
use description::geometry::{Footprint, Pose2, Rect};
use nalgebra::Matrix3;
use skills::borders::{AreaSet, BorderGains, BorderGuard, Curve};

use super::Setup;

/// An area counts as left only when the footprint, grown as before a border, is `LEAVING_M` away from it (hysteresis): the
/// estimate may still move back and forth.
pub const LEAVING_M: f64 = 0.05;

/// Where the robot is, as well as it knows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UncertainPose {
    /// Of `base_link`, in `map`.
    pub pose: Pose2,
    /// Of (x, y, θ).
    pub covariance: Matrix3<f64>,
}

/// How the footprint lies to an area.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Touch {
    /// Outside, whatever the pose may be.
    Clear,
    /// So near outside that it has not quite left.
    Near,
    /// It may reach in, given the pose's uncertainty and the margin kept before borders.
    Margin,
    /// It reaches in at the estimated pose.
    Body,
}

/// All areas, for one footprint.
#[derive(Clone, Debug)]
pub(super) struct Floor {
    regions: Vec<Rect>,
    /// One for each area.
    borders: Vec<BorderGuard>,
    /// The same, farther out.
    leaving: Vec<BorderGuard>,
    /// The same, with no other margin than the pose's uncertainty.
    unsure: Vec<BorderGuard>,
    footprint: Footprint,
    gains: BorderGains,
}

impl Floor {
    pub(super) fn new(setup: &Setup) -> Self {
        let gains = setup.borders;
        let farther = BorderGains {
            margin_m: gains.margin_m + LEAVING_M,
            ..gains
        };
        let bare = BorderGains {
            margin_m: 0.0,
            ..gains
        };
        let regions: Vec<Rect> = setup.areas.iter().map(|area| area.region).collect();
        let guards = |gains| {
            let guard = |&region| BorderGuard::new([region], setup.footprint, gains);
            regions.iter().map(guard).collect()
        };
        Self {
            borders: guards(gains),
            leaving: guards(farther),
            unsure: guards(bare),
            regions,
            footprint: setup.footprint,
            gains,
        }
    }

    pub(super) fn touch(&self, area: AreaIndex, at: &UncertainPose) -> Touch {
        match judge(&self.leaving, area, at) {
            None => Touch::Clear,
            Some(true) => Touch::Body,
            Some(false) if judge(&self.borders, area, at).is_some() => Touch::Margin,
            Some(false) => Touch::Near,
        }
    }

    /// Whether the footprint may reach into the area, given the pose's uncertainty.
    pub(super) fn may_be_in(&self, area: AreaIndex, at: &UncertainPose) -> bool {
        judge(&self.unsure, area, at).is_some()
    }

    /// From the footprint, grown by margin and uncertainty, to the area; 0 when it may reach in. Never more than the way
    /// to it.
    pub(super) fn gap_m(&self, area: AreaIndex, at: &UncertainPose) -> f64 {
        let Some(region) = self.regions.get(area.place()) else {
            return f64::INFINITY;
        };
        if self.touch(area, at) >= Touch::Margin {
            return 0.0;
        }
        let bare_m = self.footprint.gap_m(at.pose, region);
        (bare_m - self.growth_m(at)).max(0.0)
    }

    /// No point of the footprint is farther than this from where the estimated pose puts it, margin included.
    fn growth_m(&self, at: &UncertainPose) -> f64 {
        let variance = |axis: usize| at.covariance[(axis, axis)].max(0.0);
        let turned_m = variance(2).sqrt() * self.footprint.radius_m();
        let std_m = (variance(0) + variance(1)).sqrt() + turned_m;
        self.gains.sigmas * std_m + self.gains.fixed_m()
    }
}

/// Whether the footprint reaches into an area, by its guard; and whether it does so at the estimated pose.
fn judge(guards: &[BorderGuard], area: AreaIndex, at: &UncertainPose) -> Option<bool> {
    let here = Curve {
        curvature_1_m: 0.0,
        reach_m: 0.0,
    };
    let guard = guards.get(area.place())?;
    let judged = guard.along_curve(&AreaSet::EMPTY, at.pose, &at.covariance, here);
    judged.area.map(|_| judged.inside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fleet::tests::{at, setup};

    #[test]
    fn the_body_and_what_it_may_reach_are_told_apart() {
        // Area 1 ends and 2 begins at x = 5.5; the robot's front is 0.32 m ahead of base_link.
        let floor = Floor::new(&setup());
        let touches = |x_m, std_m| {
            let place = at(x_m, -0.5, 0.0, std_m);
            [0, 1].map(|area| floor.touch(AreaIndex(area), &place))
        };
        assert_eq!(touches(4.0, 0.01), [Touch::Body, Touch::Clear]);
        assert_eq!(touches(5.15, 0.01), [Touch::Body, Touch::Margin]);
        assert_eq!(touches(5.0, 0.06), [Touch::Body, Touch::Margin]);
        assert_eq!(touches(5.2, 0.01), [Touch::Body, Touch::Body]);
        // Its rear is 0.08 m behind.
        assert_eq!(touches(5.61, 0.01), [Touch::Margin, Touch::Body]);
        assert_eq!(touches(5.65, 0.01), [Touch::Near, Touch::Body]);
        assert_eq!(touches(5.8, 0.01), [Touch::Clear, Touch::Body]);
        let may_be_in_2 = |x_m, std_m| floor.may_be_in(AreaIndex(1), &at(x_m, -0.5, 0.0, std_m));
        assert_eq!(touches(5.16, 0.002)[1], Touch::Margin);
        assert!(!may_be_in_2(5.16, 0.002), "it stands before the border");
        assert!(may_be_in_2(5.15, 0.03) && may_be_in_2(5.2, 0.005));
    }

    #[test]
    fn a_gap_is_never_more_than_the_way() {
        let floor = Floor::new(&setup());
        let place = at(4.0, -0.5, 0.0, 0.001);
        let gap_m = floor.gap_m(AreaIndex(1), &place);
        assert!(gap_m < 1.18 && gap_m > 1.08, "{gap_m}");
        assert_eq!(floor.gap_m(AreaIndex(0), &place), 0.0);
        let unsure = floor.gap_m(AreaIndex(1), &at(4.0, -0.5, 0.0, 0.1));
        assert!(unsure < gap_m - 0.25, "{unsure}");
    }
}
