//! Which features a skill tracks or searches.

use description::site::Feature;

/// A set of features.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FeatureSet {
    /// Has [`Feature::Corridor`].
    pub corridor: bool,
    /// Has [`Feature::LaneEnd`].
    pub lane_end: bool,
    /// Has [`Feature::Walls`].
    pub walls: bool,
}

impl FeatureSet {
    /// What either set has.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self {
            corridor: self.corridor || other.corridor,
            lane_end: self.lane_end || other.lane_end,
            walls: self.walls || other.walls,
        }
    }
}

impl<'a> FromIterator<&'a Feature> for FeatureSet {
    fn from_iter<I: IntoIterator<Item = &'a Feature>>(features: I) -> Self {
        let mut set = Self::default();
        for feature in features {
            match feature {
                Feature::Corridor => set.corridor = true,
                Feature::LaneEnd => set.lane_end = true,
                Feature::Walls => set.walls = true,
            }
        }
        set
    }
}
