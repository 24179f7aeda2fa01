//! The words that stand for choices in files.

use crate::site::{Feature, Manoeuvre, TurnDirection};
use crate::threads::{ActivityKind, Core};

pub(crate) const MANOEUVRES: &[(&str, Manoeuvre)] = &[
    (Manoeuvre::Forward.name(), Manoeuvre::Forward),
    (Manoeuvre::UTurn.name(), Manoeuvre::UTurn),
    (Manoeuvre::Stop.name(), Manoeuvre::Stop),
    (Manoeuvre::Turn.name(), Manoeuvre::Turn),
    (Manoeuvre::Dock.name(), Manoeuvre::Dock),
    (Manoeuvre::Any.name(), Manoeuvre::Any),
];

pub(crate) const FEATURES: &[(&str, Feature)] = &[
    (Feature::Corridor.name(), Feature::Corridor),
    (Feature::LaneEnd.name(), Feature::LaneEnd),
    (Feature::Walls.name(), Feature::Walls),
];

pub(crate) const DIRECTIONS: &[(&str, TurnDirection)] = &[
    ("left", TurnDirection::Left),
    ("right", TurnDirection::Right),
];

pub(crate) const CORES: &[(&str, Core)] = &[
    ("any", Core::Any),
    ("big", Core::Big),
    ("little", Core::Little),
];

/// The rates that the sensor offers.
pub(crate) const BIT_RATES: &[u32] = &[19_200, 57_600, 115_200, 250_000, 500_000, 750_000];

pub(crate) fn activities() -> Vec<(&'static str, ActivityKind)> {
    ActivityKind::ALL
        .iter()
        .map(|kind| (kind.name(), *kind))
        .collect()
}
