//! What a run of `rig bench` leaves, for programs: `bench.json`.

use serde::{Serialize, Serializer};

use super::promises::{Judged, Promise};
use super::samples::{Figures, Samples};
use crate::machine::Machine;
use crate::stalls::Stalls;

/// What figures are in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Nanoseconds.
    Ns,
    /// Microseconds.
    Us,
    /// Milliseconds.
    Ms,
    /// Seconds.
    S,
    /// Mebibytes.
    MiB,
    /// Hundredths of one core.
    Percent,
}

impl Unit {
    /// As it is written.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ns => "ns",
            Self::Us => "µs",
            Self::Ms => "ms",
            Self::S => "s",
            Self::MiB => "MiB",
            Self::Percent => "% of a core",
        }
    }

    /// What samples are divided by to come to it: times are measured in nanoseconds, all else in its own unit.
    #[must_use]
    pub fn divisor(self) -> f64 {
        match self {
            Self::Ns | Self::MiB | Self::Percent => 1.0,
            Self::Us => 1e3,
            Self::Ms => 1e6,
            Self::S => 1e9,
        }
    }
}

impl Serialize for Unit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// Ours in multiples of a rival's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Ratios {
    /// Of the medians,
    pub p50: Option<f64>,
    /// of the 99th percentiles,
    pub p99: Option<f64>,
    /// and of the 99.9th, where there are such.
    pub p999: Option<f64>,
}

impl Ratios {
    fn of(ours: &Figures, rival: &Figures) -> Self {
        let ratio = |ours: Option<f64>, rival: Option<f64>| {
            let rival = rival.filter(|value| *value > 0.0)?;
            Some(ours? / rival)
        };
        Self {
            p50: ratio(ours.p50, rival.p50),
            p99: ratio(ours.p99, rival.p99),
            p999: ratio(ours.p999, rival.p999),
        }
    }
}

/// A contender.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// What it is called.
    pub name: String,
    /// What was measured.
    #[serde(flatten)]
    pub figures: Figures,
    /// What ours is in multiples of this one, if this is a rival.
    pub ours_is: Option<Ratios>,
}

/// What is measured.
#[derive(Clone, Copy, Debug)]
pub struct What<'a> {
    /// The condition.
    pub title: &'a str,
    /// Of all figures.
    pub unit: Unit,
    /// Of ours.
    pub promises: &'a [Promise],
}

impl<'a> What<'a> {
    /// Something of which nothing is promised.
    #[must_use]
    pub fn new(title: &'a str, unit: Unit) -> Self {
        let promises = &[];
        Self {
            title,
            unit,
            promises,
        }
    }

    /// With what is promised of it.
    #[must_use]
    pub fn promising(self, promises: &'a [Promise]) -> Self {
        Self { promises, ..self }
    }
}

/// Contenders under one condition.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Group {
    /// The condition.
    pub title: String,
    /// Of all figures.
    pub unit: Unit,
    /// Ours first.
    pub rows: Vec<Row>,
    /// What is promised of ours.
    pub promises: Vec<Judged>,
    /// The machine's own stalls meanwhile.
    pub stalls: Stalls,
}

impl Group {
    /// Of what was measured of each contender, ours first.
    #[must_use]
    pub fn new(
        what: &What,
        measured: &[(String, Samples)],
        stalls: Stalls,
        thousandth: bool,
    ) -> Self {
        let unit = what.unit;
        let figures = |samples: &Samples| samples.figures(unit.divisor(), thousandth);
        let ours = measured.first().map(|(_, samples)| figures(samples));
        let row = |(number, (name, samples)): (usize, &(String, Samples))| {
            let figures = figures(samples);
            let ours = ours.as_ref().filter(|_| number > 0);
            Row {
                name: name.clone(),
                figures,
                ours_is: ours.map(|ours| Ratios::of(ours, &figures)),
            }
        };
        let rows: Vec<Row> = measured.iter().enumerate().map(row).collect();
        let rival = { rows.get(1) }.map(|row| (row.name.as_str(), &row.figures));
        let judged = |ours: &Figures| {
            let promises = what.promises.iter();
            promises
                .map(|promise| promise.judge(ours, rival, unit.name()))
                .collect()
        };
        Self {
            title: what.title.to_owned(),
            unit,
            promises: ours.as_ref().map(judged).unwrap_or_default(),
            rows,
            stalls,
        }
    }
}

/// A part of the run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PartReport {
    /// What it is called on the command line.
    pub part: String,
    /// What was measured.
    pub groups: Vec<Group>,
    /// What was left out, or measured otherwise than it should be, and why.
    pub notes: Vec<String>,
    /// Why it ended early, if it did.
    pub failure: Option<String>,
    /// How long it took, waiting and preparing included.
    pub took_s: f64,
}

/// A whole run.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Where.
    pub machine: Machine,
    /// Whether it was a long run.
    pub long: bool,
    /// Whether the programs were built with optimisation throughout.
    pub optimised: bool,
    /// In the order in which they ran.
    pub parts: Vec<PartReport>,
    /// The machine's own stalls, of the whole run.
    pub stalls: Stalls,
    /// Whether it was told to end before its end.
    pub interrupted: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::samples::ENOUGH_FOR_P99;

    #[test]
    fn rivals_say_what_ours_is_in_multiples_of_them() {
        let of = |name: &str, took_ns: f64| {
            let samples = Samples {
                kept: vec![took_ns; ENOUGH_FOR_P99],
                apart: vec![9e6],
            };
            (name.to_owned(), samples)
        };
        let measured = [of("ours", 3_000.0), of("rival", 2_000.0), of("none", 0.0)];
        let group = Group::new(
            &What::new("idle", Unit::Us),
            &measured,
            Stalls::default(),
            false,
        );
        let [ours, rival, none] = &group.rows[..] else {
            panic!("{group:?}")
        };
        assert_eq!((ours.ours_is, ours.figures.p50), (None, Some(3.0)));
        assert_eq!(rival.ours_is.and_then(|ratios| ratios.p99), Some(1.5));
        assert_eq!(rival.figures.apart_max, Some(9_000.0));
        assert_eq!(none.ours_is, Some(Ratios::default()));
        let json = serde_json::to_value(&group).expect("JSON");
        assert_eq!(json["unit"], "µs");
        assert_eq!(json["rows"][1]["p50"], 2.0);
        assert_eq!(json["rows"][1]["ours_is"]["p50"], 1.5);
    }
}
