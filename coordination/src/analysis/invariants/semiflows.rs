//! The non-negative solutions of minimal support of `weights · changes = 0`.

use super::work::{MADE, Work};

/// Numbers by index, in order, without zeros.
type Sparse = Vec<(u32, i64)>;

/// The most rows that are combined for one transition.
const MOST_COMBINED: usize = 20_000;
/// The most rows at any time, if there are not more places.
const MOST_ROWS: usize = 20_000;

/// Some places with weights, and what firings still change of their sum.
#[derive(Clone, Debug)]
struct Row {
    /// By transition.
    changes: Sparse,
    /// By place; all are positive.
    weights: Sparse,
}

impl Row {
    /// How many numbers it has.
    fn len(&self) -> usize {
        self.changes.len() + self.weights.len()
    }
}

/// The semiflows of minimal support, each as its places with their weights, as far as there is work left; and whether
/// these are all. `changes` are, by transition, what firing it does to places.
pub(super) fn semiflows(
    places: usize,
    changes: Vec<Vec<(u32, i64)>>,
    work: &mut Work,
) -> (Vec<Vec<(u32, u32)>>, bool) {
    let mut rows: Vec<Row> = { 0..places as u32 }
        .map(|place| Row {
            changes: Vec::new(),
            weights: vec![(place, 1)],
        })
        .collect();
    let mut left: Vec<u32> = Vec::new();
    for (transition, changes) in (0..).zip(changes) {
        for (place, change) in changes.into_iter().filter(|&(_, change)| change != 0) {
            rows[place as usize].changes.push((transition, change));
        }
        left.push(transition);
    }
    let mut is_complete = true;
    while !left.is_empty() {
        let Some(at) = cheapest(&rows, &left, work) else {
            is_complete = false;
            break;
        };
        is_complete &= eliminate(&mut rows, left.swap_remove(at), places.max(MOST_ROWS), work);
    }
    // Those that no transition changes, though not all were looked at.
    let mut found: Vec<Vec<(u32, u32)>> = { rows.into_iter() }
        .filter(|row| row.changes.is_empty())
        .filter_map(|row| {
            let weights = row.weights.into_iter();
            let small = weights.map(|(place, weight)| Some((place, u32::try_from(weight).ok()?)));
            let small: Option<Vec<_>> = small.collect();
            // One with larger weights is left out.
            is_complete &= small.is_some();
            small
        })
        .collect();
    found.sort_unstable();
    (found, is_complete)
}

/// Of the transitions `left`, one that makes few new rows; none if no transition or no work is left.
fn cheapest(rows: &[Row], left: &[u32], work: &mut Work) -> Option<usize> {
    let most = left.iter().max()?;
    let looked: usize = rows.iter().map(|row| 1 + row.changes.len()).sum();
    if !work.take(looked + *most as usize) {
        return None;
    }
    let mut signs = vec![(0_usize, 0_usize); *most as usize + 1];
    for &(transition, change) in rows.iter().flat_map(|row| &row.changes) {
        let (more, less) = &mut signs[transition as usize];
        *if change > 0 { more } else { less } += 1;
    }
    let cost = |&(_, transition): &(usize, &u32)| {
        let (more, less) = signs[*transition as usize];
        more * less
    };
    left.iter().enumerate().min_by_key(cost).map(|(at, _)| at)
}

/// Combines rows so that the transition changes none of them; false if some had to be left out, as there
/// would be more than `most`, or no work is left.
fn eliminate(rows: &mut Vec<Row>, transition: u32, most: usize, work: &mut Work) -> bool {
    let change = |row: &Row| {
        let found = row.changes.binary_search_by_key(&transition, |&(t, _)| t);
        found.map_or(0, |at| row.changes[at].1)
    };
    let (touched, mut kept): (Vec<Row>, Vec<Row>) = std::mem::take(rows)
        .into_iter()
        .partition(|row| change(row) != 0);
    let (more, less): (Vec<&Row>, Vec<&Row>) = touched.iter().partition(|row| change(row) > 0);
    let combined = more.len().saturating_mul(less.len());
    if combined > MOST_COMBINED || kept.len() + combined > most {
        *rows = kept;
        return false;
    }
    let mut is_complete = true;
    let mut new: Vec<Row> = Vec::with_capacity(combined);
    for one in &more {
        for other in &less {
            if !work.take(MADE * (one.len() + other.len())) {
                *rows = kept;
                return false;
            }
            match sum(one, -change(other), other, change(one)) {
                Some(row) => new.push(row),
                None => is_complete = false,
            }
        }
    }
    // Those with few places first: they are in others, not others in them.
    new.sort_by_key(|row| row.weights.len());
    for row in new {
        let mut has_work = true;
        let is_known = kept.iter().any(|other| {
            let (inner, outer) = (&other.weights, &row.weights);
            // A longer one is not within, which is seen at once.
            let looked = 1 + outer.len() * usize::from(inner.len() <= outer.len());
            has_work &= work.take(looked);
            !has_work || is_within(inner, outer)
        });
        if !has_work {
            is_complete = false;
            break;
        }
        if !is_known {
            kept.push(row);
        }
    }
    *rows = kept;
    is_complete
}

/// Whether all indices of `inner` are in `outer`.
fn is_within(inner: &Sparse, outer: &Sparse) -> bool {
    let mut rest = outer.iter();
    inner.len() <= outer.len()
        && inner
            .iter()
            .all(|(index, _)| rest.any(|(other, _)| other == index))
}

/// A positive combination of two rows by its smallest numbers; none if they become too large.
fn sum(one: &Row, times: i64, other: &Row, other_times: i64) -> Option<Row> {
    let mut row = Row {
        changes: weighted(&one.changes, times, &other.changes, other_times)?,
        weights: weighted(&one.weights, times, &other.weights, other_times)?,
    };
    let numbers = row.weights.iter().chain(&row.changes);
    let divisor = numbers.fold(0, |divisor, &(_, number)| {
        gcd(divisor, number.unsigned_abs())
    });
    let divisor = i64::try_from(divisor).ok()?.max(1);
    for (_, number) in row.weights.iter_mut().chain(&mut row.changes) {
        *number /= divisor;
    }
    Some(row)
}

fn weighted(one: &Sparse, times: i64, other: &Sparse, other_times: i64) -> Option<Sparse> {
    let mut sum = Vec::with_capacity(one.len() + other.len());
    let (mut one, mut other) = (one.iter().peekable(), other.iter().peekable());
    loop {
        let next = match (one.peek(), other.peek()) {
            (None, None) => return Some(sum),
            (Some(&&(index, _)), None) | (None, Some(&&(index, _))) => index,
            (Some(&&(a, _)), Some(&&(b, _))) => a.min(b),
        };
        let mut number = 0_i64;
        if let Some(&(_, own)) = one.next_if(|&&(index, _)| index == next) {
            number = own.checked_mul(times)?;
        }
        if let Some(&(_, own)) = other.next_if(|&&(index, _)| index == next) {
            number = number.checked_add(own.checked_mul(other_times)?)?;
        }
        if number != 0 {
            sum.push((next, number));
        }
    }
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn of(places: usize, changes: &[&[(u32, i64)]]) -> Vec<Vec<(u32, u32)>> {
        let changes = changes.iter().map(|changes| changes.to_vec()).collect();
        let (found, is_complete) = semiflows(places, changes, &mut Work::new(u64::MAX));
        assert!(is_complete);
        found
    }

    /// Each place is worth two of the next.
    #[test]
    fn one_whose_weights_are_too_large_is_left_out_and_told() {
        let changes = |levels: u32| -> Vec<Vec<(u32, i64)>> {
            (0..levels)
                .map(|place| vec![(place, -1), (place + 1, 2)])
                .collect()
        };
        let found = |levels: u32| {
            let places = levels as usize + 1;
            semiflows(places, changes(levels), &mut Work::new(u64::MAX))
        };
        let (small, is_complete) = found(31);
        assert_eq!((small.len(), is_complete), (1, true));
        assert_eq!(small[0][0], (0, 1 << 31));
        assert_eq!(found(33), (Vec::new(), false));
    }

    #[test]
    fn small_ones_are_as_by_hand() {
        let nothing: [Vec<(u32, u32)>; 0] = [];
        // A token that goes round, and one that comes from nowhere.
        assert_eq!(
            of(3, &[&[(0, -1), (1, 1)], &[(1, -1), (0, 1)], &[(2, 1)]]),
            [[(0, 1), (1, 1)]]
        );
        // Two tokens are made of one, and one of two.
        assert_eq!(
            of(2, &[&[(0, -1), (1, 2)], &[(1, -2), (0, 1)]]),
            [[(0, 2), (1, 1)]]
        );
        // Fork and join: each branch by itself.
        assert_eq!(
            of(
                3,
                &[&[(0, -1), (1, 1), (2, 1)], &[(0, 1), (1, -1), (2, -1)]]
            ),
            [[(0, 1), (1, 1)], [(0, 1), (2, 1)]]
        );
        assert_eq!(of(1, &[&[(0, -1)]]), nothing);
        assert_eq!(of(1, &[&[]]), [[(0, 1)]], "a place that nothing changes");
        assert_eq!(of(0, &[]), nothing);
    }

    #[test]
    fn what_is_too_much_is_left_out() {
        // Each of many ways in and each of many ways out is an invariant of its own.
        let many = 200_u32;
        let in_and_out = (0..2 * many).map(|place| (place, if place < many { 1 } else { -1 }));
        let around = (2 * many..2 * many + 2).map(|place| (place, 1));
        let changes = vec![
            in_and_out.collect(),
            { around }
                .zip([1, -1])
                .map(|((place, _), change)| (place, change))
                .collect(),
        ];
        let mut work = Work::new(u64::MAX);
        let (found, is_complete) = semiflows(2 * many as usize + 2, changes, &mut work);
        assert!(!is_complete);
        assert_eq!(
            found,
            [[(400, 1), (401, 1)]],
            "what does not touch them is found"
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2_000))]

        /// Against all sums with weights up to 2: each is a semiflow only if a found one is within it.
        #[test]
        fn all_of_minimal_support_are_found(
            changes in proptest::collection::vec(
                proptest::collection::vec(-1..=1_i64, 5), 0..6,
            ),
            work in 0..2_000_u64,
        ) {
            let sparse = |row: &Vec<i64>| (0..).zip(row.iter().copied()).collect();
            let sparse: Vec<_> = changes.iter().map(sparse).collect();
            let (found, is_complete) = semiflows(5, sparse.clone(), &mut Work::new(u64::MAX));
            prop_assert!(is_complete);
            // With less work fewer are found, and no others.
            let (some, is_complete) = semiflows(5, sparse, &mut Work::new(work));
            prop_assert!(some.iter().all(|one| found.contains(one)));
            prop_assert!(!is_complete || some == found);
            let dot = |weights: &[i64; 5], row: &Vec<i64>| -> i64 {
                weights.iter().zip(row).map(|(weight, change)| weight * change).sum()
            };
            let dense = |sparse: &Vec<(u32, u32)>| {
                let mut weights = [0; 5];
                for &(place, weight) in sparse {
                    weights[place as usize] = i64::from(weight);
                }
                weights
            };
            let found: Vec<[i64; 5]> = found.iter().map(dense).collect();
            let within = |one: &[i64; 5], other: &[i64; 5]| {
                one.iter().zip(other).all(|(&a, &b)| a == 0 || b > 0)
            };
            for (number, one) in found.iter().enumerate() {
                prop_assert!(changes.iter().all(|row| dot(one, row) == 0));
                let mut others = found.iter().enumerate().filter(|&(other, _)| other != number);
                prop_assert!(others.all(|(_, other)| !within(other, one)), "{found:?}");
            }
            for number in 1..3_usize.pow(5) {
                let weights = [0, 1, 2, 3, 4].map(|place| (number / 3_usize.pow(place) % 3) as i64);
                if changes.iter().all(|row| dot(&weights, row) == 0) {
                    prop_assert!(found.iter().any(|one| within(one, &weights)), "{weights:?}");
                }
            }
        }
    }
}
