//! Monitors: conditions that raise events.

use super::map::{Feature, LENGTH};
use crate::geometry::Rect;
use crate::keys::{
    Corners, Count, Fault, Field, Flat, Name, Need, Optional, POSITION, Page, Quantity, Source,
    Word,
};
use crate::{kinds, section};

const WAIT: Quantity = Quantity::new("a duration", "s")
    .above(0.0)
    .at_most(86_400.0);

section! {
    /// A condition, and the event raised when it becomes true.
    pub struct Monitor {
        /// The event.
        pub event: String as Name,
        /// The condition.
        pub kind: MonitorKind as Flat,
    }
}

kinds! {
    /// A monitor's condition.
    pub enum MonitorKind by "kind" else ManoeuvreDone {
        /// `base_link` is in a region of `map`.
        RegionReached "region-reached" {
            /// What the region is taken from: exactly one of `area`, `zone` and `region`.
            of: RegionRef as RegionKeys,
            /// Where the region is.
            region: Rect as OwnRegion,
        },
        /// A feature was seen where it was expected, scan after scan, and is known well.
        EstimateStable "estimate-stable" {
            /// Which feature.
            feature: Feature as Word,
            /// Scans in a row.
            scans: u32 as Count::new("a number of scans", 1, 1000),
            /// Standard deviation at most this.
            max_std_m: f64 as LENGTH,
        },
        /// The skill's controller has finished.
        ManoeuvreDone "manoeuvre-done",
        /// `base_link` is too far from the controller's path.
        Deviation "deviation" {
            /// How far; left out: the area's own limit.
            limit_m: Option<f64> as Optional(LENGTH),
        },
        /// The state was entered this long ago.
        After "after" {
            /// How long.
            after_s: f64 as WAIT,
        },
    }
}

/// What a region is taken from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RegionRef {
    /// This area.
    Area(String),
    /// This perception zone.
    Zone(String),
    /// A rectangle of its own.
    Own,
}

/// The rule of [`RegionRef`]: exactly one of three keys.
pub struct RegionKeys;
/// The rule of the region itself: its own rectangle, where it is written.
pub struct OwnRegion;

impl Field<RegionKeys> for RegionRef {
    fn read(s: &dyn Source, _: &'static str, _: &RegionKeys, _: Option<Self>) -> Self {
        let area = s.text("area", "an area's id", Need::Optional);
        let zone = s.text("zone", "a perception zone's id", Need::Optional);
        match (area, zone, s.has("region")) {
            (Some(id), None, false) => Self::Area(id),
            (None, Some(id), false) => Self::Zone(id),
            (None, None, true) => Self::Own,
            (area, zone, own) => {
                let count =
                    usize::from(area.is_some()) + usize::from(zone.is_some()) + usize::from(own);
                let (fault, found) = match count {
                    0 => (Fault::Missing, "none of them".to_owned()),
                    count => (Fault::Inconsistent, format!("{count} of them")),
                };
                let expected = "exactly one of `area`, `zone` and `region`".to_owned();
                s.refuse(fault, "area", found, expected);
                Self::Own
            }
        }
    }

    fn excuse(s: &dyn Source, _: &'static str, _: &RegionKeys) {
        let _ = (s.has("area"), s.has("zone"));
    }

    fn document(
        page: &mut Page,
        _: &'static str,
        _: &RegionKeys,
        _: Option<Self>,
        _: &'static str,
    ) {
        let others = |one: &str, other: &str| Some(format!("`{one}` or `{other}`"));
        page.key(
            "area",
            "an area's id",
            others("zone", "region"),
            "The region of this area.",
        );
        let zone = "The region of this perception zone.";
        page.key(
            "zone",
            "a perception zone's id",
            others("area", "region"),
            zone,
        );
    }
}

impl Field<OwnRegion> for Rect {
    fn read(s: &dyn Source, key: &'static str, _: &OwnRegion, _: Option<Self>) -> Self {
        let own = <Option<Self> as Field<_>>::read(s, key, &Optional(Corners(POSITION)), None);
        own.unwrap_or_default()
    }

    fn document(
        page: &mut Page,
        key: &'static str,
        _: &OwnRegion,
        _: Option<Self>,
        _: &'static str,
    ) {
        let other = Some("`area` or `zone`".to_owned());
        let value = "a rectangle { min_m = [x, y], max_m = [x, y] }";
        page.key(key, value, other, "A region of its own.");
    }
}
