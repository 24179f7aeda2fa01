//! What was measured of one contender under one condition.

use std::ops::Range;

use serde::Serialize;

use crate::percentile::Ranked;
use crate::stalls::STALL_NS;

/// Samples before a 99th percentile is another than the largest,
pub const ENOUGH_FOR_P99: usize = 100;
/// and before a 99.9th percentile is worth printing: a thousand lie beyond it.
pub const ENOUGH_FOR_P999: usize = 1_000_000;

/// One measurement of a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// When it began and ended, on the monotonic clock, if that is known.
    pub when_ns: Option<(u64, u64)>,
    /// How long it took, nanoseconds: all of that, or the mean of what was done meanwhile. Or what else was measured, in its unit.
    pub value: f64,
}

impl Sample {
    /// One thing, from when to when.
    #[must_use]
    pub fn from_to(began_ns: u64, ended_ns: u64) -> Self {
        Self::mean_of(1, began_ns, ended_ns)
    }

    /// The mean of so many, one after the other.
    #[must_use]
    pub fn mean_of(count: u64, began_ns: u64, ended_ns: u64) -> Self {
        Self {
            when_ns: Some((began_ns, ended_ns)),
            value: ended_ns.saturating_sub(began_ns) as f64 / count.max(1) as f64,
        }
    }

    /// What was measured from when to when, in its own unit.
    #[must_use]
    pub fn during(value: f64, began_ns: u64, ended_ns: u64) -> Self {
        Self {
            when_ns: Some((began_ns, ended_ns)),
            value,
        }
    }

    /// One of which nobody knows when it was.
    #[must_use]
    pub fn sometime(value: f64) -> Self {
        Self {
            when_ns: None,
            value,
        }
    }

    /// How late something was, in whole µs, as `cyclictest` counts, and without a time, which it does not tell.
    #[must_use]
    pub fn counted_in_us(late_ns: u64) -> Self {
        Self::sometime((late_ns / 1_000 * 1_000) as f64)
    }

    fn lies_in(&self, stall: &Range<u64>) -> bool {
        match self.when_ns {
            Some((began_ns, ended_ns)) => stall.start <= ended_ns && stall.end >= began_ns,
            None => self.value >= STALL_NS as f64,
        }
    }
}

/// What a contender's samples come to, in the unit of its group. Those in which the machine's own stalls lie are kept apart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    /// Undisturbed.
    pub kept: Vec<f64>,
    /// While a core was gone.
    pub apart: Vec<f64>,
}

impl Samples {
    /// Adds times of a window, in nanoseconds, beside the stalls of that window, each from when to when on the monotonic clock. A sample
    /// of which it is not known when it ended lies in a stall if it is as long as one and there was one.
    pub fn add(&mut self, window: &[Sample], stalls: &[Range<u64>]) {
        for sample in window {
            let stalled = stalls.iter().any(|stall| sample.lies_in(stall));
            let into = if stalled {
                &mut self.apart
            } else {
                &mut self.kept
            };
            into.push(sample.value);
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty() && self.apart.is_empty()
    }

    /// Their figures, divided by this; with a 99.9th percentile of a million samples, if that is wanted.
    #[must_use]
    pub fn figures(&self, divisor: f64, thousandth: bool) -> Figures {
        let ranked = |values: &[f64]| Ranked::of(values.iter().map(|value| value / divisor));
        let (kept, apart) = (ranked(&self.kept), ranked(&self.apart));
        let hundredth = kept.count() >= ENOUGH_FOR_P99;
        let thousandth = thousandth && kept.count() >= ENOUGH_FOR_P999;
        Figures {
            samples: kept.count(),
            p50: kept.at(0.5),
            p99: hundredth.then(|| kept.at(0.99)).flatten(),
            p999: thousandth.then(|| kept.at(0.999)).flatten(),
            max: kept.at(1.0),
            apart: apart.count(),
            apart_max: apart.at(1.0),
        }
    }
}

/// Percentiles, by nearest rank, in the unit of their group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// How many samples these are of.
    pub samples: usize,
    /// The median,
    pub p50: Option<f64>,
    /// the 99th percentile, where there are a hundred samples,
    pub p99: Option<f64>,
    /// the 99.9th, of a long run where there are a million samples,
    pub p999: Option<f64>,
    /// and the largest.
    pub max: Option<f64>,
    /// Samples in which the machine stalled, which are not among the others,
    pub apart: usize,
    /// and the largest of those.
    pub apart_max: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_of_what_no_stall_lies_in() {
        let window = [
            Sample::from_to(1_000, 2_000),
            Sample::from_to(2_500, 3_500),
            Sample::from_to(3_900, 4_000),
            Sample::from_to(4_500, 6_500),
            Sample::from_to(6_500, 7_000),
            // Short each, but all of them together were not.
            Sample::mean_of(1_000, 2_900, 5_900),
        ];
        let mut samples = Samples::default();
        samples.add(&window, std::slice::from_ref(&(3_000..5_000)));
        assert_eq!(samples.kept, [1_000.0, 500.0]);
        assert_eq!(samples.apart, [1_000.0, 100.0, 2_000.0, 3.0]);
        let figures = samples.figures(1_000.0, true);
        assert_eq!((figures.samples, figures.p50), (2, Some(0.5)));
        assert_eq!((figures.max, figures.p999), (Some(1.0), None));
        assert_eq!((figures.apart, figures.apart_max), (4, Some(2.0)));
    }

    #[test]
    fn a_long_sample_lies_in_a_stall_where_nobody_knows_when_it_was() {
        let window = [STALL_NS, STALL_NS - 1].map(|took_ns| Sample::sometime(took_ns as f64));
        let counts = |stalls: &[Range<u64>]| {
            let mut samples = Samples::default();
            samples.add(&window, stalls);
            (samples.kept.len(), samples.apart.len())
        };
        assert_eq!(counts(&[]), (2, 0));
        assert_eq!(counts(std::slice::from_ref(&(10..20))), (1, 1));
    }

    #[test]
    fn percentiles_are_asked_for_of_enough_samples_only() {
        let of = |count: usize| Samples {
            kept: vec![1.0; count],
            apart: Vec::new(),
        };
        assert_eq!(of(ENOUGH_FOR_P999 - 1).figures(1.0, true).p999, None);
        assert_eq!(of(ENOUGH_FOR_P999).figures(1.0, true).p999, Some(1.0));
        assert_eq!(of(ENOUGH_FOR_P999).figures(1.0, false).p999, None);
        assert_eq!(of(ENOUGH_FOR_P99 - 1).figures(1.0, true).p99, None);
        assert_eq!(of(ENOUGH_FOR_P99).figures(1.0, true).p99, Some(1.0));
        assert_eq!(Samples::default().figures(1.0, true), Figures::default());
    }
}
