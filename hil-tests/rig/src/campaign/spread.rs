//! Figures of many runs of the real programs, put together.

use serde::Serialize;

use crate::percentile::Ranked;
use crate::summary::Latency;

/// Least, median by nearest rank, and most.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(super) struct Spread {
    pub(super) min: f64,
    pub(super) p50: f64,
    pub(super) max: f64,
}

/// That of these.
pub(super) fn spread(values: &[f64]) -> Spread {
    let ranked = Ranked::of(values.iter().copied());
    let at = |share: f64| ranked.at(share).unwrap_or_default();
    Spread {
        min: at(0.0),
        p50: at(0.5),
        max: at(1.0),
    }
}

/// Of all runs: the median of their medians, and the largest of each other figure.
pub(super) fn together<'a>(latencies: impl Iterator<Item = &'a Latency> + Clone) -> Latency {
    let largest = |of: fn(&Latency) -> Option<f64>| {
        latencies
            .clone()
            .filter_map(of)
            .max_by(|a, b| a.total_cmp(b))
    };
    let medians = latencies.clone().filter_map(|own| own.p50_ms);
    Latency {
        count: latencies.clone().map(|own| own.count).sum(),
        p50_ms: Ranked::of(medians).at(0.5),
        p99_ms: largest(|own| own.p99_ms),
        max_ms: largest(|own| own.max_ms),
    }
}
