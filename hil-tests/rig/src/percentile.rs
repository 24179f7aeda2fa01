//! Medians and percentiles, by one rule: nearest rank.

/// Measured values, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ranked(Vec<f64>);

impl Ranked {
    /// Of these values, in any order.
    #[must_use]
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        Self(sorted)
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// The least value that at least this share of all values does not exceed: always one that was measured. 0.5 is the
    /// median, of an even number the lower of the two in the middle; 0 gives the least value, 1 the largest. None without
    /// values.
    #[must_use]
    pub fn at(&self, share: f64) -> Option<f64> {
        // What a share of a whole number loses in rounding is no rank of its own.
        const ROUNDING: f64 = 1e-9;
        let rank = (share * self.0.len() as f64 - ROUNDING).ceil() as usize;
        let last = self.0.len().checked_sub(1)?;
        self.0.get(rank.saturating_sub(1).min(last)).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rank_is_the_nearest_that_is_not_below_the_share() {
        let hundred = Ranked::of((1..=100).rev().map(f64::from));
        for (share, expected) in [
            (0.0, 1.0),
            (0.07, 7.0),
            (0.5, 50.0),
            (0.501, 51.0),
            (0.99, 99.0),
            (1.0, 100.0),
        ] {
            assert_eq!(hundred.at(share), Some(expected), "{share}");
        }
        let few = Ranked::of([30.0, 10.0, 20.0]);
        assert_eq!(few.count(), 3);
        let shares = [0.0, 0.3, 0.34, 0.5, 0.67, 0.99, 1.0];
        let expected = [10.0, 10.0, 20.0, 20.0, 30.0, 30.0, 30.0];
        assert_eq!(shares.map(|share| few.at(share)), expected.map(Some));
        assert_eq!(Ranked::of([4.0, 2.0]).at(0.5), Some(2.0));
        assert_eq!(Ranked::default().at(0.5), None);
    }
}
