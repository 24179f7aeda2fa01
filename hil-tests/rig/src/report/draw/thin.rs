//! Fewer points for the same picture.

use super::canvas::Px2;

/// Indices of points that are at least a given distance apart; the first and the last are always among them.
///
/// Points nearer than `spacing_px` to the last one kept are left out; more laps than `most` points can show are
/// drawn more coarsely.
pub(in crate::report) fn apart(points: &[Px2], spacing_px: f64, most: usize) -> Vec<usize> {
    let mut spacing_px = spacing_px;
    loop {
        let kept = kept(points, spacing_px);
        if kept.len() <= most.max(2) {
            return kept;
        }
        spacing_px *= 2.0;
    }
}

fn kept(points: &[Px2], spacing_px: f64) -> Vec<usize> {
    let mut kept: Vec<usize> = Vec::new();
    for (index, point) in points.iter().enumerate() {
        let far = kept
            .last()
            .is_none_or(|&last| distance_px(points[last], *point) >= spacing_px);
        if far {
            kept.push(index);
        }
    }
    if kept.last().is_some_and(|&last| last + 1 < points.len()) {
        kept.push(points.len() - 1);
    }
    kept
}

/// Distance of two places.
pub(in crate::report) fn distance_px(a: Px2, b: Px2) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The lowest and highest value that fell on one column of a chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::report) struct Column {
    /// Column, from the left.
    pub(in crate::report) index: usize,
    /// Lowest value.
    pub(in crate::report) low: f64,
    /// Highest value.
    pub(in crate::report) high: f64,
    /// The first value came before the last one and was lower: the curve rises within the column.
    pub(in crate::report) rises: bool,
}

/// Columns of a curve, from (share of the width, value) in order; peaks survive. Values that are no numbers are left
/// out.
pub(in crate::report) fn columns(
    points: impl Iterator<Item = (f64, f64)>,
    count: usize,
) -> Vec<Column> {
    let mut columns: Vec<Column> = Vec::new();
    let mut first = 0.0;
    for (share, value) in points {
        if !(value.is_finite() && (0.0..=1.0).contains(&share)) {
            continue;
        }
        let index = ((share * count as f64) as usize).min(count.saturating_sub(1));
        match columns.last_mut().filter(|column| column.index == index) {
            Some(column) => {
                column.low = column.low.min(value);
                column.high = column.high.max(value);
                column.rises = value >= first;
            }
            None => {
                first = value;
                columns.push(Column {
                    index,
                    low: value,
                    high: value,
                    rises: true,
                });
            }
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_kept_and_the_bound_holds() {
        let points: Vec<Px2> = (0..100_000).map(|index| [f64::from(index), 0.0]).collect();
        let kept = apart(&points, 1.5, 500);
        assert!(kept.len() <= 500 && kept.len() > 200, "{}", kept.len());
        assert_eq!((kept.first(), kept.last()), (Some(&0), Some(&99_999)));
        assert_eq!(apart(&[], 1.0, 10), Vec::<usize>::new());
        assert_eq!(apart(&[[0.0; 2]; 50], 1.0, 10), [0, 49]);
    }

    #[test]
    fn a_peak_of_one_point_survives() {
        let points = (0..10_000).map(|index| {
            let value = if index == 5_000 { 9.0 } else { 1.0 };
            (f64::from(index) / 1e4, value)
        });
        let columns = columns(points, 100);
        assert_eq!(columns.len(), 100);
        assert_eq!((columns[50].low, columns[50].high), (1.0, 9.0));
    }

    #[test]
    fn what_is_no_number_leaves_a_gap() {
        let values = [1.0, f64::NAN, f64::INFINITY, 2.0];
        let points = values
            .iter()
            .enumerate()
            .map(|(index, value)| (index as f64 / 3.0, *value));
        let indices: Vec<usize> = columns(points, 4)
            .iter()
            .map(|column| column.index)
            .collect();
        assert_eq!(indices, [0, 3]);
    }
}
