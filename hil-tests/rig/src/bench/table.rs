//! A report for people.

use super::promises::Judged;
use super::report::{Group, PartReport, Ratios, Row};

/// The lines of a part.
#[must_use]
pub fn lines(part: &PartReport) -> Vec<String> {
    let mut lines = Vec::new();
    for group in &part.groups {
        lines.push(head(group));
        lines.extend(group.rows.iter().map(row));
        lines.extend(group.promises.iter().map(promise));
        if group.stalls.count > 0 || group.stalls.steal_ms > 0.0 {
            let (stalls, steal_ms) = (group.stalls, group.stalls.steal_ms);
            lines.push(format!(
                "    ({stalls}; the host took {steal_ms:.0} ms of all cores)"
            ));
        }
    }
    lines.extend(part.notes.iter().map(|note| format!("  note: {note}")));
    let failure = { part.failure.iter() }.map(|why| format!("  ended early: {why}"));
    lines.extend(failure);
    lines
}

fn head(group: &Group) -> String {
    format!(
        "  {:<52} {:>9} {:>9} {:>9} {:>9} {:>9} {:>7} {:>9}  ours is",
        format!("{}, {}", group.title, group.unit.name()),
        "samples",
        "p50",
        "p99",
        "p99.9",
        "max",
        "stalled",
        "max",
    )
}

fn row(row: &Row) -> String {
    let own = &row.figures;
    let line = format!(
        "    {:<50} {:>9} {:>9} {:>9} {:>9} {:>9} {:>7} {:>9}  {}",
        row.name,
        own.samples,
        figure(own.p50),
        figure(own.p99),
        figure(own.p999),
        figure(own.max),
        own.apart,
        figure(own.apart_max),
        row.ours_is.as_ref().map(ratios).unwrap_or_default(),
    );
    line.trim_end().to_owned()
}

fn promise(judged: &Judged) -> String {
    let outcome = match judged.kept {
        Some(true) => "kept",
        Some(false) => "MISSED",
        None => "not measured",
    };
    let found = judged
        .found
        .map(|found| format!(": {}", figure(Some(found))));
    let found = found.unwrap_or_default();
    format!("    promised {}, {outcome}{found}", judged.promise)
}

/// With three digits or more.
fn figure(value: Option<f64>) -> String {
    match value {
        None => "-".to_owned(),
        Some(value) if value.abs() >= 100.0 => format!("{value:.0}"),
        Some(value) if value.abs() >= 10.0 => format!("{value:.1}"),
        Some(value) => format!("{value:.2}"),
    }
}

fn ratios(ratios: &Ratios) -> String {
    let all = [
        ("p50", ratios.p50),
        ("p99", ratios.p99),
        ("p99.9", ratios.p999),
    ];
    let known = { all.into_iter() }
        .filter_map(|(name, ratio)| ratio.map(|ratio| format!("{ratio:.2} of its {name}")));
    known.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::promises::{Figure, Most, Promise};
    use crate::bench::report::{Unit, What};
    use crate::bench::samples::{ENOUGH_FOR_P99, Samples};
    use crate::stalls::Stalls;

    #[test]
    fn a_part_is_shown_with_what_is_missing() {
        // The first of them once, and the last so often that there is a 99th percentile.
        let samples = |first: f64, last: f64| Samples {
            kept: [vec![first], vec![last; ENOUGH_FOR_P99]].concat(),
            apart: vec![6e6],
        };
        let measured = [
            ("onboard".to_owned(), samples(123_456.0, 4_000.0)),
            ("cyclictest".to_owned(), samples(2_000.0, 8_000.0)),
        ];
        let stalls = Stalls {
            count: 1,
            longest_ms: 6.0,
            steal_ms: 20.0,
            ..Stalls::default()
        };
        let promises = [
            Promise(Figure::P99, Most::TimesRival(0.4)),
            Promise(Figure::P999, Most::Value(9.0)),
        ];
        let what = What::new("idle", Unit::Us).promising(&promises);
        let part = PartReport {
            part: "wakeup".to_owned(),
            groups: vec![Group::new(&what, &measured, stalls, false)],
            notes: vec!["no priority".to_owned()],
            failure: Some("no more time".to_owned()),
            took_s: 1.0,
        };
        let words = |line: &String| line.split_whitespace().collect::<Vec<_>>().join(" ");
        let lines: Vec<String> = lines(&part).iter().map(words).collect();
        let expected = [
            "idle, µs samples p50 p99 p99.9 max stalled max ours is",
            "onboard 101 4.00 4.00 - 123 1 6000",
            "cyclictest 101 8.00 8.00 - 8.00 1 6000 0.50 of its p50, 0.50 of its p99",
            "promised p99 at most 0.4 times that of cyclictest, MISSED: 0.50",
            "promised p99.9 at most 9 µs, not measured",
            "(the machine stalled 1 times, 6 ms at most; the host took 20 ms of all cores)",
            "note: no priority",
            "ended early: no more time",
        ];
        assert_eq!(lines, expected);
    }
}
