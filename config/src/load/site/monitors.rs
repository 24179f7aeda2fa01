//! `[monitors.<event>]`

use super::LENGTH;
use crate::choices::FEATURES;
use crate::diagnostic::ProblemKind;
use crate::geometry::Rect;
use crate::quantity::{Count, POSITION, Quantity};
use crate::reader::Section;
use crate::report::Report;
use crate::site::{Area, Feature, Monitor, MonitorKind, PerceptionZone, RegionRef};

const WAIT: Quantity = Quantity::new("a duration", "s")
    .above(0.0)
    .at_most(86_400.0);

pub(super) fn read(
    event: &str,
    s: &Section<'_>,
    areas: &[Area],
    zones: &[PerceptionZone],
    report: &Report,
) -> Monitor {
    #[derive(Clone, Copy)]
    enum Kind {
        Region,
        Stable,
        Done,
        Deviation,
        After,
    }
    let kind = s.choice(
        "kind",
        &[
            ("region-reached", Kind::Region),
            ("estimate-stable", Kind::Stable),
            ("manoeuvre-done", Kind::Done),
            ("deviation", Kind::Deviation),
            ("after", Kind::After),
        ],
    );
    let kind = match kind {
        Some(Kind::Region) => region_reached(s, areas, zones, report),
        Some(Kind::Stable) => MonitorKind::EstimateStable {
            feature: s.choice("feature", FEATURES).unwrap_or(Feature::LaneEnd),
            scans: s.integer("scans", Count::new("a number of scans", 1, 1000)),
            max_std_m: s.number("max_std_m", LENGTH),
        },
        Some(Kind::Deviation) => MonitorKind::Deviation {
            limit_m: s.number_if("limit_m", LENGTH),
        },
        Some(Kind::Done) => MonitorKind::ManoeuvreDone,
        Some(Kind::After) => MonitorKind::After {
            after_s: s.number("after_s", WAIT),
        },
        None => {
            // The kind is wrong; its parameters are not to blame.
            for key in [
                "area",
                "zone",
                "region",
                "feature",
                "scans",
                "max_std_m",
                "limit_m",
                "after_s",
            ] {
                let _ = s.has(key);
            }
            MonitorKind::ManoeuvreDone
        }
    };
    Monitor {
        event: event.to_owned(),
        kind,
    }
}

fn region_reached(
    s: &Section<'_>,
    areas: &[Area],
    zones: &[PerceptionZone],
    report: &Report,
) -> MonitorKind {
    let area = s.text_if("area", "an area's id");
    let zone = s.text_if("zone", "a perception zone's id");
    let own = s.has("region").then(|| s.rect("region", POSITION));
    // A name that nothing has is reported with the other references.
    let (region, of) = match (area, zone, own) {
        (Some(id), None, None) => {
            let region = areas
                .iter()
                .find(|area| area.id == id)
                .map(|area| area.region);
            (region.unwrap_or_default(), RegionRef::Area(id))
        }
        (None, Some(id), None) => {
            let region = zones
                .iter()
                .find(|zone| zone.id == id)
                .map(|zone| zone.region);
            (region.unwrap_or_default(), RegionRef::Zone(id))
        }
        (None, None, Some(region)) => (region, RegionRef::Own),
        (area, zone, own) => {
            let count = [area.is_some(), zone.is_some(), own.is_some()]
                .iter()
                .filter(|x| **x)
                .count();
            let (kind, found) = match count {
                0 => (ProblemKind::MissingKey, "none of them".to_owned()),
                count => (ProblemKind::Inconsistent, format!("{count} of them")),
            };
            let expected = "exactly one of `area`, `zone` and `region`";
            report.push(report.problem(kind, &s.at("area"), found, expected));
            (Rect::default(), RegionRef::Own)
        }
    };
    MonitorKind::RegionReached { region, of }
}
