//! What is promised of figures, and whether this run keeps it. `TIMING.md` lists the same.

use std::fmt;

use serde::Serialize;

use super::samples::Figures;

/// A figure of ours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// The median,
    P50,
    /// the 99th percentile,
    P99,
    /// the 99.9th,
    P999,
    /// or the largest.
    Max,
}

/// What it must not be above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Most {
    /// So much, in the unit of its group.
    Value(f64),
    /// So many times the same figure of the rival.
    TimesRival(f64),
}

/// What is promised of a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Promise(pub Figure, pub Most);

/// A promise, and what became of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judged {
    /// In words.
    pub promise: String,
    /// What it is held against: the figure in its unit, or in multiples of the rival's. None where there were too few samples, or no rival.
    pub found: Option<f64>,
    /// Whether it was kept, if that is known.
    pub kept: Option<bool>,
}

impl Promise {
    /// Whether ours keeps it, in this unit, beside the rival of this name, if there is one.
    #[must_use]
    pub fn judge(&self, ours: &Figures, rival: Option<(&str, &Figures)>, unit: &str) -> Judged {
        let Self(figure, most) = *self;
        let ours = figure.of(ours);
        let (found, limit, promise) = match most {
            Most::Value(most) => (ours, most, format!("{figure} at most {most} {unit}")),
            Most::TimesRival(most) => {
                let name = rival.map_or("the rival", |(name, _)| name);
                let own = rival.and_then(|(_, figures)| figure.of(figures));
                let found = own.filter(|own| *own > 0.0).zip(ours);
                let promise = format!("{figure} at most {most} times that of {name}");
                (found.map(|(own, ours)| ours / own), most, promise)
            }
        };
        Judged {
            promise,
            found,
            kept: found.map(|found| found <= limit),
        }
    }
}

impl Figure {
    fn of(self, figures: &Figures) -> Option<f64> {
        match self {
            Self::P50 => figures.p50,
            Self::P99 => figures.p99,
            Self::P999 => figures.p999,
            Self::Max => figures.max,
        }
    }
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::P50 => "p50",
            Self::P99 => "p99",
            Self::P999 => "p99.9",
            Self::Max => "max",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures(p50: f64, p99: Option<f64>) -> Figures {
        Figures {
            p50: Some(p50),
            p99,
            ..Figures::default()
        }
    }

    #[test]
    fn a_promise_is_kept_up_to_its_limit() {
        let (ours, soem) = (figures(3.0, Some(8.0)), figures(2.0, Some(8.0)));
        let judged = |promise: Promise| promise.judge(&ours, Some(("SOEM", &soem)), "µs");
        let value = |most| judged(Promise(Figure::P50, Most::Value(most)));
        assert_eq!(
            (value(3.0).kept, value(2.9).kept),
            (Some(true), Some(false))
        );
        assert_eq!(value(3.0).promise, "p50 at most 3 µs");
        let median = judged(Promise(Figure::P50, Most::TimesRival(1.2)));
        assert_eq!((median.found, median.kept), (Some(1.5), Some(false)));
        assert_eq!(median.promise, "p50 at most 1.2 times that of SOEM");
        let tail = judged(Promise(Figure::P99, Most::TimesRival(1.0)));
        assert_eq!((tail.found, tail.kept), (Some(1.0), Some(true)));
    }

    #[test]
    fn nothing_is_known_of_too_few_samples_nor_beside_nobody() {
        for promise in [
            Promise(Figure::P99, Most::Value(8.0)),
            Promise(Figure::P999, Most::Value(8.0)),
            Promise(Figure::P50, Most::TimesRival(1.0)),
        ] {
            let judged = promise.judge(&figures(3.0, None), None, "ms");
            assert_eq!((judged.found, judged.kept), (None, None), "{promise:?}");
        }
    }
}
