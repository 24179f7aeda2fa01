//! A preallocated histogram of durations, plain data so that it can lie in the symbol table.
//!
//! Logarithmic octaves with 16 linear steps each: quantiles are exact to 1/16, the maximum is exact.
//! It is our own because a histogram in shared memory must be plain, fixed-size data without pointers.

use bytemuck::{Pod, Zeroable};
use serde::{Serialize, Serializer};

/// Linear steps in an octave, as a power of two.
const STEPS_LOG2: u32 = 4;
const STEPS: usize = 1 << STEPS_LOG2;
/// Durations below this one share the first octave's linear steps.
const FLOOR_LOG2: u32 = 8;
const OCTAVES: usize = 24;
/// Number of buckets: up to 2^32 ns, a little over four seconds.
pub const BUCKETS: usize = STEPS * (OCTAVES + 1);

/// Counts of durations in nanoseconds.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Histogram {
    count: u64,
    max_ns: u64,
    buckets: [u32; BUCKETS],
}

impl Default for Histogram {
    fn default() -> Self {
        Self::zeroed()
    }
}

impl Serialize for Histogram {
    /// Quantiles, in microseconds.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Quantiles {
            p50: f64,
            p99: f64,
            p999: f64,
            max: f64,
        }
        let us = |ns: u64| ns as f64 / 1000.0;
        Quantiles {
            p50: us(self.quantile_ns(0.5)),
            p99: us(self.quantile_ns(0.99)),
            p999: us(self.quantile_ns(0.999)),
            max: us(self.max_ns()),
        }
        .serialize(serializer)
    }
}

impl Histogram {
    /// Adds one duration. Constant time, no allocation.
    pub fn record(&mut self, duration_ns: u64) {
        self.count += 1;
        self.max_ns = self.max_ns.max(duration_ns);
        let bucket = &mut self.buckets[bucket_of(duration_ns)];
        *bucket = bucket.saturating_add(1);
    }

    /// What was recorded since this was `before`; its longest duration is known as closely as its quantiles.
    #[must_use]
    pub fn since(&self, before: &Self) -> Self {
        let added = |bucket: usize| self.buckets[bucket].saturating_sub(before.buckets[bucket]);
        let longest = (0..BUCKETS).rev().find(|&bucket| added(bucket) > 0);
        Self {
            count: self.count.saturating_sub(before.count),
            max_ns: longest.map_or(0, |bucket| upper_edge_ns(bucket).min(self.max_ns)),
            buckets: std::array::from_fn(added),
        }
    }

    /// How many durations were recorded.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The longest duration.
    #[must_use]
    pub fn max_ns(&self) -> u64 {
        self.max_ns
    }

    /// The duration that a share `quantile` (0 to 1) of all did not exceed, rounded up to its bucket's upper edge.
    #[must_use]
    pub fn quantile_ns(&self, quantile: f64) -> u64 {
        let wanted = (self.count as f64 * quantile.clamp(0.0, 1.0))
            .ceil()
            .max(1.0) as u64;
        let mut seen = 0;
        for (index, &count) in self.buckets.iter().enumerate() {
            seen += u64::from(count);
            if seen >= wanted {
                return upper_edge_ns(index).min(self.max_ns);
            }
        }
        self.max_ns
    }
}

fn bucket_of(duration_ns: u64) -> usize {
    let floor = 1_u64 << FLOOR_LOG2;
    if duration_ns < floor {
        return (duration_ns >> (FLOOR_LOG2 - STEPS_LOG2)) as usize;
    }
    let octave = duration_ns.ilog2();
    let step = (duration_ns >> (octave - STEPS_LOG2)) as usize & (STEPS - 1);
    (((octave - FLOOR_LOG2 + 1) as usize) * STEPS + step).min(BUCKETS - 1)
}

fn upper_edge_ns(bucket: usize) -> u64 {
    let (octave, step) = (bucket / STEPS, (bucket % STEPS) as u64);
    if octave == 0 {
        return (step + 1) << (FLOOR_LOG2 - STEPS_LOG2);
    }
    let shift = octave as u32 - 1 + FLOOR_LOG2 - STEPS_LOG2;
    (STEPS as u64 + step + 1) << shift
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn an_empty_histogram_reads_zero() {
        let empty = Histogram::default();
        assert_eq!(
            (empty.count(), empty.max_ns(), empty.quantile_ns(0.99)),
            (0, 0, 0)
        );
    }

    #[test]
    fn what_was_recorded_since_is_told_apart_from_what_was_before() {
        let mut before = Histogram::default();
        for duration_ns in [1_000, 9_000_000] {
            before.record(duration_ns);
        }
        let mut now = before;
        for duration_ns in [300, 300, 5_000] {
            now.record(duration_ns);
        }
        let since = now.since(&before);
        assert_eq!(since.count(), 3);
        assert!((300..320).contains(&since.quantile_ns(0.5)));
        assert!((5_000..5_320).contains(&since.max_ns()));
        assert_eq!(since.quantile_ns(1.0), since.max_ns());
        let nothing = now.since(&now);
        assert_eq!((nothing.count(), nothing.max_ns()), (0, 0));
    }

    proptest! {
        #[test]
        fn a_duration_lies_in_its_bucket(duration_ns in 0_u64..1 << 32) {
            let bucket = bucket_of(duration_ns);
            prop_assert!(duration_ns < upper_edge_ns(bucket));
            prop_assert!(bucket == 0 || upper_edge_ns(bucket - 1) <= duration_ns);
        }

        #[test]
        fn quantiles_are_exact_to_a_sixteenth(mut durations in prop::collection::vec(256_u64..1 << 30, 1..200), q in 0.0_f64..1.0) {
            let mut histogram = Histogram::default();
            durations.iter().for_each(|&d| histogram.record(d));
            durations.sort_unstable();
            let rank = (durations.len() as f64 * q).ceil().max(1.0) as usize - 1;
            let (exact, found) = (durations[rank], histogram.quantile_ns(q));
            prop_assert!(found >= exact && found as f64 <= exact as f64 * (1.0 + 1.0 / 16.0) + 1.0);
        }
    }
}
